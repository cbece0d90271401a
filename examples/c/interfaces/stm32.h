/* Of STM32's HAL (stm32g4xx_hal_tim.h and others alike): what the example takes. */
#ifndef STM32_INTERFACE_H
#define STM32_INTERFACE_H

#include <stdint.h>

typedef struct {
    volatile uint32_t CNT;
    volatile uint32_t CCR1;
} TIM_TypeDef;

typedef struct {
    TIM_TypeDef *Instance;
} TIM_HandleTypeDef;

#define __HAL_TIM_GET_COUNTER(handle) ((handle)->Instance->CNT)
#define __HAL_TIM_SET_COMPARE(handle, channel, compare) ((void)(channel), (handle)->Instance->CCR1 = (compare))
#define TIM_CHANNEL_1 0u

void HAL_TIM_PeriodElapsedCallback(TIM_HandleTypeDef *htim);

#endif
