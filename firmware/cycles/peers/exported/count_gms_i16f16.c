/* Written by `preslide export`; do not edit, export again. */
/* Model full.toml, SHA-256 028a755ffab026ccbe52bbad8b33ed6a08d2de66f6e400abbd870264b0879bed. */
/* Model: the paper's Table 3, six blocks, and a Stribeck curve. */

#include "count_gms_i16f16.h"

/* Binary places of a path beyond its units of length. */
#define BEYOND 13
/* Growth of each block's share in a unit of length. */
static const int32_t RATES[COUNT_GMS_I16F16_BLOCKS] = { 53928, 26977, 10765, 3595, 1806, 1345 };
/* What each can hold, so that the upper word of its product with the share is in units of force. */
static const int32_t WEIGHTS[COUNT_GMS_I16F16_BLOCKS] = { 1102263091, 471859200, 596430029, 581330534, 317089382, 702126490 };
/* Units of velocity in 1/65536. */
#define VELOCITY 1
/* The longest displacement of a step, in units of length. */
#define LONGEST 24946
/* Rows of CURVES in 2^32 units of velocity. */
#define INTERVALS 680225u
/* Beyond the last row they are flat. */
#define LAST 63u
/* The Stribeck curve: its value in the middle of an interval of speed and its difference across, in shares; and the same of the part of
   its way there that a slipping block goes in a step, in 1/2^31. */
static const int32_t CURVES[64][4] = {
    { 16775271, -3889, 2385043, 553 },
    { 16767521, -11612, 2386146, 1652 },
    { 16752127, -19175, 2388338, 2732 },
    { 16729303, -26474, 2391595, 3782 },
    { 16699360, -33412, 2395881, 4791 },
    { 16662703, -39901, 2401150, 5747 },
    { 16619822, -45861, 2407343, 6639 },
    { 16571279, -51225, 2414392, 7459 },
    { 16517696, -55941, 2422221, 8199 },
    { 16459743, -59965, 2430746, 8850 },
    { 16398125, -63272, 2439875, 9409 },
    { 16333564, -65850, 2449515, 9870 },
    { 16266788, -67701, 2459565, 10231 },
    { 16198519, -68837, 2469926, 10490 },
    { 16129457, -69287, 2480495, 10649 },
    { 16060271, -69086, 2491175, 10710 },
    { 15991587, -68282, 2501868, 10677 },
    { 15923982, -66928, 2512483, 10553 },
    { 15857976, -65084, 2522934, 10349 },
    { 15794027, -62814, 2533143, 10068 },
    { 15732528, -60184, 2543038, 9723 },
    { 15673806, -57260, 2552559, 9319 },
    { 15618122, -54108, 2561654, 8870 },
    { 15565671, -50794, 2570280, 8382 },
    { 15516586, -47376, 2578405, 7868 },
    { 15470943, -43909, 2586006, 7335 },
    { 15428765, -40447, 2593071, 6794 },
    { 15390027, -37030, 2599593, 6251 },
    { 15354660, -33703, 2605577, 5716 },
    { 15322562, -30493, 2611031, 5193 },
    { 15293600, -27431, 2615972, 4689 },
    { 15267617, -24535, 2620421, 4208 },
    { 15244439, -21822, 2624402, 3755 },
    { 15223878, -19300, 2627944, 3329 },
    { 15205740, -16976, 2631077, 2936 },
    { 15189827, -14849, 2633831, 2573 },
    { 15175943, -12920, 2636239, 2243 },
    { 15163893, -11180, 2638333, 1944 },
    { 15153491, -9623, 2640142, 1675 },
    { 15144560, -8239, 2641698, 1437 },
    { 15136933, -7016, 2643029, 1224 },
    { 15130452, -5945, 2644160, 1038 },
    { 15124975, -5009, 2645117, 876 },
    { 15120370, -4201, 2645922, 734 },
    { 15116518, -3503, 2646595, 613 },
    { 15113313, -2908, 2647156, 509 },
    { 15110659, -2400, 2647621, 421 },
    { 15108473, -1971, 2648004, 345 },
    { 15106682, -1611, 2648318, 282 },
    { 15105222, -1310, 2648574, 230 },
    { 15104037, -1060, 2648782, 186 },
    { 15103080, -853, 2648949, 149 },
    { 15102312, -683, 2649084, 120 },
    { 15101698, -545, 2649191, 95 },
    { 15101210, -432, 2649277, 76 },
    { 15100824, -340, 2649345, 60 },
    { 15100520, -268, 2649398, 47 },
    { 15100281, -209, 2649440, 36 },
    { 15100096, -162, 2649472, 29 },
    { 15099952, -126, 2649498, 22 },
    { 15099841, -96, 2649517, 17 },
    { 15099756, -74, 2649532, 13 },
    { 15099606, -225, 2649558, 39 },
    { 15099494, 0, 2649578, 0 }
};


/* Does not compile where a shift of a negative number is none that rounds down. */
typedef char count_gms_i16f16_shifts_round_down[(-1 >> 1) == -1 ? 1 : -1];

/* x in units that are so many times finer, held where int32_t ends; most is INT32_MAX / times. */
static int32_t finer(int32_t x, int32_t times, int32_t most)
{
    return x > most ? INT32_MAX : x < -most - 1 ? INT32_MIN : x * times;
}

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
static int32_t friction_step(count_gms_i16f16_state *s, int32_t dx, int32_t v)
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
            for (i = 0; i < COUNT_GMS_I16F16_BLOCKS; ++i) {
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
        for (i = 0; i < COUNT_GMS_I16F16_BLOCKS; ++i) {
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
        for (i = 0; i < COUNT_GMS_I16F16_BLOCKS; ++i) {
            force += upper(WEIGHTS[i], s->share[i]);
        }
    }
    force = s->backward ? -force : force;
    return force * 4;
}

int32_t count_gms_i16f16_step(count_gms_i16f16_state *s, int32_t displacement_q16, int32_t velocity_q16)
{
    return friction_step(s, displacement_q16, velocity_q16);
}

void count_gms_i16f16_rest(count_gms_i16f16_state *s)
{
    int i;
    s->remainder = 0;
    s->backward = false;
    s->slipping = 0u;
    for (i = 0; i < COUNT_GMS_I16F16_BLOCKS; ++i) {
        s->share[i] = 0;
    }
}
