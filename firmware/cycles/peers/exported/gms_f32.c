/* Written by `preslide export`; do not edit, export again. */
/* Model full.toml, SHA-256 028a755ffab026ccbe52bbad8b33ed6a08d2de66f6e400abbd870264b0879bed. */
/* Model: the paper's Table 3, six blocks, and a Stribeck curve. */

#include "gms_f32.h"

#include <math.h>

/* Seconds between two steps. */
#define SAMPLE_TIME_S (1.0f / GMS_F32_RATE_HZ)
/* `breakaway_N` of `gms`. */
#define GMS_BREAKAWAY_N 0.9f
/* `coulomb_N` of `gms`. */
#define GMS_COULOMB_N 0.81f
/* `stribeck_velocity_m_s` of `gms`. */
#define GMS_STRIBECK_VELOCITY_M_S 0.001f
/* `stribeck_exponent` of `gms`. */
#define GMS_STRIBECK_EXPONENT 2.0f
/* `attraction_N_per_s` of `gms`. */
#define GMS_ATTRACTION_N_PER_S 20.0f
/* Stiffness of each block. */
static const float STIFFNESSES[GMS_F32_BLOCKS] = { 270313.0f, 57886.0f, 29198.0f, 9503.0f, 2604.0f, 4295.0f };
/* Displacement at which each slips. */
static const float YIELDS[GMS_F32_BLOCKS] = { 9.722063e-7f, 1.9434751e-6f, 4.870197e-6f, 1.4584868e-5f, 2.9032259e-5f, 3.897555e-5f };

/* Within -limit..limit, whatever the value; NaN is the limit. */
static float limited(float value, float limit)
{
    if (value < limit) {
        return value > -limit ? value : -limit;
    }
    return limit;
}

/* The share of a Stribeck peak that is left at v. */
static float stribeck(float v, float velocity, float exponent)
{
    return limited(expf(-powf(fabsf(v) / velocity, exponent)), 1.0f);
}

/* What sliding at v holds, of the breakaway force. */
static float weakening(float v)
{
    const float share = GMS_COULOMB_N / GMS_BREAKAWAY_N;
    return share + (1.0f - share) * stribeck(v, GMS_STRIBECK_VELOCITY_M_S, GMS_STRIBECK_EXPONENT);
}

/* The part of its way to the Stribeck curve that a slipping block goes in a tick. */
static float lag(float share)
{
    return -expm1f(-GMS_ATTRACTION_N_PER_S * SAMPLE_TIME_S / GMS_BREAKAWAY_N / share);
}

/* The generalised Maxwell-slip model (Al-Bender, Lampaert and Swevers 2005): blocks stick like springs, and slip towards the Stribeck curve.
   Deflections count in the direction of motion. */
static float friction_step(gms_f32_state *s, float dx, float v)
{
    float advance = dx * s->direction;
    float force = 0.0f;
    int moves = 1;
    int i;
    if (!(advance > 0.0f)) {
        if (advance != 0.0f) {
            s->direction = -s->direction;
            s->slipping = 0u;
            for (i = 0; i < GMS_F32_BLOCKS; ++i) {
                s->deflection[i] = -s->deflection[i];
            }
            advance = fabsf(dx);
        } else if (v == 0.0f) {
            moves = 0;
        }
    }
    if (moves) {
        const float share = weakening(v);
        const float follow = lag(share);
        for (i = 0; i < GMS_F32_BLOCKS; ++i) {
            const float bound = YIELDS[i] * share;
            const float old = s->deflection[i];
            float z;
            if ((s->slipping >> i & 1u) == 1u) {
                z = old + follow * (bound - old);
            } else {
                z = old + advance;
                if (!(z < bound)) {
                    s->slipping |= 1u << i;
                    z = old < bound ? bound : old + follow * (bound - old);
                }
            }
            s->deflection[i] = z;
        }
    }
    for (i = 0; i < GMS_F32_BLOCKS; ++i) {
        force += STIFFNESSES[i] * s->deflection[i];
    }
    return force * s->direction;
}

float gms_f32_step(gms_f32_state *s, float displacement_m, float velocity_m_s)
{
    const float v = velocity_m_s;
    float dx = displacement_m;
    float friction;
    float force;
    friction = friction_step(s, dx, v);
    force = friction;
    return force;
}

void gms_f32_rest(gms_f32_state *s)
{
    int i;
    for (i = 0; i < GMS_F32_BLOCKS; ++i) {
        s->deflection[i] = 0.0f;
    }
    s->slipping = 0u;
    s->direction = 1.0f;
}
