#include "fake_chip.h"

#include <string.h>

#include "hal/f28379d/board.h"

#define LOG_MAX 200000 /* then it starts again: the virtual chip runs for long */

typedef struct {
    const char *name;
    int         count;
    uint32_t    argument[FAKE_ARGUMENTS];
} call_t;

fake_chip_t       chip;
volatile uint16_t IER, IFR;

static call_t log_of_calls[LOG_MAX];
static int    calls;

/* ---- record ---------------------------------------------------------------------------------------------------------- */

void fake_record(const char *name, int count, const uint32_t *arguments)
{
    calls = (calls < LOG_MAX) ? calls : 0;
    call_t *const c = &log_of_calls[calls++];
    c->name = name;
    c->count = count;
    for (int i = 0; i < count; i++) {
        c->argument[i] = arguments[i];
    }
    if ((chip.interrupted_call != NULL) && (strcmp(chip.interrupted_call, name) == 0) && (chip.calls_before-- == 0)) {
        chip.interrupted_call = NULL;
        chip.interrupt();
    }
}

void        fake_forget_calls(void) { calls = 0; }
int         fake_call_count(void) { return calls; }
const char *fake_call_name(int number) { return ((number >= 0) && (number < calls)) ? log_of_calls[number].name : ""; }

static bool agrees(const call_t *c, const char *name, int count, const uint32_t *arguments)
{
    bool same = (strcmp(c->name, name) == 0) && (c->count >= count);
    for (int i = 0; same && (i < count); i++) {
        same = c->argument[i] == arguments[i];
    }
    return same;
}

int fake_find(int from, const char *name, int count, const uint32_t *arguments)
{
    for (int i = (from > 0) ? from : 0; i < calls; i++) {
        if (agrees(&log_of_calls[i], name, count, arguments)) {
            return i;
        }
    }
    return -1;
}

int fake_count(const char *name, int count, const uint32_t *arguments)
{
    int n = 0;
    for (int i = 0; i < calls; i++) {
        n += agrees(&log_of_calls[i], name, count, arguments) ? 1 : 0;
    }
    return n;
}

/* ---- power on, time -------------------------------------------------------------------------------------------------------- */

void fake_power_on(void)
{
    (void)memset(&chip, 0, sizeof chip);
    chip.reset_cause = 1U;
    calls = 0;
    IER = 0;
    IFR = 0;
    chip.pll_locks = true;
    chip.intm = true;
    chip.cycles = 1000U;
    chip.drv[0x5] = 0x344; /* values at reset */
    chip.drv[0x6] = 0x344;
    chip.drv[0x7] = 0x216;
    chip.drv[0x9] = 0x020;
    chip.drv[0xB] = 0x10A;
    chip.drv[0xC] = 0x0C8;
    chip.qep_direction = 1;
    chip.tx_room = 16;
    for (int k = 0; k < 3; k++) {
        chip.cmpss[k].volts = 1.65;
    }
    chip.dc_link_pin_v = 24.0 / 13.42;
}

bool SysCtl_setClock(uint32_t config)
{
    RECORD(config);
    return chip.pll_locks;
}
uint32_t SysCtl_getResetCause(void)
{
    RECORD_NONE();
    return chip.reset_cause;
}
void SysCtl_delay(uint32_t count)
{
    RECORD(count);
    chip.cycles += (5U * (uint64_t)count) + 9U;
    fake_trips();
}
void SysCtl_enablePeripheral(SysCtl_PeripheralPCLOCKCR peripheral)
{
    RECORD((uint32_t)peripheral);
    chip.clocks_run = chip.clocks_run || (peripheral == SYSCTL_PERIPH_CLK_TBCLKSYNC);
}
void SysCtl_disablePeripheral(SysCtl_PeripheralPCLOCKCR peripheral)
{
    RECORD((uint32_t)peripheral);
    chip.clocks_run = chip.clocks_run && (peripheral != SYSCTL_PERIPH_CLK_TBCLKSYNC);
}
void SysCtl_enableWatchdog(void)
{
    RECORD_NONE();
    chip.watchdog_on = true;
}
void SysCtl_disableWatchdog(void)
{
    RECORD_NONE();
    chip.watchdog_on = false;
}
void SysCtl_serviceWatchdog(void)
{
    RECORD_NONE();
    const uint64_t least = (uint64_t)chip.watchdog_window * 40960U;
    chip.watchdog_too_soon += ((least > 0U) && ((chip.cycles - chip.watchdog_cycles) <= least)) ? 1 : 0;
    chip.watchdog_cycles = chip.cycles;
    chip.watchdog_served++;
}
void SysCtl_setWatchdogWindowValue(uint16_t value)
{
    RECORD(value);
    chip.watchdog_window = value;
}
uint16_t SysCtl_getNMIShadowFlagStatus(void)
{
    RECORD_NONE();
    return chip.nmi_shadow;
}
uint32_t MemCfg_getCorrErrorCount(void)
{
    RECORD_NONE();
    return chip.ram_errors;
}
uint32_t Flash_getErrorCount(uint32_t eccBase)
{
    RECORD(eccBase);
    return chip.flash_errors;
}
uint32_t *fake_register(uint32_t address)
{
    static uint32_t other;
    return (address == (CPUSYS_BASE + SYSCTL_O_PIEVERRADDR)) ? &chip.pie_error_address : &other;
}

