/* STM32 HAL: a control timer's interrupt at the rate that the model was exported for; the encoder in a 32-bit timer, locked anti-phase PWM. */
#include "stm32.h"
#include "stage_model.h"

#define METRES_PER_COUNT 1e-9f  /* of your encoder or interpolator */
#define CONTROL_RATE_HZ 20000.0f
#define CODES_PER_NEWTON 40.0f  /* supply, resistance and force constant */
#define MIDDLE 2048.0f          /* compare value of no voltage */

extern TIM_HandleTypeDef control_timer, encoder_timer, pwm_timer;
float position_control(int32_t count); /* yours, in N */

static stage_model_state friction;
static uint32_t last_count;

void friction_begin(void)
{
    stage_model_rest(&friction);
    last_count = __HAL_TIM_GET_COUNTER(&encoder_timer);
}

void HAL_TIM_PeriodElapsedCallback(TIM_HandleTypeDef *htim)
{
    uint32_t count;
    float moved, force, codes;
    if (htim != &control_timer) {
        return;
    }
    count = __HAL_TIM_GET_COUNTER(&encoder_timer);
    /* Unsigned: the counter may wrap. */
    moved = METRES_PER_COUNT * (float)(int32_t)(count - last_count);
    last_count = count;
    force = position_control((int32_t)count) + stage_model_step(&friction, moved, moved * CONTROL_RATE_HZ);
    codes = MIDDLE + CODES_PER_NEWTON * force;
    codes = codes < 1.0f ? 1.0f : codes > 2.0f * MIDDLE - 1.0f ? 2.0f * MIDDLE - 1.0f : codes;
    __HAL_TIM_SET_COMPARE(&pwm_timer, TIM_CHANNEL_1, (uint32_t)codes);
}
