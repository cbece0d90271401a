
/* Viscous friction, bounded. */
static int32_t viscous(int32_t v)
{
    const int64_t force = (int64_t)VISCOUS * v >> 16;
    return force > FORCE_LIMIT ? FORCE_LIMIT : force < -FORCE_LIMIT ? -FORCE_LIMIT : (int32_t)force;
}