void fake_halt(uint64_t cycles)
{
    chip.halted = true;
    fake_trips();
    chip.cycles += cycles;
    fake_trips();
    chip.halted = false;
}

void CPUTimer_startTimer(uint32_t base)
{
    RECORD(base);
    chip.timer_start = chip.cycles;
}
uint32_t CPUTimer_getTimerCount(uint32_t base)
{
    RECORD(base);
    chip.cycles += 4U;
    if ((chip.on_clock != NULL) && chip.clocks_run && (chip.depth == 0U)) {
        chip.on_clock();
    }
    const uint32_t count = 0xFFFFFFFFU - (uint32_t)(chip.cycles - chip.timer_start);
    chip.cycles += (chip.depth > 0U) ? chip.interrupt_cycles : 0U;
    return count;
}

/* ---- interrupts ---------------------------------------------------------------------------------------------------------------- */

void fake_eint(void)
{
    fake_record("EINT", 0, NULL);
    chip.intm = false;
    if (chip.on_eint != NULL) {
        void (*const once)(void) = chip.on_eint;
        chip.on_eint = NULL;
        once();
    }
    fake_interrupts();
}
void fake_dint(void)
{
    fake_record("DINT", 0, NULL);
    chip.intm = true;
}
void fake_nop(void)
{
    if (chip.escape_set) {
        chip.escape_set = false;
        longjmp(chip.escape, 1);
    }
}
void Interrupt_register(uint32_t interruptNumber, void (*handler)(void))
{
    RECORD(interruptNumber);
    chip.vector[interruptNumber >> 16] = handler;
}
void Interrupt_enable(uint32_t interruptNumber)
{
    RECORD(interruptNumber);
    const uint32_t group = (interruptNumber >> 8) & 0xFFU;
    IER |= (uint16_t)((group != 0U) ? (1U << (group - 1U)) : (1U << ((interruptNumber >> 16) - 1U)));
}
void Interrupt_clearACKGroup(uint16_t group)
{
    RECORD(group);
    chip.pie_ack_group1 = chip.pie_ack_group1 && ((group & 1U) == 0U);
}
bool Interrupt_disableGlobal(void)
{
    RECORD_NONE();
    const bool before = chip.intm;
    chip.intm = true;
    return before;
}
bool Interrupt_enableGlobal(void)
{
    RECORD_NONE();
    const bool before = chip.intm;
    chip.intm = false;
    fake_interrupts();
    return before;
}

/* What the hardware does around an interrupt: IER is saved, its own bit and INTM are off inside, IRET restores. */
static void take(uint32_t vector, uint16_t own_bit)
{
    const uint16_t saved = IER;
    IER = (uint16_t)(IER & ~own_bit);
    chip.intm = true;
    chip.depth++;
    chip.deepest = (chip.depth > chip.deepest) ? chip.depth : chip.deepest;
    chip.vector[vector]();
    chip.depth--;
    IER = saved;
    chip.intm = false;
}

void fake_interrupts(void)
{
    while (!chip.intm) {
        if (chip.adc_pending && !chip.pie_ack_group1 && ((IER & INTERRUPT_CPU_INT1) != 0U)) {
            chip.adc_pending = false;
            chip.pie_ack_group1 = true; /* nothing more from group 1 until it is acknowledged */
            take(0x20, INTERRUPT_CPU_INT1);
        } else if ((IFR & IER & INTERRUPT_CPU_INT14) != 0U) {
            IFR = (uint16_t)(IFR & ~INTERRUPT_CPU_INT14);
            take(14, INTERRUPT_CPU_INT14);
        } else {
            return;
        }
    }
}

