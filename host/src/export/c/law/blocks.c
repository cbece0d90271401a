/* Maxwell-slip blocks in whole numbers: each keeps what it can still move before it slips; a reversal turns that round.
   moved has BEYOND binary places more than units of length; what is returned is in units of force. */
static int32_t blocks_step(@state *s, int32_t moved)
{
    const int32_t path = moved > INT32_MAX - s->remainder ? INT32_MAX : moved + s->remainder;
    int32_t advance = path >> BEYOND;
    int32_t lacking = 0;
    int i;
    /* What is no whole unit yet waits. */
    s->remainder = path & ((1 << BEYOND) - 1);
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
    return s->backward ? -lacking : lacking;
}
