/* The GMS model as a textbook has it: equations (10) to (12) with forward Euler, the exponential of the Stribeck
 * curve and a division per slipping block in every step. The peer that Preslide's kernels are measured against.
 *
 * Compiled once per type, N and optimisation: REAL is float or double, EXP its exponential, N the number of
 * blocks, STEP the name of the function. The structures are mirrored in src/peers.rs. */

#include <math.h>

struct gms {
    REAL stiffness[N];      /* k_i [N/m] */
    REAL weight[N];         /* alpha_i [-] */
    REAL breakaway;         /* F_s [N] */
    REAL coulomb;           /* F_c [N] */
    REAL stribeck_velocity; /* v_s [m/s] */
    REAL attraction;        /* C [N/s] */
    REAL sample_time;       /* T_s [s] */
};

struct gms_state {
    REAL force[N]; /* F_i [N] */
    int slipping[N];
    int direction;
};

/* Displacement of the tick [m] and velocity [m/s] in, friction force [N] out. */
REAL STEP(const struct gms *model, struct gms_state *state, REAL displacement, REAL velocity)
{
    int direction = (velocity > 0) - (velocity < 0);
    REAL ratio = velocity / model->stribeck_velocity;
    REAL s = model->coulomb + (model->breakaway - model->coulomb) * EXP(-ratio * ratio);
    int reversal = direction != 0 && direction != state->direction;
    if (reversal)
        state->direction = direction;

    REAL total = 0;
    for (int i = 0; i < N; i++) {
        REAL limit = model->weight[i] * s;
        REAL force = state->force[i];
        if (reversal)
            state->slipping[i] = 0;
        if (state->slipping[i]) {
            force += model->sample_time * model->attraction * (direction * model->weight[i] - force / s);
        } else {
            force += model->stiffness[i] * displacement;
            if (force > limit) {
                force = limit;
                state->slipping[i] = 1;
            } else if (force < -limit) {
                force = -limit;
                state->slipping[i] = 1;
            }
        }
        state->force[i] = force;
        total += force;
    }
    return total;
}
