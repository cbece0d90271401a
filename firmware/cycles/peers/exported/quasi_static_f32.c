/* Written by `preslide export`; do not edit, export again. */
/* Model blocks.toml, SHA-256 f6bd5dccc76426a37b2a012e933673f0cc3a8ac7c358df1fb20e4d8e960c4dad. */
/* Model: the paper's Table 3, six blocks. */

#include "quasi_static_f32.h"

#include <math.h>

/* `breakaway_N` of `gms`. */
#define GMS_BREAKAWAY_N 0.9f
/* Stiffness of each block. */
static const float STIFFNESSES[QUASI_STATIC_F32_BLOCKS] = { 270313.0f, 57886.0f, 29198.0f, 9503.0f, 2604.0f, 4295.0f };
/* Displacement at which each slips. */
static const float YIELDS[QUASI_STATIC_F32_BLOCKS] = { 9.722063e-7f, 1.9434751e-6f, 4.870197e-6f, 1.4584868e-5f, 2.9032259e-5f, 3.897555e-5f };

/* Within -limit..limit, whatever the value; NaN is the limit. */
static float limited(float value, float limit)
{
    if (value < limit) {
        return value > -limit ? value : -limit;
    }
    return limit;
}

/* Maxwell-slip blocks in parallel, each an elastic one that slips at its yield displacement. */
static float friction_step(quasi_static_f32_state *s, float dx, float v)
{
    float force = 0.0f;
    int i;
    (void)v;
    for (i = 0; i < QUASI_STATIC_F32_BLOCKS; ++i) {
        s->deflection[i] = limited(s->deflection[i] + dx, YIELDS[i]);
        force += STIFFNESSES[i] * s->deflection[i];
    }
    return force;
}

float quasi_static_f32_step(quasi_static_f32_state *s, float displacement_m, float velocity_m_s)
{
    const float v = velocity_m_s;
    float dx = displacement_m;
    float friction;
    float force;
    friction = friction_step(s, dx, v);
    force = friction;
    return force;
}

void quasi_static_f32_rest(quasi_static_f32_state *s)
{
    int i;
    for (i = 0; i < QUASI_STATIC_F32_BLOCKS; ++i) {
        s->deflection[i] = 0.0f;
    }
}