/* ---- pins --------------------------------------------------------------------------------------------------------------------------- */

static bool nfault_is_low(void) { return chip.nfault_stuck || ((chip.drv[1] | chip.drv[2] | chip.drv[3] | chip.drv[4]) != 0U); }

uint32_t GPIO_readPin(uint32_t pin)
{
    RECORD(pin);
    return (pin == BOARD_PIN_NFAULT) ? (nfault_is_low() ? 0U : 1U) : chip.latch[pin];
}
void GPIO_writePin(uint32_t pin, uint32_t outVal)
{
    RECORD(pin, outVal);
    if ((pin == BOARD_PIN_EN_GATE) && (outVal != 0U) && (chip.latch[pin] == 0U)) {
        chip.en_gate_cycles = chip.cycles;
    }
    chip.latch[pin] = outVal;
}
void GPIO_setDirectionMode(uint32_t pin, GPIO_Direction pinIO)
{
    RECORD(pin, (uint32_t)pinIO);
    chip.is_output[pin] = pinIO == GPIO_DIR_MODE_OUT;
}
void GPIO_lockPortConfig(GPIO_Port port, uint32_t pinMask)
{
    RECORD((uint32_t)port, pinMask);
    chip.port_a_locked |= pinMask;
}
void GPIO_setPadConfig(uint32_t pin, uint32_t pinType)
{
    RECORD(pin, pinType);
    chip.locked_writes += ((pin < 32U) && ((chip.port_a_locked & (1UL << pin)) != 0U)) ? 1 : 0;
    chip.pulled_up[pin] = (pinType & GPIO_PIN_TYPE_PULLUP) != 0U;
}

static int gate_pin(uint32_t config)
{
    static const uint32_t GATE[6] = BOARD_PWM_PIN_CONFIGS;
    for (int i = 0; i < 6; i++) {
        if (GATE[i] == config) {
            return i;
        }
    }
    return -1;
}
void GPIO_setPinConfig(uint32_t pinConfig)
{
    RECORD(pinConfig);
    const int pin = gate_pin(pinConfig);
    if (pin >= 0) {
        const fake_epwm_t *const e = &chip.epwm[pin / 2];
        chip.pin_config[pin] = pinConfig;
        if (((e->tz_flags & EPWM_TZ_FLAG_OST) == 0U) || !e->action_low[pin % 2] || !e->action_low[2] || !e->action_low[4] ||
            chip.pulled_up[pin]) {
            chip.unsafe_connections++;
        }
    }
}

/* ---- bridge ----------------------------------------------------------------------------------------------------------------------------- */

static fake_epwm_t *epwm_of(uint32_t base) { return &chip.epwm[(base - EPWM1_BASE) / 0x100U]; }

