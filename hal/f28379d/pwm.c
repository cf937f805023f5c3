/* ePWM1..3: time base, duties, dead band, and the start of conversion. */
#include "hal/f28379d/parts.h"

static BOARD_RAM_TABLE uint32_t BASE[BOARD_PHASES] = BOARD_EPWM_BASES;

port_pulses_t        port_pwm_before, port_pwm_after;
static port_pulses_t next; /* set for the next sample */

static void init_time_base(uint32_t base)
{
    EPWM_setClockPrescaler(base, EPWM_CLOCK_DIVIDER_1, EPWM_HSCLOCK_DIVIDER_1);
    EPWM_setTimeBasePeriod(base, BOARD_PWM_COUNTS);
    EPWM_setTimeBaseCounter(base, 0U);
    EPWM_setPeriodLoadMode(base, EPWM_PERIOD_SHADOW_LOAD);
    EPWM_setTimeBaseCounterMode(base, EPWM_COUNTER_MODE_UP_DOWN);
    /* Equal periods and one common start need no sync; a sync would delay the slaves by two counts. */
    EPWM_disablePhaseShiftLoad(base);
    EPWM_setSyncOutPulseMode(base, EPWM_SYNC_OUT_PULSE_DISABLED);
    EPWM_setEmulationMode(base,
                          EPWM_EMULATION_FREE_RUN); /* a halt trips (trip.c); with counters that stand a gate could stay on */
}

static void init_actions(uint32_t base)
{
    EPWM_setCounterCompareShadowLoadMode(base, EPWM_COUNTER_COMPARE_A, EPWM_COMP_LOAD_ON_CNTR_ZERO);
    EPWM_setCounterCompareValue(base, EPWM_COUNTER_COMPARE_A, BOARD_PWM_COUNTS / 2U);
    EPWM_setActionQualifierAction(base, EPWM_AQ_OUTPUT_A, EPWM_AQ_OUTPUT_HIGH, EPWM_AQ_OUTPUT_ON_TIMEBASE_UP_CMPA);
    EPWM_setActionQualifierAction(base, EPWM_AQ_OUTPUT_A, EPWM_AQ_OUTPUT_LOW, EPWM_AQ_OUTPUT_ON_TIMEBASE_DOWN_CMPA);
}

/* Active-high complementary, both edges from A. */
static void init_dead_band(uint32_t base)
{
    EPWM_setRisingEdgeDeadBandDelayInput(base, EPWM_DB_INPUT_EPWMA);
    EPWM_setFallingEdgeDeadBandDelayInput(base, EPWM_DB_INPUT_EPWMA);
    EPWM_setDeadBandDelayPolarity(base, EPWM_DB_RED, EPWM_DB_POLARITY_ACTIVE_HIGH);
    EPWM_setDeadBandDelayPolarity(base, EPWM_DB_FED, EPWM_DB_POLARITY_ACTIVE_LOW);
    EPWM_setRisingEdgeDelayCount(base, BOARD_DEAD_BAND_COUNTS);
    EPWM_setFallingEdgeDelayCount(base, BOARD_DEAD_BAND_COUNTS);
    EPWM_setDeadBandDelayMode(base, EPWM_DB_RED, true);
    EPWM_setDeadBandDelayMode(base, EPWM_DB_FED, true);
}

void port_pwm_init(void)
{
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        init_time_base(BASE[k]);
        init_actions(BASE[k]);
        init_dead_band(BASE[k]);
    }
    const uint16_t      half = BOARD_PWM_COUNTS / 2U;
    const port_pulses_t halves = {{half, half, half}, half};
    port_pwm_before = halves;
    port_pwm_after = halves;
    next = halves;
    EPWM_setADCTriggerSource(EPWM1_BASE, EPWM_SOC_A, EPWM_SOC_TBCTR_ZERO); /* middle of the low-side pulses */
    EPWM_setADCTriggerEventPrescale(EPWM1_BASE, EPWM_SOC_A, 1U);           /* 0 would never fire */
}

void port_pwm_start(void)
{
    EPWM_enableADCTrigger(EPWM1_BASE, EPWM_SOC_A);
    SysCtl_enablePeripheral(SYSCTL_PERIPH_CLK_TBCLKSYNC);
}

/* High from up-count to down-count of CMPA: duty = 1 - CMPA / period, cut to what the bridge can do; a NaN becomes 0. At CMPA =
 * period both events would fall on the turning point; one count less is a pulse of 20 ns, which the dead band swallows. */
static inline float compare_of(float duty)
{
    const float least =
        (float)(uint16_t)(((1.0f - BOARD_DUTY_MAX) * (float)BOARD_PWM_COUNTS) + 0.5f); /* whole: one instruction less */
    const float most = (float)BOARD_PWM_COUNTS - 0.5f;
    const float compare = ((float)BOARD_PWM_COUNTS + 0.5f) - (duty * (float)BOARD_PWM_COUNTS);
    return port_max(port_min(compare, most), least);
}

BOARD_RAM_CODE hal_status_t hal_inverter_set_duty(const hal_duty_t *duty)
{
    const float    compare_a = compare_of(duty->a);
    const float    compare_b = compare_of(duty->b);
    const float    compare_c = compare_of(duty->c);
    const uint16_t a = (uint16_t)compare_a;
    const uint16_t b = (uint16_t)compare_b;
    const uint16_t c = (uint16_t)compare_c;
    EPWM_setCounterCompareValue(EPWM1_BASE, EPWM_COUNTER_COMPARE_A, a);
    EPWM_setCounterCompareValue(EPWM2_BASE, EPWM_COUNTER_COMPARE_A, b);
    EPWM_setCounterCompareValue(EPWM3_BASE, EPWM_COUNTER_COMPARE_A, c);
    next.compare[0] = a;
    next.compare[1] = b;
    next.compare[2] = c;
    next.longest = (uint16_t)port_min(compare_a, port_min(compare_b, compare_c));
    return HAL_OK;
}

BOARD_RAM_CODE void port_pwm_sampled(void)
{
    port_pwm_before = port_pwm_after;
    port_pwm_after = next;
}
