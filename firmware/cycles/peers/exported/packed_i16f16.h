/* Written by `preslide export`; do not edit, export again. */
/* Model blocks.toml, SHA-256 f6bd5dccc76426a37b2a012e933673f0cc3a8ac7c358df1fb20e4d8e960c4dad. */
/* Model: the paper's Table 3, six blocks. */

#ifndef PACKED_I16F16_H
#define PACKED_I16F16_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Maxwell-slip blocks. */
#define PACKED_I16F16_BLOCKS 6
/* Displacement, velocity and force are whole numbers of which so many make 1 of the units below. */
#define PACKED_I16F16_ONE 65536
/* A displacement of 1 (m, or rad on a rotary axis) is an encoder count: (now - before) * PACKED_I16F16_ONE, for less than 32768 counts a step. */
#define PACKED_I16F16_COUNT_M 2.5e-8f
/* A force of 1 (N, or N m on a rotary axis). */
#define PACKED_I16F16_FORCE_N 0.001f

/* What the model remembers; of each axis one, set by packed_i16f16_rest before the first step. */
typedef struct {
    int32_t remainder; /* of the path, less than a unit of length */
    bool backward; /* it moves */
    int32_t reserve[PACKED_I16F16_BLOCKS]; /* of each block before it slips */
} packed_i16f16_state;

/* An axis that rests, its friction free of tension. */
void packed_i16f16_rest(packed_i16f16_state *s);
/* The force that holds against friction and effects, in parts of PACKED_I16F16_ONE of its unit: add it to the controller's before the limiter.
   displacement_q16: since the step before; velocity_q16: now, which plays no part here. Bounded whatever the input. */
int32_t packed_i16f16_step(packed_i16f16_state *s, int32_t displacement_q16, int32_t velocity_q16);

#ifdef __cplusplus
}
#endif

#endif
