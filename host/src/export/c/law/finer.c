/* x in units that are so many times finer, held where int32_t ends; most is INT32_MAX / times. */
static int32_t finer(int32_t x, int32_t times, int32_t most)
{
    return x > most ? INT32_MAX : x < -most - 1 ? INT32_MIN : x * times;
}
