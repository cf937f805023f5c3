/* What switches the bridge off without the CPU, and the arming of it.
 *
 *   nFAULT -> input X-BAR 1 -> TZ1 -> one-shot of ePWM1..3
 *   failed clock -> TZ5, processor halted by a debugger -> TZ6 -> one-shot of ePWM1..3
 *   no current interrupt for two periods (guard.c) -> digital compare B1 -> one-shot of ePWM1..3
 *   shunt voltage -> CMPSS 6, 3, 1 -> ePWM X-BAR trip 4 -> digital compare A1 -> one-shot of ePWM1..3
 *
 * The one-shot pulls both outputs of a module low behind its dead band. Off is the one-shot set; it is set from before
 * the pins are connected until the first arming. */
#include "hal/f28379d/parts.h"

#define HALT_SIGNAL ((uint16_t)((BOARD_TRIP_ON_HALT != 0) ? EPWM_TZ_SIGNAL_OSHT6 : 0U))
#define HARDWARE_SIGNALS                                                                                                         \
    (uint16_t)(EPWM_TZ_SIGNAL_OSHT1 | EPWM_TZ_SIGNAL_OSHT5 | HALT_SIGNAL | EPWM_TZ_SIGNAL_DCAEVT1 | EPWM_TZ_SIGNAL_DCBEVT1)
#define HARDWARE_FLAGS PORT_TRIP_HARDWARE_FLAGS
#define HIGHEST_CODE UINT16_C(4095)
#define TEST_PERIODS 3U /* of the guard's own */

static BOARD_RAM_TABLE uint32_t EPWM[BOARD_PHASES] = BOARD_EPWM_BASES;
static const uint32_t           CMPSS[BOARD_PHASES] = BOARD_CMPSS_BASES;

volatile bool                 port_trip_armed;
static volatile bool          release; /* to be carried out at the next start of a period */
volatile hal_inverter_fault_t port_trip_latched;
static bool                   comparators_proven, guard_proven, given_up; /* by the self test */

static void init_comparator(uint32_t base)
{
    CMPSS_enableModule(base);
    CMPSS_configHighComparator(base, CMPSS_INSRC_DAC);
    CMPSS_configLowComparator(base, CMPSS_INSRC_DAC | CMPSS_INV_INVERTED);
    CMPSS_configDAC(base, CMPSS_DACVAL_SYSCLK | CMPSS_DACREF_VDDA | CMPSS_DACSRC_SHDW);
    CMPSS_setDACValueHigh(base, BOARD_TRIP_CODE(BOARD_TRIP_A));
    CMPSS_setDACValueLow(base, BOARD_TRIP_CODE(-BOARD_TRIP_A));
    CMPSS_configFilterHigh(base, BOARD_TRIP_FILTER_PRESCALE, BOARD_TRIP_FILTER_WINDOW, BOARD_TRIP_FILTER_THRESHOLD);
    CMPSS_configFilterLow(base, BOARD_TRIP_FILTER_PRESCALE, BOARD_TRIP_FILTER_WINDOW, BOARD_TRIP_FILTER_THRESHOLD);
    CMPSS_initFilterHigh(base);
    CMPSS_initFilterLow(base);
    CMPSS_configOutputsHigh(base, CMPSS_TRIP_FILTER);
    CMPSS_configOutputsLow(base, CMPSS_TRIP_FILTER);
}

static void init_module(uint32_t base)
{
    EPWM_setTripZoneAction(base, EPWM_TZ_ACTION_EVENT_TZA, EPWM_TZ_ACTION_LOW); /* the reset state would let the pins float */
    EPWM_setTripZoneAction(base, EPWM_TZ_ACTION_EVENT_TZB, EPWM_TZ_ACTION_LOW);
    /* the events act on outputs A and B by themselves, too, besides setting the one-shot: never let those float either */
    EPWM_setTripZoneAction(base, EPWM_TZ_ACTION_EVENT_DCAEVT1, EPWM_TZ_ACTION_LOW);
    EPWM_setTripZoneAction(base, EPWM_TZ_ACTION_EVENT_DCBEVT1, EPWM_TZ_ACTION_LOW);
    EPWM_selectDigitalCompareTripInput(base, EPWM_DC_TRIP_TRIPIN4, EPWM_DC_TYPE_DCAH);
    EPWM_setTripZoneDigitalCompareEventCondition(base, EPWM_TZ_DC_OUTPUT_A1, EPWM_TZ_EVENT_DCXH_HIGH);
    EPWM_setDigitalCompareEventSource(base, EPWM_DC_MODULE_A, EPWM_DC_EVENT_1, EPWM_DC_EVENT_SOURCE_ORIG_SIGNAL);
    EPWM_setDigitalCompareEventSyncMode(base, EPWM_DC_MODULE_A, EPWM_DC_EVENT_1, EPWM_DC_EVENT_INPUT_NOT_SYNCED);
    EPWM_selectDigitalCompareTripInput(base, EPWM_DC_TRIP_TRIPIN5, EPWM_DC_TYPE_DCBH);
    EPWM_setTripZoneDigitalCompareEventCondition(base, EPWM_TZ_DC_OUTPUT_B1, EPWM_TZ_EVENT_DCXH_HIGH);
    EPWM_setDigitalCompareEventSource(base, EPWM_DC_MODULE_B, EPWM_DC_EVENT_1, EPWM_DC_EVENT_SOURCE_ORIG_SIGNAL);
    EPWM_setDigitalCompareEventSyncMode(base, EPWM_DC_MODULE_B, EPWM_DC_EVENT_1, EPWM_DC_EVENT_INPUT_NOT_SYNCED);
    EPWM_enableTripZoneSignals(base, HARDWARE_SIGNALS);
}