void EPWM_setTimeBasePeriod(uint32_t base, uint16_t periodCount)
{
    RECORD(base, periodCount);
    epwm_of(base)->period = periodCount;
}
void EPWM_setCounterCompareValue(uint32_t base, EPWM_CounterCompareModule compModule, uint16_t compCount)
{
    RECORD(base, (uint32_t)compModule, compCount);
    epwm_of(base)->compare = compCount;
}
void EPWM_setActionQualifierAction(uint32_t base, EPWM_ActionQualifierOutputModule epwmOutput, EPWM_ActionQualifierOutput output,
                                   EPWM_ActionQualifierOutputEvent event)
{
    RECORD(base, (uint32_t)epwmOutput, (uint32_t)output, (uint32_t)event);
    fake_epwm_t *const e = epwm_of(base);
    e->rises_on_up = e->rises_on_up || ((output == EPWM_AQ_OUTPUT_HIGH) && (event == EPWM_AQ_OUTPUT_ON_TIMEBASE_UP_CMPA));
    e->falls_on_down = e->falls_on_down || ((output == EPWM_AQ_OUTPUT_LOW) && (event == EPWM_AQ_OUTPUT_ON_TIMEBASE_DOWN_CMPA));
}
void EPWM_setRisingEdgeDelayCount(uint32_t base, uint16_t redCount)
{
    RECORD(base, redCount);
    epwm_of(base)->red = redCount;
}
void EPWM_setFallingEdgeDelayCount(uint32_t base, uint16_t fedCount)
{
    RECORD(base, fedCount);
    epwm_of(base)->fed = fedCount;
}
void EPWM_enableTripZoneSignals(uint32_t base, uint16_t tzSignal)
{
    RECORD(base, tzSignal);
    epwm_of(base)->tz_signals = (uint16_t)(epwm_of(base)->tz_signals | tzSignal);
}
void EPWM_setTripZoneAction(uint32_t base, EPWM_TripZoneEvent tzEvent, EPWM_TripZoneAction tzAction)
{
    RECORD(base, (uint32_t)tzEvent, (uint32_t)tzAction);
    epwm_of(base)->action_low[(int)tzEvent / 2] = tzAction == EPWM_TZ_ACTION_LOW;
}
void EPWM_selectDigitalCompareTripInput(uint32_t base, EPWM_DigitalCompareTripInput tripSource, EPWM_DigitalCompareType dcType)
{
    RECORD(base, (uint32_t)tripSource, (uint32_t)dcType);
    if (dcType == EPWM_DC_TYPE_DCAH) {
        epwm_of(base)->dc_input[0] = tripSource == EPWM_DC_TRIP_TRIPIN4;
    } else {
        epwm_of(base)->dc_input[1] = tripSource == EPWM_DC_TRIP_TRIPIN5;
    }
}
void EPWM_setTripZoneDigitalCompareEventCondition(uint32_t base, EPWM_TripZoneDigitalCompareOutput dcType,
                                                  EPWM_TripZoneDigitalCompareOutputEvent dcEvent)
{
    RECORD(base, (uint32_t)dcType, (uint32_t)dcEvent);
    epwm_of(base)->dc_condition[(dcType == EPWM_TZ_DC_OUTPUT_A1) ? 0 : 1] = dcEvent == EPWM_TZ_EVENT_DCXH_HIGH;
}
void EPWM_setDigitalCompareEventSource(uint32_t base, EPWM_DigitalCompareModule dcModule, EPWM_DigitalCompareEvent dcEvent,
                                       EPWM_DigitalCompareEventSource dcEventSource)
{
    RECORD(base, (uint32_t)dcModule, (uint32_t)dcEvent, (uint32_t)dcEventSource);
    epwm_of(base)->dc_source[dcModule] = true;
}
void EPWM_setDigitalCompareEventSyncMode(uint32_t base, EPWM_DigitalCompareModule dcModule, EPWM_DigitalCompareEvent dcEvent,
                                         EPWM_DigitalCompareSyncMode syncMode)
{
    RECORD(base, (uint32_t)dcModule, (uint32_t)dcEvent, (uint32_t)syncMode);
    epwm_of(base)->dc_direct[dcModule] = syncMode == EPWM_DC_EVENT_INPUT_NOT_SYNCED;
}
uint16_t EPWM_getTripZoneFlagStatus(uint32_t base)
{
    RECORD(base);
    return epwm_of(base)->tz_flags;
}
uint16_t EPWM_getOneShotTripZoneFlagStatus(uint32_t base)
{
    RECORD(base);
    return epwm_of(base)->ost_flags;
}
void EPWM_clearTripZoneFlag(uint32_t base, uint16_t tzFlags)
{
    RECORD(base, tzFlags);
    epwm_of(base)->tz_flags = (uint16_t)(epwm_of(base)->tz_flags & ~tzFlags);
    fake_trips(); /* a standing source sets it again */
}
void EPWM_clearOneShotTripZoneFlag(uint32_t base, uint16_t tzOSTFlags)
{
    RECORD(base, tzOSTFlags);
    epwm_of(base)->ost_flags = (uint16_t)(epwm_of(base)->ost_flags & ~tzOSTFlags);
    fake_trips();
}
void EPWM_forceTripZoneEvent(uint32_t base, uint16_t tzForceEvent)
{
    RECORD(base, tzForceEvent);
    if (chip.trip_zone_dead) {
        return;
    }
    epwm_of(base)->tz_flags = (uint16_t)(epwm_of(base)->tz_flags | (tzForceEvent & EPWM_TZ_FORCE_EVENT_OST));
}
void EPWM_enableADCTrigger(uint32_t base, EPWM_ADCStartOfConversionType adcSOCType)
{
    RECORD(base, (uint32_t)adcSOCType);
    chip.soc_enabled = base == EPWM1_BASE;
}
void EPWM_setADCTriggerEventPrescale(uint32_t base, EPWM_ADCStartOfConversionType adcSOCType, uint16_t preScaleCount)
{
    RECORD(base, (uint32_t)adcSOCType, preScaleCount);
    chip.soc_prescale = preScaleCount;
}
void XBAR_setInputPin(XBAR_InputNum input, uint16_t pin)
{
    RECORD((uint32_t)input, pin);
    chip.locked_writes += chip.input_locked ? 1 : 0;
    chip.input_xbar1 = pin;
}
void XBAR_setEPWMMuxConfig(XBAR_TripNum trip, XBAR_EPWMMuxConfig muxConfig)
{
    RECORD((uint32_t)trip, (uint32_t)muxConfig);
    chip.locked_writes += chip.xbar_locked ? 1 : 0;
    if (trip == XBAR_TRIP5) {
        chip.guard_routed = muxConfig == XBAR_EPWM_MUX00_ECAP1_OUT;
        return;
    }
    chip.cmpss[0].routed = chip.cmpss[0].routed || (muxConfig == XBAR_EPWM_MUX10_CMPSS6_CTRIPH_OR_L);
    chip.cmpss[1].routed = chip.cmpss[1].routed || (muxConfig == XBAR_EPWM_MUX04_CMPSS3_CTRIPH_OR_L);
    chip.cmpss[2].routed = chip.cmpss[2].routed || (muxConfig == XBAR_EPWM_MUX00_CMPSS1_CTRIPH_OR_L);
}
void XBAR_enableEPWMMux(XBAR_TripNum trip, uint32_t muxes)
{
    RECORD((uint32_t)trip, muxes);
    chip.locked_writes += chip.xbar_locked ? 1 : 0;
    if (trip == XBAR_TRIP5) {
        chip.guard_enabled = (muxes & XBAR_MUX00) != 0U;
        return;
    }
    chip.epwm_xbar_muxes |= muxes;
}
void XBAR_lockInput(XBAR_InputNum input)
{
    RECORD((uint32_t)input);
    chip.input_locked = true;
}
void XBAR_lockEPWM(void)
{
    RECORD_NONE();
    chip.xbar_locked = true;
}

