
static float friction_step(@state *s, float dx, float v)
{
    const float path = dx * PER_LENGTH;
    int32_t moved = 0;
    (void)v;
    if (path >= 2147483648.0f) {
        moved = INT32_MAX;
    } else if (path <= -2147483648.0f) {
        moved = INT32_MIN;
    } else if (path == path) {
        moved = (int32_t)path;
    }
    return (float)blocks_step(s, moved) * FORCE;
}