void port_trip_init(void)
{
    static const XBAR_EPWMMuxConfig MUX[BOARD_PHASES] = BOARD_CMPSS_MUX_CONFIGS;
    port_trip_armed = false;
    release = false;
    port_trip_latched = HAL_INVERTER_FINE;
    comparators_proven = false;
    guard_proven = false;
    given_up = false;

    XBAR_setInputPin(XBAR_INPUT1, BOARD_PIN_NFAULT);
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        init_comparator(CMPSS[k]);
        XBAR_setEPWMMuxConfig(XBAR_TRIP4, MUX[k]);
    }
    XBAR_enableEPWMMux(XBAR_TRIP4, BOARD_CMPSS_MUXES);
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        init_module(EPWM[k]);
    }
    hal_inverter_disarm();
}

bool port_trip_is_set(void)
{
    uint16_t flags = EPWM_TZ_FLAG_OST;
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        flags &= EPWM_getTripZoneFlagStatus(EPWM[k]);
    }
    return flags != 0U;
}

/* Clear what the hardware has reported, and hold the bridge off whatever that releases. */
static void clear_hardware_flags(void)
{
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        CMPSS_clearFilterLatchHigh(CMPSS[k]);
        CMPSS_clearFilterLatchLow(CMPSS[k]);
        EPWM_clearOneShotTripZoneFlag(EPWM[k], HARDWARE_FLAGS);
        EPWM_clearTripZoneFlag(EPWM[k], EPWM_TZ_FLAG_DCAEVT1 | EPWM_TZ_FLAG_DCBEVT1 | EPWM_TZ_INTERRUPT);
    }
    hal_inverter_disarm();
}

static bool all_show(uint16_t flag)
{
    uint16_t flags = flag;
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        flags &= EPWM_getOneShotTripZoneFlagStatus(EPWM[k]);
    }
    return flags != 0U;
}

static bool any_shows(uint16_t flag) { return (port_trip_flags() & flag) != 0U; }

/* Quiet at its levels, and each of them, moved over the voltage that is there, trips all modules. */
static bool comparator_works(uint32_t comparator)
{
    clear_hardware_flags();
    const bool quiet = !any_shows(EPWM_TZ_OST_FLAG_DCAEVT1);
    CMPSS_setDACValueHigh(comparator, 0U); /* any voltage is an over-current now */
    SysCtl_delay(BOARD_US(BOARD_TRIP_TEST_US));
    const bool high = all_show(EPWM_TZ_OST_FLAG_DCAEVT1);
    CMPSS_setDACValueHigh(comparator, BOARD_TRIP_CODE(BOARD_TRIP_A));
    SysCtl_delay(BOARD_US(BOARD_TRIP_TEST_US));
    clear_hardware_flags();
    CMPSS_setDACValueLow(comparator, HIGHEST_CODE); /* and now a negative one */
    SysCtl_delay(BOARD_US(BOARD_TRIP_TEST_US));
    const bool low = all_show(EPWM_TZ_OST_FLAG_DCAEVT1);
    CMPSS_setDACValueLow(comparator, BOARD_TRIP_CODE(-BOARD_TRIP_A));
    SysCtl_delay(BOARD_US(BOARD_TRIP_TEST_US));
    return quiet && high && low;
}

static bool comparators_work(void)
{
    bool work = true;
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        work = comparator_works(CMPSS[k]) && work;
    }
    return work;
}

/* Only before the current interrupt runs, which feeds it: quiet while it is fed, and it trips all modules when it is not. */
static bool guard_works(void)
{
    const uint32_t quarter = BOARD_GUARD_CYC / (UINT32_C(4) * UINT32_C(5)); /* a count of SysCtl_delay takes 5 cycles */
    port_guard_feed();
    SysCtl_delay(BOARD_GUARD_PULSE_CYC / UINT32_C(5));
    clear_hardware_flags();
    for (uint16_t k = 0U; k < (4U * TEST_PERIODS); k++) {
        port_guard_feed();
        SysCtl_delay(quarter);
    }
    const bool quiet = !any_shows(EPWM_TZ_OST_FLAG_DCBEVT1);
    SysCtl_delay(quarter * UINT32_C(4));
    return quiet && all_show(EPWM_TZ_OST_FLAG_DCBEVT1);
}