/* ---- guard: the counter of the eCAP, and the pulses that its output has made since it was fed last ---- */

void ECAP_stopCounter(uint32_t base)
{
    RECORD(base);
    chip.guard_on = false;
}
void ECAP_startCounter(uint32_t base)
{
    RECORD(base);
    chip.guard_on = true;
    chip.guard_fed_cycles = chip.cycles;
    chip.guard_pulses = 0U;
}
void ECAP_enableAPWMMode(uint32_t base)
{
    RECORD(base);
    chip.guard_apwm = true;
}
void ECAP_setAPWMPolarity(uint32_t base, ECAP_APWMPolarity polarity)
{
    RECORD(base, (uint32_t)polarity);
    chip.guard_active_low = polarity == ECAP_APWM_ACTIVE_LOW;
}
void ECAP_setAPWMPeriod(uint32_t base, uint32_t periodCount)
{
    RECORD(base, periodCount);
    chip.guard_period = periodCount;
}
void ECAP_setAPWMCompare(uint32_t base, uint32_t compareCount)
{
    RECORD(base, compareCount);
    chip.guard_compare = compareCount;
}
void ECAP_setPhaseShiftCount(uint32_t base, uint32_t shiftCount)
{
    RECORD(base, shiftCount);
    chip.guard_loads = chip.guard_loads && (shiftCount == 0U);
}
void ECAP_enableLoadCounter(uint32_t base)
{
    RECORD(base);
    chip.guard_loads = true;
}
void ECAP_loadCounter(uint32_t base)
{
    RECORD(base);
    fake_trips(); /* what was before */
    if (chip.guard_loads) {
        chip.guard_fed_cycles = chip.cycles;
        chip.guard_pulses = 0U;
    }
}

static bool guard_pulses(void)
{
    if (!chip.guard_on || !chip.guard_apwm || !chip.guard_active_low || !chip.guard_routed || !chip.guard_enabled ||
        chip.guard_dead || (chip.guard_period <= chip.guard_compare)) {
        return false;
    }
    const uint64_t age = chip.cycles - chip.guard_fed_cycles;
    const uint64_t pulses = (age + (chip.guard_period - chip.guard_compare)) / chip.guard_period;
    const bool     stands = (age % chip.guard_period) >= chip.guard_compare;
    const bool     any_new = pulses != chip.guard_pulses;
    chip.guard_pulses = pulses;
    return any_new || stands;
}

