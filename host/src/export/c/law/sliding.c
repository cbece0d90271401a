/* What sliding at v holds, of the breakaway force. */
static float weakening(float v)
{
    const float share = $coulomb_N / $breakaway_N;
    return share + (1.0f - share) * stribeck(v, $stribeck_velocity_m_s, $stribeck_exponent);
}
