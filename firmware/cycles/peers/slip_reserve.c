/* The library's SlipReserve (src/kernels/slip_reserve.rs) in C, on the structures that Rust lays out: the same formulation, for gcc.
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
    int32_t force, stiffness;
    uint32_t slipping;
    int32_t slider[N];
};

static int32_t along(const struct slip_reserve_state *s, int32_t x)
{
    return (x ^ s->backward) - s->backward;
}

static __attribute__((noinline, cold)) void event(const struct slip_reserve *m, struct slip_reserve_state *s, int32_t dx)
{
    const int32_t longest = (1 << 30) - 1;
    int32_t advance = along(s, dx > longest ? longest : dx < -longest - 1 ? -longest - 1 : dx);
    int32_t place = 0;
    uint32_t i = s->slipping;
    if (i < N)
        place = along(s, s->slider[i]) + m->spring[i].yields - (int32_t)s->left;
    if (advance < 0) {
        for (uint32_t j = 0; j < i; j++)
            s->slider[j] = along(s, place - m->spring[j].yields);
        s->backward = ~s->backward;
        s->force = -s->force;
        s->stiffness = m->stiffness;
        i = 0;
        place = -place;
        advance = -advance;
    }
    place += advance;
    int32_t force = s->force + s->stiffness * advance;
    uint32_t left = UINT32_C(1) << 31;
    for (; i < N; i++) {
        int32_t to = along(s, s->slider[i]) + m->spring[i].yields - place;
        if (to > 0) {
            left = (uint32_t)to;
            break;
        }
        force += m->spring[i].stiffness * to;
        s->stiffness -= m->spring[i].stiffness;
    }
    s->force = force;
    s->left = left;
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
