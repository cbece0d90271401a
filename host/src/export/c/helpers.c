/* Within -limit..limit, whatever the value; NaN is the limit. */
static float limited(float value, float limit)
{
    if (value < limit) {
        return value > -limit ? value : -limit;
    }
    return limit;
}
---
/* The share of a Stribeck peak that is left at v. */
static float stribeck(float v, float velocity, float exponent)
{
    return limited(expf(-powf(fabsf(v) / velocity, exponent)), 1.0f);
}
---
/* cos(2 pi x / period + phase), whole periods taken off first. */
static float wave(float x, float period, float phase)
{
    const float turns = x / period;
    return limited(cosf(6.28318531f * (turns - floorf(turns)) + phase), 1.0f);
}
---
/* A map over the travel, the sum of c[j] cos((j + 1) pi u), u within 0..1. */
static float cosines(float u, const float *c, int count)
{
    const float within = u > 0.0f ? limited(u, 1.0f) : 0.0f;
    float sum = 0.0f;
    int j;
    for (j = 0; j < count; ++j) {
        sum += c[j] * cosf(3.14159265f * (float)(j + 1) * within);
    }
    return sum;
}
---
/* A spot, at u widths from its middle. */
static float spot(float u)
{
    return limited(expf(-u * u), 1.0f);
}
---
/* A friction level that follows what is measured; none where that is not known. */
static float slope(float measured, float nominal, float per_unit)
{
    return measured == measured ? limited(per_unit * (measured - nominal), LEVEL_LIMIT) : 0.0f;
}
