/* The library's LumpedSlipReserve (src/kernels/lumped/slip_reserve.rs) in C, on the structures that Rust lays out: the same formulation, for gcc.
 * Signed overflow wraps (-fwrapv), as in the Rust. */

#include <stdint.h>

struct slip_reserve {
    int32_t limit, stiffness;
    struct {
        int32_t yields, stiffness;
    } spring[N];
};

struct slip_reserve_state {
    int32_t backward;
    uint32_t left;
    int32_t force, stiffness, slips;
    uint32_t slipping;
    int32_t slider[N];
};

static int32_t along(const struct slip_reserve_state *s, int32_t x)
{
    return (x ^ s->backward) - s->backward;
}

static __attribute__((noinline, cold)) void event(const struct slip_reserve *m, struct slip_reserve_state *s, int32_t dx)
{
    int32_t advance = along(s, dx < -INT32_MAX ? -INT32_MAX : dx);
    int32_t place = s->slips - (int32_t)s->left;
    if (advance < 0) {
        for (uint32_t i = 0; i < s->slipping; i++)
            s->slider[i] = along(s, place - m->spring[i].yields);
        s->backward = ~s->backward;
        s->force = -s->force;
        s->stiffness = m->stiffness;
        s->slipping = 0;
        place = -place;
        advance = -advance;
    }
    place += advance;
    int32_t stiffness = s->stiffness, force = s->force + stiffness * advance, left = INT32_MAX;
    uint32_t i;
    for (i = s->slipping; i < N; i++) {
        int32_t to = along(s, s->slider[i]) + m->spring[i].yields - place;
        if (to > 0) {
            left = to;
            break;
        }
        force += m->spring[i].stiffness * to;
        stiffness -= m->spring[i].stiffness;
    }
    s->left = (uint32_t)left;
    s->slips = place + left;
    s->force = force;
    s->stiffness = stiffness;
    s->slipping = i;
}

/* Displacement of the tick [counts] in, friction force out. */
int32_t STEP(const struct slip_reserve *m, struct slip_reserve_state *s, int32_t dx, int32_t velocity)
{
    (void)velocity;
    int32_t advance = along(s, dx);
    if ((uint32_t)advance < s->left) {
        s->left -= (uint32_t)advance;
        s->force += s->stiffness * advance;
    } else {
        event(m, s, dx);
    }
    return along(s, s->force);
}
