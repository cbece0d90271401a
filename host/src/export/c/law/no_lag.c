/* A slipping block is on the Stribeck curve. */
static float lag(float share)
{
    (void)share;
    return 1.0f;
}
