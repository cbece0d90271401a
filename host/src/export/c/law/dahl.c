/* Dahl's model (1968), solved along the path. */
static float friction_step(@state *s, float dx, float v)
{
    (void)v;
    if (dx != 0.0f) {
        const float direction = dx > 0.0f ? 1.0f : -1.0f;
        const float path = $stiffness_N_per_m / $coulomb_N * fabsf(dx);
        const float excess = $exponent - 1.0f;
        float u = 1.0f - direction * s->share;
        if (u <= 0.0f) {
            u = 0.0f;
        } else if (fabsf(excess) < 1e-4f) {
            u *= expf(-path);
        } else {
            /* The bracket less 1, which keeps its digits where the exponent is near 1. */
            const float growth = excess * (path * powf(u, excess));
            u = growth > -1.0f ? u * expf(-log1pf(growth) / excess) : 0.0f;
        }
        s->share = limited(direction * (1.0f - u), 1.0f);
    }
    return $coulomb_N * s->share;
}
