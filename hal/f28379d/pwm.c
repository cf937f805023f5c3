/* ePWM1..3: time base, duties, dead band, and the start of conversion. */
#include "hal/f28379d/parts.h"

static BOARD_RAM_TABLE uint32_t BASE[BOARD_PHASES] = BOARD_EPWM_BASES;

/* Duty in force before the newest sample, set to come into force at it, and set for the next one. */
static float before[BOARD_PHASES], after[BOARD_PHASES], next[BOARD_PHASES];

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
    EPWM_setEmulationMode(base, EPWM_EMULATION_FREE_RUN); /* a breakpoint must not freeze a gate in the on state */
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
        before[k] = 0.5f;
        after[k] = 0.5f;
        next[k] = 0.5f;
    }
    EPWM_setADCTriggerSource(EPWM1_BASE, EPWM_SOC_A, EPWM_SOC_TBCTR_ZERO); /* middle of the low-side pulses */
    EPWM_setADCTriggerEventPrescale(EPWM1_BASE, EPWM_SOC_A, 1U);           /* 0 would never fire */
}

void port_pwm_start(void)
{
    EPWM_enableADCTrigger(EPWM1_BASE, EPWM_SOC_A);
    SysCtl_enablePeripheral(SYSCTL_PERIPH_CLK_TBCLKSYNC);
}

/* Cut to what the bridge can do; a NaN becomes 0. */
static float cut(float duty)
{
    return (duty > 0.0f) ? ((duty < BOARD_DUTY_MAX) ? duty : BOARD_DUTY_MAX) : 0.0f;
}

/* High from up-count to down-count of CMPA: duty = 1 - CMPA / period. At CMPA = period both events would fall on the
 * turning point; one count less is a pulse of 20 ns, which the dead band swallows. */
static uint16_t compare_of(float duty)
{
    const uint16_t on = (uint16_t)((duty * (float)BOARD_PWM_COUNTS) + 0.5f);
    return (on > 0U) ? (uint16_t)(BOARD_PWM_COUNTS - on) : (uint16_t)(BOARD_PWM_COUNTS - 1U);
}

BOARD_RAM_CODE hal_status_t hal_inverter_set_duty(const hal_duty_t *duty)
{
    const float wanted[BOARD_PHASES] = {duty->a, duty->b, duty->c};
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        next[k] = cut(wanted[k]);
        EPWM_setCounterCompareValue(BASE[k], EPWM_COUNTER_COMPARE_A, compare_of(next[k]));
    }
    return HAL_OK;
}

BOARD_RAM_CODE void port_pwm_sampled(void)
{
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        before[k] = after[k];
        after[k] = next[k];
    }
}

BOARD_RAM_CODE float port_pwm_duty_max(uint16_t *phase)
{
    float largest = -1.0f;
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        const float duty = (before[k] > after[k]) ? before[k] : after[k];
        if (duty > largest) {
            largest = duty;
            *phase = k;
        }
    }
    return largest;
}
