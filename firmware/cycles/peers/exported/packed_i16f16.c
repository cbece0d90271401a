/* Written by `preslide export`; do not edit, export again. */
/* Model blocks.toml, SHA-256 f6bd5dccc76426a37b2a012e933673f0cc3a8ac7c358df1fb20e4d8e960c4dad. */
/* Model: the paper's Table 3, six blocks. */

#include "packed_i16f16.h"

/* Binary places of a path beyond its units of length. */
#define BEYOND 13
/* All blocks slipping, in units of force. */
#define LIMIT 29466952
/* Twice the displacement at which each slips, in units of length. */
static const int32_t FULLS[PACKED_I16F16_BLOCKS] = { 622, 1244, 3116, 9334, 18580, 24944 };
/* Stiffness of each block, in units of force per unit of length. */
static const int32_t STIFFNESSES[PACKED_I16F16_BLOCKS] = { 27689, 5927, 2991, 973, 267, 440 };


/* Does not compile where a shift of a negative number is none that rounds down. */
typedef char packed_i16f16_shifts_round_down[(-1 >> 1) == -1 ? 1 : -1];

/* Maxwell-slip blocks in whole numbers: each keeps what it can still move before it slips; a reversal turns that round.
   moved has BEYOND binary places more than units of length; what is returned is in units of force. */
static int32_t blocks_step(packed_i16f16_state *s, int32_t moved)
{
    const int32_t path = moved > INT32_MAX - s->remainder ? INT32_MAX : moved + s->remainder;
    int32_t advance = path >> BEYOND;
    int32_t lacking = 0;
    int i;
    /* What is no whole unit yet waits. */
    s->remainder = path & ((1 << BEYOND) - 1);
    if (s->backward ? advance > 0 : advance < 0) {
        s->backward = !s->backward;
        for (i = 0; i < PACKED_I16F16_BLOCKS; ++i) {
            s->reserve[i] = FULLS[i] - s->reserve[i];
        }
    }
    advance = advance < 0 ? -advance : advance;
    for (i = 0; i < PACKED_I16F16_BLOCKS; ++i) {
        s->reserve[i] = s->reserve[i] > advance ? s->reserve[i] - advance : 0;
        lacking += STIFFNESSES[i] * s->reserve[i];
    }
    lacking = LIMIT - lacking;
    return s->backward ? -lacking : lacking;
}

static int32_t friction_step(packed_i16f16_state *s, int32_t dx, int32_t v)
{
    (void)v;
    return blocks_step(s, dx) * 2;
}

int32_t packed_i16f16_step(packed_i16f16_state *s, int32_t displacement_q16, int32_t velocity_q16)
{
    return friction_step(s, displacement_q16, velocity_q16);
}

void packed_i16f16_rest(packed_i16f16_state *s)
{
    int i;
    s->remainder = 1 << (BEYOND - 1);
    s->backward = false;
    for (i = 0; i < PACKED_I16F16_BLOCKS; ++i) {
        s->reserve[i] = FULLS[i] / 2;
    }
}
