
static int32_t friction_step(@state *s, int32_t dx, int32_t v)
{
    (void)v;
    return blocks_step(s, dx)$to_force;
}