static fake_cmpss_t *cmpss_of(uint32_t base) { return &chip.cmpss[(base == CMPSS6_BASE) ? 0 : ((base == CMPSS3_BASE) ? 1 : 2)]; }
void                 CMPSS_enableModule(uint32_t base)
{
    RECORD(base);
    cmpss_of(base)->on = true;
}
void CMPSS_setDACValueHigh(uint32_t base, uint16_t value)
{
    RECORD(base, value);
    cmpss_of(base)->high = value;
}
void CMPSS_setDACValueLow(uint32_t base, uint16_t value)
{
    RECORD(base, value);
    cmpss_of(base)->low = value;
}

static bool any_comparator_trips(void)
{
    static const uint32_t MUX[3] = {XBAR_MUX10, XBAR_MUX04, XBAR_MUX00};
    bool                  any = false;
    for (int k = 0; k < 3; k++) {
        const fake_cmpss_t *const c = &chip.cmpss[k];
        const double              code = c->volts / 3.3 * 4096.0; /* VDDA, not the reference of the converter */
        const bool                over = (code > c->high) || ((code < c->low) && !chip.low_comparators_dead);
        any = any || (c->on && c->routed && over && ((chip.epwm_xbar_muxes & MUX[k]) != 0U));
    }
    return any && !chip.comparators_dead;
}

void fake_trips(void)
{
    const bool over = any_comparator_trips();
    const bool nfault = nfault_is_low() && (chip.input_xbar1 == BOARD_PIN_NFAULT);
    const bool late = guard_pulses();
    for (int k = 0; k < 3; k++) {
        fake_epwm_t *const e = &chip.epwm[k];
        const bool         a = e->dc_input[0] && e->dc_condition[0] && e->dc_source[0] && e->dc_direct[0];
        const bool         b = e->dc_input[1] && e->dc_condition[1] && e->dc_source[1] && e->dc_direct[1];
        if (late && b && ((e->tz_signals & EPWM_TZ_SIGNAL_DCBEVT1) != 0U)) {
            e->tz_flags = (uint16_t)(e->tz_flags | EPWM_TZ_FLAG_OST | EPWM_TZ_FLAG_DCBEVT1);
            e->ost_flags = (uint16_t)(e->ost_flags | EPWM_TZ_OST_FLAG_DCBEVT1);
        }
        if (chip.halted && ((e->tz_signals & EPWM_TZ_SIGNAL_OSHT6) != 0U)) {
            e->tz_flags = (uint16_t)(e->tz_flags | EPWM_TZ_FLAG_OST);
            e->ost_flags = (uint16_t)(e->ost_flags | EPWM_TZ_OST_FLAG_OST6);
        }
        if (chip.clock_failed && ((e->tz_signals & EPWM_TZ_SIGNAL_OSHT5) != 0U)) {
            e->tz_flags = (uint16_t)(e->tz_flags | EPWM_TZ_FLAG_OST);
            e->ost_flags = (uint16_t)(e->ost_flags | EPWM_TZ_OST_FLAG_OST5);
        }
        if (over && ((e->tz_signals & EPWM_TZ_SIGNAL_DCAEVT1) != 0U) && a) {
            e->tz_flags = (uint16_t)(e->tz_flags | EPWM_TZ_FLAG_OST | EPWM_TZ_FLAG_DCAEVT1);
            e->ost_flags = (uint16_t)(e->ost_flags | EPWM_TZ_OST_FLAG_DCAEVT1);
        }
        if (nfault && ((e->tz_signals & EPWM_TZ_SIGNAL_OSHT1) != 0U)) {
            e->tz_flags = (uint16_t)(e->tz_flags | EPWM_TZ_FLAG_OST);
            e->ost_flags = (uint16_t)(e->ost_flags | EPWM_TZ_OST_FLAG_OST1);
        }
    }
}

static bool connected(int k)
{
    static const uint32_t GATE[6] = BOARD_PWM_PIN_CONFIGS;
    return (chip.pin_config[2 * k] == GATE[2 * k]) && (chip.pin_config[2 * k + 1] == GATE[2 * k + 1]);
}

bool fake_gate_follows(int k)
{
    return connected(k) && ((chip.epwm[k].tz_flags & EPWM_TZ_FLAG_OST) == 0U) && chip.clocks_run &&
           (chip.latch[BOARD_PIN_EN_GATE] != 0U);
}

