/* Written by `preslide export`; do not edit, export again. */
/* Model blocks.toml, SHA-256 f6bd5dccc76426a37b2a012e933673f0cc3a8ac7c358df1fb20e4d8e960c4dad. */
/* Model: the paper's Table 3, six blocks. */

#ifndef PACKED_F32_H
#define PACKED_F32_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Maxwell-slip blocks. */
#define PACKED_F32_BLOCKS 6

/* What the model remembers; of each axis one, set by packed_f32_rest before the first step. */
typedef struct {
    int32_t remainder; /* of the path, less than a unit of length */
    bool backward; /* it moves */
    int32_t reserve[PACKED_F32_BLOCKS]; /* of each block before it slips */
} packed_f32_state;

/* An axis that rests, its friction free of tension. */
void packed_f32_rest(packed_f32_state *s);
/* The force (N) that holds against friction and effects: add it to the controller's before the limiter. displacement_m: since the step before
   (m); velocity_m_s: now (m/s). Bounded whatever the input, NAN included. */
float packed_f32_step(packed_f32_state *s, float displacement_m, float velocity_m_s);

#ifdef __cplusplus
}
#endif

#endif