bool port_trip_self_test(void)
{
    guard_proven = guard_works();
    comparators_proven = comparators_work();
    return guard_proven && comparators_proven;
}

void port_trip_give_up(void) { given_up = true; }
bool port_trip_is_given_up(void) { return given_up; }

static bool proven(void) { return guard_proven && comparators_proven && !given_up; }

BOARD_RAM_CODE void hal_inverter_disarm(void)
{
    release = false; /* first: a period that begins in here must not undo what follows */
    port_trip_armed = false;
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        EPWM_forceTripZoneEvent(EPWM[k], EPWM_TZ_FORCE_EVENT_OST);
    }
}

/* First thing in a period: the gates follow the duties from its start on. A standing fault sets the one-shot again. */
BOARD_RAM_CODE void port_trip_release_if_armed(void)
{
    if (!release) {
        return;
    }
    release = false;
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        EPWM_clearTripZoneFlag(EPWM[k], EPWM_TZ_FLAG_OST | EPWM_TZ_INTERRUPT);
    }
}

bool port_trip_bridge_is_off(void) { return !port_trip_armed; }

BOARD_RAM_CODE void port_trip_note(hal_inverter_fault_t fault)
{
    if (port_trip_latched == HAL_INVERTER_FINE) {
        port_trip_latched = fault;
    }
}

BOARD_RAM_CODE static void forget_processor(void)
{
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        EPWM_clearOneShotTripZoneFlag(EPWM[k], PORT_TRIP_PROCESSOR_FLAGS);
    }
}

BOARD_RAM_CODE void port_trip_poll(void)
{
    uint16_t flags = port_trip_flags();
    if (((flags & PORT_TRIP_PROCESSOR_FLAGS) != 0U) && !port_trip_armed) { /* switched nothing off */
        forget_processor();
        flags &= (uint16_t)~PORT_TRIP_PROCESSOR_FLAGS;
    }
    if ((flags & EPWM_TZ_OST_FLAG_DCAEVT1) != 0U) {
        port_trip_note(HAL_INVERTER_OVER_CURRENT);
    } else if ((flags & EPWM_TZ_OST_FLAG_OST6) != 0U) { /* before the guard: a halted processor does not feed it either */
        port_trip_note(HAL_INVERTER_HALTED);
    } else if ((flags & EPWM_TZ_OST_FLAG_OST5) != 0U) {
        port_trip_note(HAL_INVERTER_CLOCK);
    } else if ((flags & EPWM_TZ_OST_FLAG_OST1) != 0U) {
        port_trip_note(HAL_INVERTER_DRIVER_FAULT);
    } else if (flags != 0U) {
        port_trip_note(HAL_INVERTER_LATE);
    } else {
        /* nothing has tripped by itself */
    }
}

BOARD_RAM_CODE hal_inverter_fault_t hal_inverter_fault(void)
{
    port_trip_poll();
    return port_trip_latched;
}

hal_status_t hal_inverter_arm(void)
{
    hal_inverter_fault_t reason = HAL_INVERTER_FINE;
    if (!proven()) {
        port_trip_note(HAL_INVERTER_TRIP_PATH);
    } else if (!port_driver_is_well(&reason)) {
        port_trip_note(reason);
    } else if (port_sampling_zero_is_off()) {
        port_trip_note(HAL_INVERTER_CURRENT_SUM);
    } else {
        /* fine so far */
    }
    /* No interrupt may find a fault between the check and the arming. */
    const bool were_off = Interrupt_disableGlobal();
    const bool fine = hal_inverter_fault() == HAL_INVERTER_FINE;
    if (fine) {
        forget_processor(); /* of before: what comes from here on counts */
        port_trip_armed = true;
        release = true;
    }
    if (!were_off) {
        (void)Interrupt_enableGlobal();
    }
    return fine ? HAL_OK : HAL_SENSOR_FAULT;
}

void hal_inverter_clear_fault(void)
{
    hal_inverter_fault_t reason = HAL_INVERTER_FINE;
    hal_inverter_disarm();
    if (!given_up) { /* else EN_GATE is low */
        (void)port_driver_set_up();
    }
    if (!comparators_proven && !given_up) { /* the amplifiers had no supply at the start */
        comparators_proven = comparators_work();
    }
    clear_hardware_flags();
    port_sampling_forget_sum();
    port_trip_latched = port_self_test_found(); /* after the flags: the current interrupt would find the old ones again */
    if (given_up) {
        port_trip_note(HAL_INVERTER_TRIP_PATH);
    } else if (!port_driver_is_well(&reason)) {
        port_trip_note(reason);
    } else if (!proven()) {
        port_trip_note(HAL_INVERTER_TRIP_PATH);
    } else {
        /* nothing is left */
    }
}
