/* ADC A, B, C, triggered together by ePWM1 at zero; three shunts, of which two are enough. */
#include "hal/hal_sample.h"

#include "hal/f28379d/parts.h"

#define SUM_GAIN (1.0f / 64.0f)
#define LATE_CYC (BOARD_PERIOD_CYC / 8U) /* an interrupt that comes so much before the next but one is due has lost nothing */

static volatile uint32_t periods; /* PWM periods that were sampled or lost */
static volatile bool     fresh;
static bool              begun;       /* there has been an interrupt */
static uint32_t          due_cyc;     /* time at which it was due, or the earliest that is known of it */
static float             zero_sum_a;  /* mean of ia + ib + ic as read, bridge off: the sum of the three zero errors */
static volatile float    sum_error_a; /* bridge on: mean of |ia + ib + ic| beyond that */
volatile uint32_t        port_sampling_lost;

void port_sampling_init(void)
{
    static const uint32_t BASE[] = BOARD_ADC_BASES;
    periods = 0U;
    fresh = false;
    begun = false;
    zero_sum_a = 0.0f;
    sum_error_a = 0.0f;
    port_sampling_lost = 0U;
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

/* Periods since the last interrupt, from the clock: the converter's overflow flag says one whether one was lost or a thousand. An
 * interrupt is never early, so the earliest of them show when they are due. */
BOARD_RAM_CODE static uint32_t periods_since(uint32_t now_cyc)
{
    const uint32_t since_cyc = now_cyc - due_cyc;
    if (!begun || (since_cyc < BOARD_PERIOD_CYC)) {
        begun = true;
        due_cyc = now_cyc;
        return 1U;
    }
    if (since_cyc < ((2U * BOARD_PERIOD_CYC) - LATE_CYC)) {
        due_cyc += BOARD_PERIOD_CYC;
        return 1U;
    }
    const uint32_t passed = (since_cyc + LATE_CYC) / BOARD_PERIOD_CYC;
    due_cyc += passed * BOARD_PERIOD_CYC;
    port_sampling_lost += passed - 1U;
    return passed;
}

/* Without clearing a set overflow flag the converter would never interrupt again. */
BOARD_RAM_CODE void port_sampling_take(void)
{
    ADC_clearInterruptStatus(ADCA_BASE, ADC_INT_NUMBER1);
    if (ADC_getInterruptOverflowStatus(ADCA_BASE, ADC_INT_NUMBER1)) {
        ADC_clearInterruptOverflowStatus(ADCA_BASE, ADC_INT_NUMBER1);
        ADC_clearInterruptStatus(ADCA_BASE, ADC_INT_NUMBER1);
    }
    periods += periods_since(port_encoder.at_cyc);
    fresh = true;
}

bool port_sampling_zero_is_off(void)
{
    const float most_a = 3.0f * BOARD_OFFSET_LIMIT_A;
    return (zero_sum_a > most_a) || (zero_sum_a < -most_a);
}

bool port_sampling_sum_is_off(void) { return sum_error_a > BOARD_SUM_LIMIT_A; }

void port_sampling_forget_sum(void) { sum_error_a = 0.0f; }

/* The interrupts were kept away on purpose, with the bridge off: what the converter finished meanwhile is no lost sample. */
BOARD_RAM_CODE void port_sampling_resume(void)
{
    ADC_clearInterruptStatus(ADCA_BASE, ADC_INT_NUMBER1);
    begun = false; /* the next interrupt is the first again */
    ADC_clearInterruptOverflowStatus(ADCA_BASE, ADC_INT_NUMBER1);
    ADC_clearInterruptStatus(ADCA_BASE, ADC_INT_NUMBER1);
}

static inline float current_a(uint32_t result)
{
    return ((float)ADC_readResult(result, ADC_SOC_NUMBER0) * (BOARD_CURRENT_SIGN * BOARD_A_PER_CODE)) -
           (BOARD_CURRENT_ZERO_CODE * (BOARD_CURRENT_SIGN * BOARD_A_PER_CODE));
}

/* 2^32 / counts a count: its whole part, and its 2^-16 for what is left. */
static inline uint32_t angle_of(uint32_t position)
{
    return (position * BOARD_ANGLE_PER_COUNT) + ((position * BOARD_ANGLE_REST_16) >> 16);
}

/* Near full duty the low side of a phase conducts too briefly for its amplifier. Its current then follows from the other
 * two, with the sum of the zero errors put back in, so that what the drive knows of its offset holds for it as well:
 * @p deviation_a is that sum less the sum of what was read. */
static inline void replace_unmeasurable(hal_sample_t *s, float deviation_a)
{
    const port_pulses_t *const p = (port_pwm_before.longest < port_pwm_after.longest) ? &port_pwm_before : &port_pwm_after;
    if (p->longest == p->compare[0]) {
        s->ia_a += deviation_a;
    } else if (p->longest == p->compare[1]) {
        s->ib_a += deviation_a;
    } else {
        s->ic_a += deviation_a;
    }
}

/* Classify an abnormal sample. */
BOARD_RAM_CODE static hal_status_t look_again(bool was_fresh)
{
    port_trip_poll();
    if (port_encoder.failed) {
        return HAL_SENSOR_FAULT;
    }
    if (!was_fresh) {
        return HAL_STALE;
    }
    return (port_trip_latched != HAL_INVERTER_FINE) ? HAL_TRIPPED : HAL_OK;
}

BOARD_RAM_CODE hal_status_t hal_sample_read(hal_sample_t *out)
{
    const float a = current_a(BOARD_RESULT_A);
    const float b = current_a(BOARD_RESULT_B);
    const float c = current_a(BOARD_RESULT_C);
    const bool  was_fresh = fresh;
    fresh = false;
    out->ia_a = a;
    out->ib_a = b;
    out->ic_a = c;
    out->vdc_v = (float)ADC_readResult(ADCARESULT_BASE, ADC_SOC_NUMBER1) * BOARD_V_PER_CODE;
    out->theta_m = angle_of(port_encoder.position);
    out->at_cyc = port_encoder.at_cyc;
    out->seq = periods;

    const float deviation_a = zero_sum_a - (a + b + c);
    if ((port_pwm_before.longest < BOARD_COMPARE_MEASURABLE) | (port_pwm_after.longest < BOARD_COMPARE_MEASURABLE)) {
        replace_unmeasurable(out, deviation_a);
    } else if (port_trip_armed) {
        const float error_a = sum_error_a; /* volatile: read once */
        sum_error_a = error_a + (SUM_GAIN * (port_max(deviation_a, -deviation_a) - error_a));
    } else {
        zero_sum_a -= SUM_GAIN * deviation_a; /* a second read of the same sample does no harm */
    }
    /* | instead of ||: one branch for everything abnormal */
    return ((!was_fresh) | port_encoder.failed | (port_trip_flags() != 0U) | (port_trip_latched != HAL_INVERTER_FINE))
               ? look_again(was_fresh)
               : HAL_OK;
}
