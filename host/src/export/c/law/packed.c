
static float friction_step(@state *s, float dx, float v)
{
    const float q16 = dx * PER_LENGTH;
    const float up = q16 < 0.0f ? q16 - 0.5f : q16 + 0.5f;
    int32_t moved = 0;
    (void)v;
    if (up >= 2147483648.0f) {
        moved = INT32_MAX;
    } else if (up <= -2147483648.0f) {
        moved = INT32_MIN;
    } else if (up == up) {
        moved = (int32_t)up;
    }
    return (float)blocks_step(s, moved) * FORCE;
}
