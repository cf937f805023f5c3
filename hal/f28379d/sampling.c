/* ADC A, B, C, triggered together by ePWM1 at zero; three shunts, of which two are enough. */
#include "hal/hal_sample.h"

#include "hal/f28379d/parts.h"

#define SUM_GAIN (1.0f / 64.0f)

static volatile uint32_t periods; /* PWM periods that were sampled or lost */
static volatile bool     fresh;
static float             zero_sum_a; /* mean of ia + ib + ic as read: the sum of the three zero errors */

void port_sampling_init(void)
{
    static const uint32_t BASE[] = BOARD_ADC_BASES;
    periods = 0U;
    fresh = false;
    zero_sum_a = 0.0f;
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) { /* all alike: converters that differ disturb each other */
        ADC_setPrescaler(BASE[k], ADC_CLK_DIV_4_0);
        ADC_setMode(BASE[k], ADC_RESOLUTION_12BIT, ADC_MODE_SINGLE_ENDED); /* loads the trims, too */
        ADC_setInterruptPulseMode(BASE[k], ADC_PULSE_END_OF_CONV);
        ADC_enableConverter(BASE[k]);
    }
    SysCtl_delay(BOARD_US(1000U));
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        ADC_setupSOC(BASE[k], ADC_SOC_NUMBER0, ADC_TRIGGER_EPWM1_SOCA, BOARD_CHANNEL_CURRENT, BOARD_SAMPLE_WINDOW);
    }
    ADC_setupSOC(ADCA_BASE, ADC_SOC_NUMBER1, ADC_TRIGGER_EPWM1_SOCA, BOARD_CHANNEL_DC_LINK, BOARD_SAMPLE_WINDOW);
    ADC_setInterruptSource(ADCA_BASE, ADC_INT_NUMBER1, (uint16_t)ADC_SOC_NUMBER1); /* the last to be ready */
    ADC_enableInterrupt(ADCA_BASE, ADC_INT_NUMBER1);
    ADC_clearInterruptStatus(ADCA_BASE, ADC_INT_NUMBER1);
}

/* Without clearing a set overflow flag the converter would never interrupt again. */
BOARD_RAM_CODE void port_sampling_take(void)
{
    ADC_clearInterruptStatus(ADCA_BASE, ADC_INT_NUMBER1);
    if (ADC_getInterruptOverflowStatus(ADCA_BASE, ADC_INT_NUMBER1)) {
        ADC_clearInterruptOverflowStatus(ADCA_BASE, ADC_INT_NUMBER1);
        ADC_clearInterruptStatus(ADCA_BASE, ADC_INT_NUMBER1);
        periods++; /* at least one went by unseen: the drive sees the gap */
    }
    periods++;
    fresh = true;
}

BOARD_RAM_CODE static float current_a(uint32_t result)
{
    const float code = (float)ADC_readResult(result, ADC_SOC_NUMBER0);
    return (code - BOARD_CURRENT_ZERO_CODE) * (BOARD_CURRENT_SIGN * BOARD_A_PER_CODE);
}

/* Near full duty the low side of a phase conducts too briefly for its amplifier. Its current then follows from the other
 * two, with the sum of the zero errors put back in, so that what the drive knows of its offset holds for it as well. */
BOARD_RAM_CODE static void replace_unmeasurable(hal_sample_t *s)
{
    uint16_t phase = 0U;
    if (port_pwm_duty_max(&phase) <= BOARD_DUTY_MEASURABLE) {
        zero_sum_a += SUM_GAIN * ((s->ia_a + s->ib_a + s->ic_a) - zero_sum_a);
        return;
    }
    switch (phase) {
    case 0U:
        s->ia_a = zero_sum_a - s->ib_a - s->ic_a;
        break;
    case 1U:
        s->ib_a = zero_sum_a - s->ia_a - s->ic_a;
        break;
    default:
        s->ic_a = zero_sum_a - s->ia_a - s->ib_a;
        break;
    }
}

BOARD_RAM_CODE hal_status_t hal_sample_read(hal_sample_t *out)
{
    out->ia_a = current_a(BOARD_RESULT_A);
    out->ib_a = current_a(BOARD_RESULT_B);
    out->ic_a = current_a(BOARD_RESULT_C);
    out->vdc_v = (float)ADC_readResult(ADCARESULT_BASE, ADC_SOC_NUMBER1) * BOARD_V_PER_CODE;
    out->theta_m_rad = port_encoder_angle_rad();
    out->seq = periods;
    const bool was_fresh = fresh;
    fresh = false;
    if (was_fresh) {
        replace_unmeasurable(out);
    }
    if (port_encoder_failed()) {
        return HAL_SENSOR_FAULT;
    }
    return was_fresh ? HAL_OK : HAL_STALE;
}