bool fake_gate_is_low(int k)
{
    const fake_epwm_t *const e = &chip.epwm[k];
    return !connected(k) || (((e->tz_flags & EPWM_TZ_FLAG_OST) != 0U) && e->action_low[0] && e->action_low[1] &&
                             e->action_low[2] && e->action_low[4]);
}

double fake_duty(int k)
{
    const fake_epwm_t *const e = &chip.epwm[k];
    const double             low = (double)e->compare_active / (double)e->period;
    return (e->rises_on_up && e->falls_on_down) ? (1.0 - low) : low;
}

/* ---- converter ----------------------------------------------------------------------------------------------------------------------------- */

static int adc_of(uint32_t base) { return (int)((base - ADCA_BASE) / 0x80U); }
static int result_of(uint32_t base) { return (int)((base - ADCARESULT_BASE) / 0x20U); }

void ADC_enableConverter(uint32_t base)
{
    RECORD(base);
    chip.adc_on[adc_of(base)] = true;
}
void ADC_setupSOC(uint32_t base, ADC_SOCNumber socNumber, ADC_Trigger trigger, ADC_Channel channel, uint32_t sampleWindow)
{
    RECORD(base, (uint32_t)socNumber, (uint32_t)trigger, (uint32_t)channel, sampleWindow);
    chip.soc_set[adc_of(base)][socNumber] = true;
}
uint16_t ADC_readResult(uint32_t resultBase, ADC_SOCNumber socNumber)
{
    RECORD(resultBase, (uint32_t)socNumber);
    return chip.result[result_of(resultBase)][socNumber];
}
void ADC_clearInterruptStatus(uint32_t base, ADC_IntNumber adcIntNum)
{
    RECORD(base, (uint32_t)adcIntNum);
    chip.adc_flag = false;
}
bool ADC_getInterruptOverflowStatus(uint32_t base, ADC_IntNumber adcIntNum)
{
    RECORD(base, (uint32_t)adcIntNum);
    return chip.adc_overflow;
}
void ADC_clearInterruptOverflowStatus(uint32_t base, ADC_IntNumber adcIntNum)
{
    RECORD(base, (uint32_t)adcIntNum);
    chip.adc_overflow = false;
}

static uint16_t code_of(double volts)
{
    const double code = volts / 3.0 * 4096.0;
    return (code <= 0.0) ? 0U : ((code >= 4095.0) ? 4095U : (uint16_t)code);
}

void fake_pwm_zero(void)
{
    if (!chip.clocks_run) {
        return;
    }
    for (int k = 0; k < 3; k++) {
        chip.epwm[k].compare_active = chip.epwm[k].compare;
    }
    fake_trips();
    if (!chip.soc_enabled || (chip.soc_prescale == 0U)) {
        return;
    }
    for (int a = 0; a < 3; a++) { /* ADC A has phase C, B has B, C has A */
        if (chip.adc_on[a] && chip.soc_set[a][0]) {
            chip.result[a][0] = code_of(chip.cmpss[2 - a].volts);
        }
    }
    if (chip.adc_on[0] && chip.soc_set[0][1]) {
        chip.result[0][1] = code_of(chip.dc_link_pin_v);
        if (chip.adc_flag) {
            chip.adc_overflow = true; /* and no interrupt any more */
        } else {
            chip.adc_flag = true;
            chip.adc_pending = true;
        }
    }
    fake_interrupts();
}

/* ---- encoder ------------------------------------------------------------------------------------------------------------------------------------- */

void EQEP_enableModule(uint32_t base)
{
    RECORD(base);
    chip.qep_on = true;
}
void EQEP_setPosition(uint32_t base, uint32_t position)
{
    RECORD(base, position);
    chip.qep_position = position;
}
uint32_t EQEP_getPosition(uint32_t base)
{
    RECORD(base);
    chip.qep_captured = (uint16_t)((chip.cycles - chip.qep_edge_cycles) / BOARD_CAPTURE_CYC);
    return chip.qep_position;
}
uint16_t EQEP_getCaptureTimerLatch(uint32_t base)
{
    RECORD(base);
    return chip.qep_captured;
}
int16_t EQEP_getDirection(uint32_t base)
{
    RECORD(base);
    return chip.qep_direction;
}
uint32_t EQEP_getIndexPositionLatch(uint32_t base)
{
    RECORD(base);
    return chip.qep_index;
}
uint16_t EQEP_getInterruptStatus(uint32_t base)
{
    RECORD(base);
    return chip.qep_flags;
}
void EQEP_clearInterruptStatus(uint32_t base, uint16_t intFlags)
{
    RECORD(base, intFlags);
    chip.qep_flags = (uint16_t)(chip.qep_flags & ~intFlags);
}

