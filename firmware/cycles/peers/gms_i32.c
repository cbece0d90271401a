/* The library's CountGms (src/kernels/count_gms.rs) in C, with the structures that Rust lays out: the same formulation, for gcc. */

#include <stdint.h>

enum { INTERVALS = 63 };

struct gms {
    struct {
        int32_t rate, share;
    } block[N];
    int32_t longest, one;
    uint32_t per_velocity;
    struct {
        int32_t weakening, weakening_step, lag, lag_step;
    } table[INTERVALS + 1];
};

struct gms_state {
    int32_t backward;
    uint32_t slipping;
    int32_t share[N];
};

static int32_t upper(int32_t a, int32_t b)
{
    return (int32_t)((int64_t)a * b >> 32);
}

/* Displacement of the tick [counts] and velocity in, friction force out. Signed overflow wraps (-fwrapv), as in the Rust. */
int32_t STEP(const struct gms *m, struct gms_state *s, int32_t dx, int32_t velocity)
{
    int32_t force = 0;
    if (dx < -INT32_MAX)
        dx = -INT32_MAX;
    if (dx == 0 && velocity == 0) {
        for (int i = 0; i < N; i++)
            force += upper(m->block[i].share, s->share[i]);
        return (force ^ s->backward) - s->backward;
    }
    int32_t advance = (dx ^ s->backward) - s->backward;
    if (advance < 0) {
        advance = -advance;
        s->backward = ~s->backward;
        s->slipping = 0;
        for (int i = 0; i < N; i++)
            s->share[i] = -s->share[i];
    }
    if (advance > m->longest)
        advance = m->longest;
    uint64_t place = (uint64_t)(velocity < 0 ? 0u - (uint32_t)velocity : (uint32_t)velocity) * m->per_velocity;
    uint32_t interval = place >> 32 < INTERVALS ? (uint32_t)(place >> 32) : INTERVALS;
    int32_t part = (int32_t)((uint32_t)place ^ UINT32_C(0x80000000));
    int32_t bound = m->table[interval].weakening + upper(m->table[interval].weakening_step, part);
    int32_t lag = m->table[interval].lag + upper(m->table[interval].lag_step, part);
    uint32_t slipping = s->slipping;
    for (int i = 0; i < N; i++) {
        int32_t old = s->share[i], share = old + m->block[i].rate * advance;
        int slips = slipping >> i & 1;
        if (slips || share >= bound) {
            slipping |= UINT32_C(1) << i;
            share = slips || old >= bound ? old + upper(lag, 2 * (bound - old)) : bound;
        }
        s->share[i] = share;
        force += upper(m->block[i].share, share);
    }
    s->slipping = slipping;
    return (force ^ s->backward) - s->backward;
}
