/* Written by `preslide export`; do not edit, export again. */
/* Model full.toml, SHA-256 028a755ffab026ccbe52bbad8b33ed6a08d2de66f6e400abbd870264b0879bed. */
/* Model: the paper's Table 3, six blocks, and a Stribeck curve. */

#ifndef GMS_F32_H
#define GMS_F32_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Maxwell-slip blocks. */
#define GMS_F32_BLOCKS 6
/* Calls of gms_f32_step per second. */
#define GMS_F32_RATE_HZ 20000.0f

/* What the model remembers; of each axis one, set by gms_f32_rest before the first step. */
typedef struct {
    float deflection[GMS_F32_BLOCKS]; /* of each block */
    uint32_t slipping; /* a bit for each block */
    float direction; /* 1 or -1 */
} gms_f32_state;

/* An axis that rests, its friction free of tension. */
void gms_f32_rest(gms_f32_state *s);
/* The force (N) that holds against friction and effects: add it to the controller's before the limiter. displacement_m: since the step before
   (m); velocity_m_s: now (m/s). Bounded whatever the input, NAN included. */
float gms_f32_step(gms_f32_state *s, float displacement_m, float velocity_m_s);

#ifdef __cplusplus
}
#endif

#endif
