/* What switches the bridge off without the CPU, and the arming of it.
 *
 *   nFAULT -> input X-BAR 1 -> TZ1 -> one-shot of ePWM1..3
 *   shunt voltage -> CMPSS 6, 3, 1 -> ePWM X-BAR trip 4 -> digital compare A1 -> one-shot of ePWM1..3
 *
 * The one-shot pulls both outputs of a module low behind its dead band. Off is the one-shot set; it is set from before
 * the pins are connected until the first arming. */
#include "hal/f28379d/parts.h"

#define HARDWARE_SIGNALS (EPWM_TZ_SIGNAL_OSHT1 | EPWM_TZ_SIGNAL_DCAEVT1)
#define HARDWARE_FLAGS PORT_TRIP_HARDWARE_FLAGS

static BOARD_RAM_TABLE uint32_t EPWM[BOARD_PHASES] = BOARD_EPWM_BASES;
static const uint32_t           CMPSS[BOARD_PHASES] = BOARD_CMPSS_BASES;

static volatile bool          armed;   /* from hal_inverter_arm on... */
static volatile bool          release; /* ...and to be carried out at the next start of a period */
volatile hal_inverter_fault_t port_trip_latched;
static bool                   proven; /* by the self test */

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
    /* the event acts on output A by itself, too, besides setting the one-shot: never let it float either */
    EPWM_setTripZoneAction(base, EPWM_TZ_ACTION_EVENT_DCAEVT1, EPWM_TZ_ACTION_LOW);
    EPWM_selectDigitalCompareTripInput(base, EPWM_DC_TRIP_TRIPIN4, EPWM_DC_TYPE_DCAH);
    EPWM_setTripZoneDigitalCompareEventCondition(base, EPWM_TZ_DC_OUTPUT_A1, EPWM_TZ_EVENT_DCXH_HIGH);
    EPWM_setDigitalCompareEventSource(base, EPWM_DC_MODULE_A, EPWM_DC_EVENT_1, EPWM_DC_EVENT_SOURCE_ORIG_SIGNAL);
    EPWM_setDigitalCompareEventSyncMode(base, EPWM_DC_MODULE_A, EPWM_DC_EVENT_1, EPWM_DC_EVENT_INPUT_NOT_SYNCED);
    EPWM_enableTripZoneSignals(base, HARDWARE_SIGNALS);
}

void port_trip_init(void)
{
    static const XBAR_EPWMMuxConfig MUX[BOARD_PHASES] = BOARD_CMPSS_MUX_CONFIGS;
    armed = false;
    release = false;
    port_trip_latched = HAL_INVERTER_FINE;
    proven = false;

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
        EPWM_clearTripZoneFlag(EPWM[k], EPWM_TZ_FLAG_DCAEVT1 | EPWM_TZ_INTERRUPT);
    }
    hal_inverter_disarm();
}

static bool trips_all_modules(uint32_t comparator)
{
    clear_hardware_flags();
    CMPSS_setDACValueHigh(comparator, 0U); /* any voltage is an over-current now */
    SysCtl_delay(BOARD_US(BOARD_TRIP_TEST_US));
    bool all = true;
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        all = all && ((EPWM_getOneShotTripZoneFlagStatus(EPWM[k]) & EPWM_TZ_OST_FLAG_DCAEVT1) != 0U);
    }
    CMPSS_setDACValueHigh(comparator, BOARD_TRIP_CODE(BOARD_TRIP_A));
    SysCtl_delay(BOARD_US(BOARD_TRIP_TEST_US));
    return all;
}

bool port_trip_self_test(void)
{
    proven = true;
    for (uint16_t k = 0U; k < BOARD_PHASES; k++) {
        proven = trips_all_modules(CMPSS[k]) && proven;
    }
    return proven;
}

BOARD_RAM_CODE void hal_inverter_disarm(void)
{
    release = false; /* first: a period that begins in here must not undo what follows */
    armed = false;
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

bool port_trip_bridge_is_off(void) { return !armed; }

BOARD_RAM_CODE void port_trip_note(hal_inverter_fault_t fault)
{
    if (port_trip_latched == HAL_INVERTER_FINE) {
        port_trip_latched = fault;
    }
}

BOARD_RAM_CODE void port_trip_look(void)
{
    const uint16_t flags = port_trip_flags();
    if ((flags & EPWM_TZ_OST_FLAG_DCAEVT1) != 0U) {
        port_trip_note(HAL_INVERTER_OVER_CURRENT);
    } else if (flags != 0U) {
        port_trip_note(HAL_INVERTER_DRIVER_FAULT);
    } else {
        /* nothing has tripped by itself */
    }
}

BOARD_RAM_CODE hal_inverter_fault_t hal_inverter_fault(void)
{
    port_trip_look();
    return port_trip_latched;
}

hal_status_t hal_inverter_arm(void)
{
    hal_inverter_fault_t reason = HAL_INVERTER_FINE;
    if (!proven || !port_driver_is_well(&reason)) {
        port_trip_note((reason != HAL_INVERTER_FINE) ? reason : HAL_INVERTER_DRIVER_FAULT);
    }
    /* No interrupt may find a fault between the look and the arming. */
    const bool were_off = Interrupt_disableGlobal();
    const bool fine = hal_inverter_fault() == HAL_INVERTER_FINE;
    if (fine) {
        armed = true;
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
    port_driver_clear();
    clear_hardware_flags();
    port_trip_latched = HAL_INVERTER_FINE; /* after the flags: the current interrupt would find the old ones again */
    if (!port_driver_is_well(&reason)) {
        port_trip_note(reason);
    }
}
