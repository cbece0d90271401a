/* Maxwell-slip blocks in parallel, each an elastic one that slips at its yield displacement. */
static float friction_step(@state *s, float dx, float v)
{
    float force = 0.0f;
    int i;
    (void)v;
    for (i = 0; i < @@BLOCKS; ++i) {
        s->deflection[i] = limited(s->deflection[i] + dx, YIELDS[i]);
        force += STIFFNESSES[i] * s->deflection[i];
    }
    return force;
}
