/* As stm32.c, for a core without a float unit, such as a Cortex-M0+: of `--lang c --kernel slip_reserve_i16f16 --count …`, from counts to a
   PWM's duty in whole numbers. */
#include "stm32.h"
#include "counts_model.h"

#define CODES_PER_1024 41      /* of a unit of force, COUNTS_MODEL_FORCE_N, by supply, resistance and force constant; times 1024 */
#define MIDDLE 2048            /* compare value of no voltage */
#define MOST_COUNTS 32767      /* in a step */

extern TIM_HandleTypeDef control_timer, encoder_timer, pwm_timer;
int32_t position_control(int32_t count); /* yours, in PWM codes */

static counts_model_state friction;
static uint32_t last_count;

void friction_begin(void)
{
    counts_model_rest(&friction);
    last_count = __HAL_TIM_GET_COUNTER(&encoder_timer);
}

void HAL_TIM_PeriodElapsedCallback(TIM_HandleTypeDef *htim)
{
    uint32_t count;
    int32_t moved, force, codes;
    if (htim != &control_timer) {
        return;
    }
    count = __HAL_TIM_GET_COUNTER(&encoder_timer);
    /* Unsigned: the counter may wrap. */
    moved = (int32_t)(count - last_count);
    last_count = count;
    moved = moved > MOST_COUNTS ? MOST_COUNTS : moved < -MOST_COUNTS ? -MOST_COUNTS : moved;
    moved *= COUNTS_MODEL_ONE;
    /* The velocity in counts a step is the same number. */
    force = counts_model_step(&friction, moved, moved) / COUNTS_MODEL_ONE;
    codes = MIDDLE + position_control((int32_t)count) + force * CODES_PER_1024 / 1024;
    codes = codes < 1 ? 1 : codes > 2 * MIDDLE - 1 ? 2 * MIDDLE - 1 : codes;
    __HAL_TIM_SET_COMPARE(&pwm_timer, TIM_CHANNEL_1, (uint32_t)codes);
}
