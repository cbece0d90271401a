/* The part of its way to the Stribeck curve that a slipping block goes in a tick. */
static float lag(float share)
{
    return -expm1f(-$attraction_N_per_s * SAMPLE_TIME_S / $breakaway_N / share);
}