/* ---- gate driver on SPI ------------------------------------------------------------------------------------------------------------------------------ */

static bool driver_listens(void)
{
    const bool awake =
        (chip.latch[BOARD_PIN_WAKE] != 0U) && (chip.latch[BOARD_PIN_EN_GATE] != 0U) && (chip.cycles >= chip.drv_supplied_cycles);
    return awake && ((chip.cycles - chip.en_gate_cycles) >= 200000U) && (chip.latch[BOARD_PIN_CHIP_SELECT] == 0U) &&
           !chip.drv_mute;
}

void SPI_writeDataNonBlocking(uint32_t base, uint16_t data)
{
    RECORD(base, data);
    const uint16_t address = (uint16_t)((data >> 11) & 0xFU);
    chip.spi_answer = 0U;
    chip.spi_full = !chip.spi_hangs;
    if (chip.drv_stuck) {
        chip.spi_answer = 0x7FFU;
        return;
    }
    if (!driver_listens()) {
        return;
    }
    for (int i = 1; i < 5; i++) {
        chip.drv[i] |= chip.drv_cause[i];
    }
    chip.spi_answer = (uint16_t)(chip.drv[address] & 0x7FFU);
    if (chip.drv_garbled > 0) {
        chip.drv_garbled--;
        chip.spi_answer ^= 0x004U;
    }
    if ((data & 0x8000U) == 0U) {
        chip.drv[address] = (uint16_t)(data & 0x7FFU);
        if ((address == 0x9U) && ((data & 2U) != 0U)) {
            chip.drv[9] = (uint16_t)(chip.drv[9] & ~2U);
            for (int i = 1; i < 5; i++) {
                chip.drv[i] = chip.drv_cause[i];
            }
        }
    }
    fake_trips();
}
SPI_RxFIFOLevel SPI_getRxFIFOStatus(uint32_t base)
{
    RECORD(base);
    return (SPI_RxFIFOLevel)(chip.spi_full ? 1 : 0);
}
uint16_t SPI_readDataNonBlocking(uint32_t base)
{
    RECORD(base);
    chip.spi_full = false;
    return chip.spi_answer;
}
void SPI_resetRxFIFO(uint32_t base)
{
    RECORD(base);
    chip.spi_full = false;
}

/* ---- link ------------------------------------------------------------------------------------------------------------------------------------------------ */

SCI_RxFIFOLevel SCI_getRxFIFOStatus(uint32_t base)
{
    RECORD(base);
    return (SCI_RxFIFOLevel)((chip.rx_count < 16U) ? chip.rx_count : 16U);
}
uint16_t SCI_readCharNonBlocking(uint32_t base)
{
    RECORD(base);
    const uint16_t first = chip.rx[0];
    chip.rx_count--;
    (void)memmove(&chip.rx[0], &chip.rx[1], chip.rx_count * sizeof chip.rx[0]);
    return first;
}
SCI_TxFIFOLevel SCI_getTxFIFOStatus(uint32_t base)
{
    RECORD(base);
    return (SCI_TxFIFOLevel)((chip.tx_room < 16U) ? (16 - (int)chip.tx_room) : 0);
}
void SCI_writeCharNonBlocking(uint32_t base, uint16_t data)
{
    RECORD(base, data);
    chip.tx[chip.tx_count++ % FAKE_OCTETS] = data;
    chip.tx_room--;
}
uint16_t SCI_getRxStatus(uint32_t base)
{
    RECORD(base);
    return chip.rx_status;
}
void SCI_performSoftwareReset(uint32_t base)
{
    RECORD(base);
    chip.rx_status = 0U;
}
bool SCI_getOverflowStatus(uint32_t base)
{
    RECORD(base);
    return chip.rx_overflow;
}
void SCI_clearOverflowStatus(uint32_t base)
{
    RECORD(base);
    chip.rx_overflow = false;
}
void SCI_resetRxFIFO(uint32_t base)
{
    RECORD(base);
    chip.rx_count = 0U;
}
