/* Written by `preslide export`; do not edit, export again. */
/* Model plain.toml, SHA-256 535d5c199821e67eb0aee4839521c0150cc475e3aee32a9f1dd344b4e62f2a53. */

#include "stage_model.h"

/* Units of length in a displacement of 1. */
#define LENGTH 16777216
/* All blocks slipping, in units of force. */
#define LIMIT 943715169
/* Twice the displacement at which each slips, in units of length. */
static const int32_t FULLS[STAGE_MODEL_BLOCKS] = { 3266, 26148 };
/* Stiffness of each block, in units of force per unit of length. */
static const int32_t STIFFNESSES[STAGE_MODEL_BLOCKS] = { 355989, 27718 };


/* Does not compile where a shift of a negative number is none that rounds down. */
typedef char stage_model_shifts_round_down[(-1 >> 1) == -1 ? 1 : -1];

/* Maxwell-slip blocks in whole numbers: each keeps what it can still move before it slips; a reversal turns that round.
   moved is in 1/65536 units of length, what is returned in units of force. */
static int32_t blocks_step(stage_model_state *s, int32_t moved)
{
    const int32_t path = moved > INT32_MAX - s->remainder ? INT32_MAX : moved + s->remainder;
    int32_t advance = path >> 16;
    int32_t lacking = 0;
    int i;
    /* What is no whole unit yet waits. */
    s->remainder = path & 0xffff;
    if (s->backward ? advance > 0 : advance < 0) {
        s->backward = !s->backward;
        for (i = 0; i < STAGE_MODEL_BLOCKS; ++i) {
            s->reserve[i] = FULLS[i] - s->reserve[i];
        }
    }
    advance = advance < 0 ? -advance : advance;
    for (i = 0; i < STAGE_MODEL_BLOCKS; ++i) {
        s->reserve[i] = s->reserve[i] > advance ? s->reserve[i] - advance : 0;
        lacking += STIFFNESSES[i] * s->reserve[i];
    }
    lacking = LIMIT - lacking;
    return s->backward ? -lacking : lacking;
}

/* x in units that are so many times finer, held where int32_t ends; most is INT32_MAX / times. */
static int32_t finer(int32_t x, int32_t times, int32_t most)
{
    return x > most ? INT32_MAX : x < -most - 1 ? INT32_MIN : x * times;
}

static int32_t friction_step(stage_model_state *s, int32_t dx, int32_t v)
{
    (void)v;
    return blocks_step(s, finer(dx, LENGTH, INT32_MAX / LENGTH)) >> 4;
}

int32_t stage_model_step(stage_model_state *s, int32_t displacement_q16, int32_t velocity_q16)
{
    return friction_step(s, displacement_q16, velocity_q16);
}

void stage_model_rest(stage_model_state *s)
{
    int i;
    s->remainder = 32768;
    s->backward = false;
    for (i = 0; i < STAGE_MODEL_BLOCKS; ++i) {
        s->reserve[i] = FULLS[i] / 2;
    }
}
