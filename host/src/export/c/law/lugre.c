/* The LuGre model (Canudas de Wit and others 1995), its bristle solved along the path. */
static float friction_step(@state *s, float dx, float v)
{
    const float largest = $breakaway_N / $stiffness_N_per_m;
    const float steady = largest * weakening(v);
    float elastic;
    if (dx != 0.0f) {
        const float end = dx > 0.0f ? steady : -steady;
        const float decay = expf(-fabsf(dx) / steady);
        s->deflection = limited(end + (s->deflection - end) * decay, largest);
    }
    elastic = $stiffness_N_per_m * s->deflection;
    if ($damping_N_s_per_m == 0.0f) {
        return elastic; /* 0 times infinity is no number */
    }
    return elastic + $damping_N_s_per_m * (v - fabsf(v) * (s->deflection / steady));
}
