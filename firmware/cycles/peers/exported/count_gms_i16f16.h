/* Written by `preslide export`; do not edit, export again. */
/* Model full.toml, SHA-256 028a755ffab026ccbe52bbad8b33ed6a08d2de66f6e400abbd870264b0879bed. */
/* Model: the paper's Table 3, six blocks, and a Stribeck curve. */

#ifndef COUNT_GMS_I16F16_H
#define COUNT_GMS_I16F16_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Maxwell-slip blocks. */
#define COUNT_GMS_I16F16_BLOCKS 6
/* Displacement, velocity and force are whole numbers of which so many make 1 of the units below. */
#define COUNT_GMS_I16F16_ONE 65536
/* A displacement of 1 (m, or rad on a rotary axis) is an encoder count: (now - before) * COUNT_GMS_I16F16_ONE, for less than 32768 counts a step. */
#define COUNT_GMS_I16F16_COUNT_M 2.5e-8f
/* A velocity of 1 is a count a step, as of displacements: a mean of some, where counts are coarse. */
#define COUNT_GMS_I16F16_VELOCITY_M_S 0.0005f
/* Calls of count_gms_i16f16_step per second. */
#define COUNT_GMS_I16F16_RATE_HZ 20000.0f
/* A force of 1 (N, or N m on a rotary axis). */
#define COUNT_GMS_I16F16_FORCE_N 0.001f

/* What the model remembers; of each axis one, set by count_gms_i16f16_rest before the first step. */
typedef struct {
    int32_t remainder; /* of the path, less than a unit of length */
    bool backward; /* it moves */
    uint32_t slipping; /* a bit for each block */
    int32_t share[COUNT_GMS_I16F16_BLOCKS]; /* of what each block can hold */
} count_gms_i16f16_state;

/* An axis that rests, its friction free of tension. */
void count_gms_i16f16_rest(count_gms_i16f16_state *s);
/* The force that holds against friction and effects, in parts of COUNT_GMS_I16F16_ONE of its unit: add it to the controller's before the limiter.
   displacement_q16: since the step before; velocity_q16: now. Bounded whatever the input. */
int32_t count_gms_i16f16_step(count_gms_i16f16_state *s, int32_t displacement_q16, int32_t velocity_q16);

#ifdef __cplusplus
}
#endif

#endif
