/* Maxwell-slip blocks in whole numbers: each keeps what it can still move before it slips; a reversal turns that round. */
static float friction_step(@state *s, float dx, float v)
{
    const float q16 = dx * PER_LENGTH;
    const float up = q16 < 0.0f ? q16 - 0.5f : q16 + 0.5f;
    int32_t path = 0;
    int32_t advance;
    int32_t lacking = 0;
    int i;
    (void)v;
    if (up >= 2147483648.0f) {
        path = INT32_MAX;
    } else if (up <= -2147483648.0f) {
        path = INT32_MIN;
    } else if (up == up) {
        path = (int32_t)up;
    }
    /* What is no whole unit yet waits in the remainder. */
    path = path > INT32_MAX - s->remainder ? INT32_MAX : path + s->remainder;
    s->remainder = (int32_t)((uint32_t)path & 0xffffu);
    advance = (path - s->remainder) / 65536;
    if (s->backward ? advance > 0 : advance < 0) {
        s->backward = !s->backward;
        for (i = 0; i < @@BLOCKS; ++i) {
            s->reserve[i] = FULLS[i] - s->reserve[i];
        }
    }
    advance = advance < 0 ? -advance : advance;
    for (i = 0; i < @@BLOCKS; ++i) {
        s->reserve[i] = s->reserve[i] > advance ? s->reserve[i] - advance : 0;
        lacking += STIFFNESSES[i] * s->reserve[i];
    }
    lacking = LIMIT - lacking;
    return (float)(s->backward ? -lacking : lacking) * FORCE;
}
