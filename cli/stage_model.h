/* Written by `preslide export`; do not edit, export again. */
/* Model plain.toml, SHA-256 535d5c199821e67eb0aee4839521c0150cc475e3aee32a9f1dd344b4e62f2a53. */

#ifndef STAGE_MODEL_H
#define STAGE_MODEL_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Maxwell-slip blocks. */
#define STAGE_MODEL_BLOCKS 2
/* Displacement, velocity and force are whole numbers of which so many make 1 of the units below. */
#define STAGE_MODEL_ONE 65536
/* A displacement of 1 (m, or rad on a rotary axis) is an encoder count: (now - before) * STAGE_MODEL_ONE, for less than 32768 counts a step. */
#define STAGE_MODEL_COUNT_M 0.05f
/* A force of 1 (N, or N m on a rotary axis). */
#define STAGE_MODEL_FORCE_N 0.001f

/* What the model remembers; of each axis one, set by stage_model_rest before the first step. */
typedef struct {
    int32_t remainder; /* of the path, 1/65536 units of length */
    bool backward; /* it moves */
    int32_t reserve[STAGE_MODEL_BLOCKS]; /* of each block before it slips */
} stage_model_state;

/* An axis that rests, its friction free of tension. */
void stage_model_rest(stage_model_state *s);
/* The force that holds against friction and effects, in parts of STAGE_MODEL_ONE of its unit: add it to the controller's before the limiter.
   displacement_q16: since the step before; velocity_q16: now, which plays no part here. Bounded whatever the input. */
int32_t stage_model_step(stage_model_state *s, int32_t displacement_q16, int32_t velocity_q16);

#ifdef __cplusplus
}
#endif

#endif
