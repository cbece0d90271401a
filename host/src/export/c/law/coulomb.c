/* Coulomb friction. */
static float friction_step(@state *s, float dx, float v)
{
    (void)s;
    (void)dx;
    return v > 0.0f ? $coulomb_N : v < 0.0f ? -$coulomb_N : 0.0f;
}
