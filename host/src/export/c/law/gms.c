/* The generalised Maxwell-slip model (Al-Bender, Lampaert and Swevers 2005): blocks stick like springs, and slip towards the Stribeck curve.
   Deflections count in the direction of motion. */
static float friction_step(@state *s, float dx, float v)
{
    float advance = dx * s->direction;
    float force = 0.0f;
    int moves = 1;
    int i;
    if (!(advance > 0.0f)) {
        if (advance != 0.0f) {
            s->direction = -s->direction;
            s->slipping = 0u;
            for (i = 0; i < @@BLOCKS; ++i) {
                s->deflection[i] = -s->deflection[i];
            }
            advance = fabsf(dx);
        } else if (v == 0.0f) {
            moves = 0;
        }
    }
    if (moves) {
        const float share = weakening(v);
        const float follow = lag(share);
        for (i = 0; i < @@BLOCKS; ++i) {
            const float bound = YIELDS[i] * share;
            const float old = s->deflection[i];
            float z;
            if ((s->slipping >> i & 1u) == 1u) {
                z = old + follow * (bound - old);
            } else {
                z = old + advance;
                if (!(z < bound)) {
                    s->slipping |= 1u << i;
                    z = old < bound ? bound : old + follow * (bound - old);
                }
            }
            s->deflection[i] = z;
        }
    }
    for (i = 0; i < @@BLOCKS; ++i) {
        force += STIFFNESSES[i] * s->deflection[i];
    }
    return force * s->direction;
}
