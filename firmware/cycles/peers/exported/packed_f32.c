/* Written by `preslide export`; do not edit, export again. */
/* Model blocks.toml, SHA-256 f6bd5dccc76426a37b2a012e933673f0cc3a8ac7c358df1fb20e4d8e960c4dad. */
/* Model: the paper's Table 3, six blocks. */

#include "packed_f32.h"

#include <math.h>

/* `breakaway_N` of `gms`. */
#define GMS_BREAKAWAY_N 0.9f
/* Parts of 1/65536 of a unit of length in a metre or radian. */
#define PER_LENGTH 17592186000000.0f
/* Binary places of a path beyond its units of length. */
#define BEYOND 16
/* A unit of force (N or N m). */
#define FORCE 5.9604645e-8f
/* All blocks slipping, in units of force. */
#define LIMIT 15081485
/* Twice the displacement at which each slips, in units of length. */
static const int32_t FULLS[PACKED_F32_BLOCKS] = { 522, 1044, 2614, 7830, 15586, 20924 };
/* Stiffness of each block, in units of force per unit of length. */
static const int32_t STIFFNESSES[PACKED_F32_BLOCKS] = { 16893, 3616, 1825, 594, 163, 268 };


/* Does not compile where a shift of a negative number is none that rounds down. */
typedef char packed_f32_shifts_round_down[(-1 >> 1) == -1 ? 1 : -1];

/* Maxwell-slip blocks in whole numbers: each keeps what it can still move before it slips; a reversal turns that round.
   moved has BEYOND binary places more than units of length; what is returned is in units of force. */
static int32_t blocks_step(packed_f32_state *s, int32_t moved)
{
    const int32_t path = moved > INT32_MAX - s->remainder ? INT32_MAX : moved + s->remainder;
    int32_t advance = path >> BEYOND;
    int32_t lacking = 0;
    int i;
    /* What is no whole unit yet waits. */
    s->remainder = path & ((1 << BEYOND) - 1);
    if (s->backward ? advance > 0 : advance < 0) {
        s->backward = !s->backward;
        for (i = 0; i < PACKED_F32_BLOCKS; ++i) {
            s->reserve[i] = FULLS[i] - s->reserve[i];
        }
    }
    advance = advance < 0 ? -advance : advance;
    for (i = 0; i < PACKED_F32_BLOCKS; ++i) {
        s->reserve[i] = s->reserve[i] > advance ? s->reserve[i] - advance : 0;
        lacking += STIFFNESSES[i] * s->reserve[i];
    }
    lacking = LIMIT - lacking;
    return s->backward ? -lacking : lacking;
}

static float friction_step(packed_f32_state *s, float dx, float v)
{
    const float path = dx * PER_LENGTH;
    int32_t moved = 0;
    (void)v;
    if (path >= 2147483648.0f) {
        moved = INT32_MAX;
    } else if (path <= -2147483648.0f) {
        moved = INT32_MIN;
    } else if (path == path) {
        moved = (int32_t)path;
    }
    return (float)blocks_step(s, moved) * FORCE;
}

float packed_f32_step(packed_f32_state *s, float displacement_m, float velocity_m_s)
{
    const float v = velocity_m_s;
    float dx = displacement_m;
    float friction;
    float force;
    friction = friction_step(s, dx, v);
    force = friction;
    return force;
}

void packed_f32_rest(packed_f32_state *s)
{
    int i;
    s->remainder = 1 << (BEYOND - 1);
    s->backward = false;
    for (i = 0; i < PACKED_F32_BLOCKS; ++i) {
        s->reserve[i] = FULLS[i] / 2;
    }
}
