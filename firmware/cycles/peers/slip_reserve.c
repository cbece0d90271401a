/* The library's SlipReserve (src/kernels/slip_reserve.rs) in C, on the structures that Rust lays out: the same formulation, for gcc.
 * Signed overflow wraps (-fwrapv), as in the Rust. */

#include <stdint.h>

struct slip_reserve {
    int32_t limit;
    struct {
        int32_t full, stiffness;
    } block[N];
};

struct slip_reserve_state {
    int32_t backward;
    int32_t reserve[N];
};

/* Displacement of the tick [counts] in, friction force out. */
int32_t STEP(const struct slip_reserve *m, struct slip_reserve_state *s, int32_t dx, int32_t velocity)
{
    (void)velocity;
    const int32_t longest = (1 << 30) - 1;
    if (dx > longest)
        dx = longest;
    if (dx < -longest - 1)
        dx = -longest - 1;
    int32_t advance = (dx ^ s->backward) - s->backward;
    if (advance < 0) {
        advance = -advance;
        s->backward = ~s->backward;
        for (int i = 0; i < N; i++)
            s->reserve[i] = m->block[i].full - s->reserve[i];
    }
    int32_t lacking = 0;
    for (int i = 0; i < N; i++) {
        int32_t left = s->reserve[i] - advance;
        s->reserve[i] = left > 0 ? left : 0;
        lacking += m->block[i].stiffness * s->reserve[i];
    }
    int32_t force = m->limit - lacking;
    return (force ^ s->backward) - s->backward;
}
