/* The upper word of a product, rounded down. A core whose multiplier gives the lower word alone takes products of halves, not a function. */
static int32_t upper(int32_t a, int32_t b)
{
#if defined(__ARM_ARCH_6M__) || defined(__ARM_ARCH_8M_BASE__)
    const int32_t low_a = a & 0xffff;
    const int32_t low_b = b & 0xffff;
    const uint32_t lowest = (uint32_t)low_a * (uint32_t)low_b;
    const int32_t middle = (a >> 16) * low_b + (int32_t)(lowest >> 16);
    const int32_t other = low_a * (b >> 16) + (middle & 0xffff);
    return (a >> 16) * (b >> 16) + (middle >> 16) + (other >> 16);
#else
    return (int32_t)((int64_t)a * b >> 32);
#endif
}

/* The generalised Maxwell-slip model (Al-Bender, Lampaert and Swevers 2005) in whole numbers: blocks stick like springs, and slip towards
   the Stribeck curve. Of each block its share of what it can hold is kept, which counts in the direction of motion. */
static int32_t friction_step(@state *s, int32_t dx, int32_t v)
{
    const int32_t below = (1 << BEYOND) - 1;
    /* What moves too slowly for v moves all the same. */
    const int32_t velocity = finer(v, VELOCITY, INT32_MAX / VELOCITY) | (dx != 0);
    int32_t force = 0;
    int i;
    if (velocity != 0) {
        int32_t path = s->remainder;
        int32_t advance = 0;
        if (dx > 0) {
            /* The next unit is given before it is travelled: a reversal is known at once. */
            path = path > INT32_MAX - dx ? INT32_MAX : path + dx;
            advance = (path > INT32_MAX - below ? INT32_MAX : path + below) >> BEYOND;
        } else if (dx < 0) {
            path = path < INT32_MIN - dx ? INT32_MIN : path + dx;
            advance = path >> BEYOND;
        }
        s->remainder = path - advance * (1 << BEYOND);
        if (s->backward ? advance > 0 : advance < 0) {
            s->backward = !s->backward;
            s->slipping = 0u;
            for (i = 0; i < @@BLOCKS; ++i) {
                s->share[i] = -s->share[i];
            }
        }
        advance = advance < 0 ? -advance : advance;
        advance = advance < LONGEST ? advance : LONGEST;
        const uint32_t speed = velocity < 0 ? 0u - (uint32_t)velocity : (uint32_t)velocity;
        const uint64_t place = (uint64_t)speed * INTERVALS;
        const int32_t *const curve = CURVES[place >> 32 < LAST ? place >> 32 : LAST];
        const int32_t part = (int32_t)((int64_t)(place & 0xffffffffu) - 2147483648);
        const int32_t bound = curve[0] + upper(curve[1], part);
        const int32_t follow = curve[2] + upper(curve[3], part);
        for (i = 0; i < @@BLOCKS; ++i) {
            const bool slips = (s->slipping >> i & 1u) == 1u;
            const int32_t old = s->share[i];
            int32_t share = old + RATES[i] * advance;
            if (slips || share >= bound) {
                s->slipping |= 1u << i;
                share = slips || old >= bound ? old + upper(follow, 2 * (bound - old)) : bound;
            }
            s->share[i] = share;
            force += upper(WEIGHTS[i], share);
        }
    } else {
        for (i = 0; i < @@BLOCKS; ++i) {
            force += upper(WEIGHTS[i], s->share[i]);
        }
    }
    force = s->backward ? -force : force;
    return force$to_force;
}
