/**
 * @file  tests/hal/fake_driverlib/driverlib.h
 * @brief The part of TI's driverlib for the F2837xD that the port uses, rewritten for the host: names, arguments
 *        and values are those of the library (C2000Ware 26.01), the bodies record and imitate (fake_chip.c).
 *
 * Only what the port uses stands here: a call that is not in this list does not compile, and has to be looked up first.
 * Enumerators that the port does not name are left out.
 */
#ifndef TESTS_HAL_FAKE_DRIVERLIB_DRIVERLIB_H
#define TESTS_HAL_FAKE_DRIVERLIB_DRIVERLIB_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* ---- CPU ---- */

extern volatile uint16_t IER, IFR;

void fake_eint(void);
void fake_dint(void);
void fake_nop(void);

#define EINT fake_eint()
#define DINT fake_dint()
#define ERTM ((void)0)
#define NOP fake_nop()

uint32_t *fake_register(uint32_t address);
#define HWREG(address) (*fake_register(address))

/* ---- values ---- */

#define ADCA_BASE 0x00007400U
#define ADCARESULT_BASE 0x00000B00U
#define ADCB_BASE 0x00007480U
#define ADCBRESULT_BASE 0x00000B20U
#define ADCC_BASE 0x00007500U
#define ADCCRESULT_BASE 0x00000B40U
#define CMPSS_INSRC_DAC 0x0000U
#define CMPSS_INV_INVERTED 0x0002U
#define CMPSS_TRIP_FILTER 0x0008U
#define CMPSS_DACVAL_SYSCLK 0x0000U
#define CMPSS_DACREF_VDDA 0x0000U
#define CMPSS_DACSRC_SHDW 0x0000U
#define CMPSS1_BASE 0x00005C80U
#define CMPSS3_BASE 0x00005CC0U
#define CMPSS6_BASE 0x00005D20U
#define CPUTIMER1_BASE 0x00000C08U
#define CPUSYS_BASE 0x0005D300U
#define ECAP1_BASE 0x00005000U
#define EPWM_DB_INPUT_EPWMA 0U
#define EPWM_TZ_SIGNAL_OSHT1 0x100U
#define EPWM_TZ_SIGNAL_OSHT5 0x1000U
#define EPWM_TZ_SIGNAL_OSHT6 0x2000U
#define EPWM_TZ_SIGNAL_DCAEVT1 0x4000U
#define EPWM_TZ_SIGNAL_DCBEVT1 0x8000U
#define EPWM_TZ_FLAG_OST 0x4U
#define EPWM_TZ_FLAG_DCAEVT1 0x8U
#define EPWM_TZ_FLAG_DCBEVT1 0x20U
#define EPWM_TZ_INTERRUPT 0x1U
#define EPWM_TZ_OST_FLAG_OST1 0x1U
#define EPWM_TZ_OST_FLAG_OST5 0x10U
#define EPWM_TZ_OST_FLAG_OST6 0x20U
#define EPWM_TZ_OST_FLAG_DCAEVT1 0x40U
#define EPWM_TZ_OST_FLAG_DCBEVT1 0x80U
#define EPWM_TZ_FORCE_EVENT_OST 0x4U
#define EPWM1_BASE 0x00004000U
#define EPWM2_BASE 0x00004100U
#define EPWM3_BASE 0x00004200U
#define EQEP_CONFIG_QUADRATURE 0x0000U
#define EQEP_CONFIG_2X_RESOLUTION 0x0000U
#define EQEP_CONFIG_NO_SWAP 0x0000U
#define EQEP_INT_PHASE_ERROR 0x0004U
#define EQEP_INT_INDEX_EVNT_LATCH 0x0400U
#define EQEP_LATCH_CNT_READ_BY_CPU 0x0000U
#define EQEP_LATCH_RISING_INDEX 0x0010U
#define EQEP1_BASE 0x00005100U
#define FLASH0CTRL_BASE 0x0005F800U
#define FLASH0ECC_BASE 0x0005FB00U
#define GPIO_PIN_TYPE_STD 0x0000U
#define GPIO_PIN_TYPE_PULLUP 0x0001U
#define GPIO_0_EPWM1A 0x00060001U
#define GPIO_1_EPWM1B 0x00060201U
#define GPIO_2_EPWM2A 0x00060401U
#define GPIO_3_EPWM2B 0x00060601U
#define GPIO_4_EPWM3A 0x00060801U
#define GPIO_5_EPWM3B 0x00060A01U
#define GPIO_19_GPIO19 0x00080600U
#define GPIO_31_GPIO31 0x00081E00U
#define GPIO_34_GPIO34 0x00460400U
#define GPIO_20_EQEP1A 0x00080801U
#define GPIO_21_EQEP1B 0x00080A01U
#define GPIO_99_EQEP1I 0x00C60605U
#define GPIO_58_SPISIMOA 0x0048140FU
#define GPIO_59_SPISOMIA 0x0048160FU
#define GPIO_60_SPICLKA 0x0048180FU
#define GPIO_61_GPIO61 0x00481A00U
#define GPIO_42_SCITXDA 0x0046140FU
#define GPIO_43_SCIRXDA 0x0046160FU
#define GPIO_67_GPIO67 0x00860600U
#define GPIO_124_GPIO124 0x00C81800U
#define GPIO_125_GPIO125 0x00C81A00U
#define INT_ADCA1 0x00200101U
#define INT_TIMER2 0x000E0000U
#define INTERRUPT_CPU_INT1 0x1U
#define INTERRUPT_CPU_INT14 0x2000U
#define INTERRUPT_ACK_GROUP1 0x1U
#define SCI_CONFIG_WLEN_8 0x0007U
#define SCI_CONFIG_STOP_ONE 0x0000U
#define SCI_RXSTATUS_BREAK 0x0020U
#define SCI_RXSTATUS_ERROR 0x0080U
#define SCIA_BASE 0x00007200U
#define SPIA_BASE 0x00006100U
#define SYSCTL_CAUSE_POR 0x00000001U
#define SYSCTL_CAUSE_XRS 0x00000002U
#define SYSCTL_CAUSE_WDRS 0x00000004U
#define SYSCTL_CAUSE_NMIWDRS 0x00000008U
#define SYSCTL_NMI_CLOCKFAIL 0x2U
#define SYSCTL_NMI_RAMUNCERR 0x4U
#define SYSCTL_NMI_FLUNCERR 0x8U
#define SYSCTL_NMI_PIEVECTERR 0x40U
#define SYSCTL_O_PIEVERRADDR 0xAU
#define SYSCTL_FMULT_NONE 0x00000000UL
#define SYSCTL_OSCSRC_XTAL 0x00010000U
#define SYSCTL_PLL_ENABLE 0x80000000U
#define XBAR_MUX00 0x00000001U
#define XBAR_MUX04 0x00000010U
#define XBAR_MUX10 0x00000400U
#define SYSCTL_IMULT(x) (((x) & 0x7FU) << 0)
#define SYSCTL_SYSDIV(x) ((((x) / 2U) & 0x7FU) << 7)

/* ---- choices ---- */

typedef enum { ADC_CH_ADCIN2 = 2, ADC_CH_ADCIN3 = 3 } ADC_Channel;
typedef enum { ADC_CLK_DIV_4_0 = 6 } ADC_ClkPrescale;
typedef enum { ADC_INT_NUMBER1 = 0 } ADC_IntNumber;
typedef enum { ADC_PULSE_END_OF_CONV = 4 } ADC_PulseMode;
typedef enum { ADC_RESOLUTION_12BIT = 0 } ADC_Resolution;
typedef enum { ADC_SOC_NUMBER0 = 0, ADC_SOC_NUMBER1 = 1 } ADC_SOCNumber;
typedef enum { ADC_MODE_SINGLE_ENDED = 0 } ADC_SignalMode;
typedef enum { ADC_TRIGGER_EPWM1_SOCA = 5 } ADC_Trigger;
typedef enum { CPUTIMER_EMULATIONMODE_RUNFREE = 0x800 } CPUTimer_EmulationMode;
typedef enum { EPWM_SOC_TBCTR_ZERO = 1 } EPWM_ADCStartOfConversionSource;
typedef enum { EPWM_SOC_A = 0 } EPWM_ADCStartOfConversionType;
typedef enum { EPWM_AQ_OUTPUT_LOW = 1, EPWM_AQ_OUTPUT_HIGH = 2 } EPWM_ActionQualifierOutput;
typedef enum { EPWM_AQ_OUTPUT_ON_TIMEBASE_UP_CMPA = 4, EPWM_AQ_OUTPUT_ON_TIMEBASE_DOWN_CMPA = 6 } EPWM_ActionQualifierOutputEvent;
typedef enum { EPWM_AQ_OUTPUT_A = 0 } EPWM_ActionQualifierOutputModule;
typedef enum { EPWM_CLOCK_DIVIDER_1 = 0 } EPWM_ClockDivider;
typedef enum { EPWM_COMP_LOAD_ON_CNTR_ZERO = 0 } EPWM_CounterCompareLoadMode;
typedef enum { EPWM_COUNTER_COMPARE_A = 0 } EPWM_CounterCompareModule;
typedef enum { EPWM_DB_RED = 1, EPWM_DB_FED = 0 } EPWM_DeadBandDelayMode;
typedef enum { EPWM_DB_POLARITY_ACTIVE_HIGH = 0, EPWM_DB_POLARITY_ACTIVE_LOW = 1 } EPWM_DeadBandPolarity;
typedef enum { EPWM_DC_EVENT_1 = 0 } EPWM_DigitalCompareEvent;
typedef enum { EPWM_DC_EVENT_SOURCE_ORIG_SIGNAL = 0 } EPWM_DigitalCompareEventSource;
typedef enum { ECAP_APWM_ACTIVE_HIGH = 0x000, ECAP_APWM_ACTIVE_LOW = 0x400 } ECAP_APWMPolarity;
typedef enum { ECAP_EMULATION_FREE_RUN = 0x2 } ECAP_EmulationMode;
typedef enum { EPWM_DC_MODULE_A = 0, EPWM_DC_MODULE_B = 1 } EPWM_DigitalCompareModule;
typedef enum { EPWM_DC_EVENT_INPUT_NOT_SYNCED = 1 } EPWM_DigitalCompareSyncMode;
typedef enum { EPWM_DC_TRIP_TRIPIN4 = 3, EPWM_DC_TRIP_TRIPIN5 = 4 } EPWM_DigitalCompareTripInput;
typedef enum { EPWM_DC_TYPE_DCAH = 0, EPWM_DC_TYPE_DCBH = 2 } EPWM_DigitalCompareType;
typedef enum { EPWM_EMULATION_FREE_RUN = 2 } EPWM_EmulationMode;
typedef enum { EPWM_HSCLOCK_DIVIDER_1 = 0 } EPWM_HSClockDivider;
typedef enum { EPWM_PERIOD_SHADOW_LOAD = 0 } EPWM_PeriodLoadMode;
typedef enum { EPWM_SYNC_OUT_PULSE_DISABLED = 4 } EPWM_SyncOutPulseMode;
typedef enum { EPWM_COUNTER_MODE_UP_DOWN = 2 } EPWM_TimeBaseCountMode;
typedef enum { EPWM_TZ_ACTION_LOW = 2 } EPWM_TripZoneAction;
typedef enum { EPWM_TZ_DC_OUTPUT_A1 = 0, EPWM_TZ_DC_OUTPUT_B1 = 6 } EPWM_TripZoneDigitalCompareOutput;
typedef enum { EPWM_TZ_EVENT_DCXH_HIGH = 2 } EPWM_TripZoneDigitalCompareOutputEvent;
typedef enum {
    EPWM_TZ_ACTION_EVENT_TZA = 0,
    EPWM_TZ_ACTION_EVENT_TZB = 2,
    EPWM_TZ_ACTION_EVENT_DCAEVT1 = 4,
    EPWM_TZ_ACTION_EVENT_DCBEVT1 = 8
} EPWM_TripZoneEvent;
typedef enum { EQEP_CAPTURE_CLK_DIV_2 = 16 } EQEP_CAPCLKPrescale;
typedef enum { EQEP_EMULATIONMODE_RUNFREE = 2 } EQEP_EmulationMode;
typedef enum { EQEP_POSITION_RESET_MAX_POS = 0x1000 } EQEP_PositionResetMode;
typedef enum { EQEP_UNIT_POS_EVNT_DIV_1 = 0 } EQEP_UPEVNTPrescale;
typedef enum { GPIO_CORE_CPU1 = 0 } GPIO_CoreSelect;
typedef enum { GPIO_PORT_A = 0 } GPIO_Port;
typedef enum { GPIO_DIR_MODE_IN = 0, GPIO_DIR_MODE_OUT = 1 } GPIO_Direction;
typedef enum { GPIO_QUAL_6SAMPLE = 2, GPIO_QUAL_ASYNC = 3 } GPIO_QualificationMode;
typedef enum { SCI_CONFIG_PAR_NONE = 0 } SCI_ParityType;
typedef enum { SCI_FIFO_RX0 = 0, SCI_FIFO_RX16 = 16 } SCI_RxFIFOLevel;
typedef enum { SCI_FIFO_TX16 = 16 } SCI_TxFIFOLevel;
typedef enum { SPI_EMULATION_FREE_RUN = 16 } SPI_EmulationMode;
typedef enum { SPI_MODE_CONTROLLER = 6 } SPI_Mode;
typedef enum { SPI_FIFO_RXEMPTY = 0, SPI_FIFO_RX16 = 16 } SPI_RxFIFOLevel;
typedef enum { SPI_PROT_POL0PHA0 = 0 } SPI_TransferProtocol;
typedef enum { SYSCTL_EPWMCLK_DIV_2 = 1 } SysCtl_EPWMCLKDivider;
typedef enum { SYSCTL_LSPCLK_PRESCALE_4 = 2 } SysCtl_LSPCLKPrescaler;
typedef enum {
    SYSCTL_PERIPH_CLK_TIMER1 = 0x400,
    SYSCTL_PERIPH_CLK_TIMER2 = 0x500,
    SYSCTL_PERIPH_CLK_TBCLKSYNC = 0x1200,
    SYSCTL_PERIPH_CLK_EPWM1 = 2,
    SYSCTL_PERIPH_CLK_EPWM2 = 0x102,
    SYSCTL_PERIPH_CLK_EPWM3 = 0x202,
    SYSCTL_PERIPH_CLK_ECAP1 = 3,
    SYSCTL_PERIPH_CLK_EQEP1 = 4,
    SYSCTL_PERIPH_CLK_SCIA = 7,
    SYSCTL_PERIPH_CLK_SPIA = 8,
    SYSCTL_PERIPH_CLK_ADCA = 13,
    SYSCTL_PERIPH_CLK_ADCB = 0x10d,
    SYSCTL_PERIPH_CLK_ADCC = 0x20d,
    SYSCTL_PERIPH_CLK_CMPSS1 = 14,
    SYSCTL_PERIPH_CLK_CMPSS3 = 0x20e,
    SYSCTL_PERIPH_CLK_CMPSS6 = 0x50e
} SysCtl_PeripheralPCLOCKCR;
typedef enum { SYSCTL_WD_MODE_RESET = 0 } SysCtl_WDMode;
typedef enum { SYSCTL_WD_PRESCALE_4 = 3 } SysCtl_WDPrescaler;
typedef enum {
    XBAR_EPWM_MUX00_CMPSS1_CTRIPH_OR_L = 0x0001,
    XBAR_EPWM_MUX00_ECAP1_OUT = 0x0003,
    XBAR_EPWM_MUX04_CMPSS3_CTRIPH_OR_L = 0x0801,
    XBAR_EPWM_MUX10_CMPSS6_CTRIPH_OR_L = 0x1401
} XBAR_EPWMMuxConfig;
typedef enum { XBAR_INPUT1 = 0 } XBAR_InputNum;
typedef enum { XBAR_TRIP4 = 0, XBAR_TRIP5 = 2 } XBAR_TripNum;

/* ---- System control ---- */

void     SysCtl_disableWatchdog(void);
void     SysCtl_deviceCal(void);
void     SysCtl_enableWatchdog(void);
void     SysCtl_serviceWatchdog(void);
void     SysCtl_setWatchdogMode(SysCtl_WDMode mode);
void     SysCtl_setWatchdogPrescaler(SysCtl_WDPrescaler prescaler);
uint32_t SysCtl_getResetCause(void);
void     SysCtl_clearResetCause(uint32_t rstCauses);
bool     SysCtl_setClock(uint32_t config);
void     SysCtl_setLowSpeedClock(SysCtl_LSPCLKPrescaler prescaler);
void     SysCtl_setEPWMClockDivider(SysCtl_EPWMCLKDivider divider);
void     SysCtl_enablePeripheral(SysCtl_PeripheralPCLOCKCR peripheral);
void     SysCtl_disablePeripheral(SysCtl_PeripheralPCLOCKCR peripheral);
void     SysCtl_delay(uint32_t count);
void     SysCtl_setWatchdogWindowValue(uint16_t value);
void     SysCtl_enableNMIGlobalInterrupt(void);
uint16_t SysCtl_getNMIShadowFlagStatus(void);

/* ---- GPIO ---- */

uint32_t GPIO_readPin(uint32_t pin);
void     GPIO_setControllerCore(uint32_t pin, GPIO_CoreSelect core);
void     GPIO_setDirectionMode(uint32_t pin, GPIO_Direction pinIO);
void     GPIO_setPadConfig(uint32_t pin, uint32_t pinType);
void     GPIO_setPinConfig(uint32_t pinConfig);
void     GPIO_setQualificationMode(uint32_t pin, GPIO_QualificationMode qualification);
void     GPIO_setQualificationPeriod(uint32_t pin, uint32_t divider);
void     GPIO_writePin(uint32_t pin, uint32_t outVal);
void     GPIO_lockPortConfig(GPIO_Port port, uint32_t pinMask);

/* ---- X-BAR ---- */

void XBAR_setInputPin(XBAR_InputNum input, uint16_t pin);
void XBAR_setEPWMMuxConfig(XBAR_TripNum trip, XBAR_EPWMMuxConfig muxConfig);
void XBAR_enableEPWMMux(XBAR_TripNum trip, uint32_t muxes);
void XBAR_lockInput(XBAR_InputNum input);
void XBAR_lockEPWM(void);

/* ---- eCAP ---- */

void ECAP_stopCounter(uint32_t base);
void ECAP_startCounter(uint32_t base);
void ECAP_setEmulationMode(uint32_t base, ECAP_EmulationMode mode);
void ECAP_enableAPWMMode(uint32_t base);
void ECAP_setAPWMPolarity(uint32_t base, ECAP_APWMPolarity polarity);
void ECAP_setAPWMPeriod(uint32_t base, uint32_t periodCount);
void ECAP_setAPWMCompare(uint32_t base, uint32_t compareCount);
void ECAP_setPhaseShiftCount(uint32_t base, uint32_t shiftCount);
void ECAP_enableLoadCounter(uint32_t base);
void ECAP_loadCounter(uint32_t base);

/* ---- ePWM ---- */

void EPWM_setTimeBaseCounter(uint32_t base, uint16_t count);
void EPWM_setClockPrescaler(uint32_t base, EPWM_ClockDivider prescaler, EPWM_HSClockDivider highSpeedPrescaler);
void EPWM_setSyncOutPulseMode(uint32_t base, EPWM_SyncOutPulseMode mode);
void EPWM_setPeriodLoadMode(uint32_t base, EPWM_PeriodLoadMode loadMode);
void EPWM_disablePhaseShiftLoad(uint32_t base);
void EPWM_setTimeBaseCounterMode(uint32_t base, EPWM_TimeBaseCountMode counterMode);
void EPWM_setTimeBasePeriod(uint32_t base, uint16_t periodCount);
void EPWM_setCounterCompareShadowLoadMode(uint32_t base, EPWM_CounterCompareModule compModule,
                                          EPWM_CounterCompareLoadMode loadMode);
void EPWM_setCounterCompareValue(uint32_t base, EPWM_CounterCompareModule compModule, uint16_t compCount);
void EPWM_setActionQualifierAction(uint32_t base, EPWM_ActionQualifierOutputModule epwmOutput, EPWM_ActionQualifierOutput output,
                                   EPWM_ActionQualifierOutputEvent event);
void EPWM_setDeadBandDelayMode(uint32_t base, EPWM_DeadBandDelayMode delayMode, bool enableDelayMode);
void EPWM_setDeadBandDelayPolarity(uint32_t base, EPWM_DeadBandDelayMode delayMode, EPWM_DeadBandPolarity polarity);
void EPWM_setRisingEdgeDeadBandDelayInput(uint32_t base, uint16_t input);
void EPWM_setFallingEdgeDeadBandDelayInput(uint32_t base, uint16_t input);
void EPWM_setRisingEdgeDelayCount(uint32_t base, uint16_t redCount);
void EPWM_setFallingEdgeDelayCount(uint32_t base, uint16_t fedCount);
void EPWM_enableTripZoneSignals(uint32_t base, uint16_t tzSignal);
void EPWM_setTripZoneDigitalCompareEventCondition(uint32_t base, EPWM_TripZoneDigitalCompareOutput dcType,
                                                  EPWM_TripZoneDigitalCompareOutputEvent dcEvent);
void EPWM_setTripZoneAction(uint32_t base, EPWM_TripZoneEvent tzEvent, EPWM_TripZoneAction tzAction);
uint16_t EPWM_getTripZoneFlagStatus(uint32_t base);
uint16_t EPWM_getOneShotTripZoneFlagStatus(uint32_t base);
void     EPWM_clearTripZoneFlag(uint32_t base, uint16_t tzFlags);
void     EPWM_clearOneShotTripZoneFlag(uint32_t base, uint16_t tzOSTFlags);
void     EPWM_forceTripZoneEvent(uint32_t base, uint16_t tzForceEvent);
void EPWM_selectDigitalCompareTripInput(uint32_t base, EPWM_DigitalCompareTripInput tripSource, EPWM_DigitalCompareType dcType);
void EPWM_setDigitalCompareEventSource(uint32_t base, EPWM_DigitalCompareModule dcModule, EPWM_DigitalCompareEvent dcEvent,
                                       EPWM_DigitalCompareEventSource dcEventSource);
void EPWM_setDigitalCompareEventSyncMode(uint32_t base, EPWM_DigitalCompareModule dcModule, EPWM_DigitalCompareEvent dcEvent,
                                         EPWM_DigitalCompareSyncMode syncMode);
void EPWM_enableADCTrigger(uint32_t base, EPWM_ADCStartOfConversionType adcSOCType);
void EPWM_setADCTriggerSource(uint32_t base, EPWM_ADCStartOfConversionType adcSOCType, EPWM_ADCStartOfConversionSource socSource);
void EPWM_setADCTriggerEventPrescale(uint32_t base, EPWM_ADCStartOfConversionType adcSOCType, uint16_t preScaleCount);
void EPWM_setEmulationMode(uint32_t base, EPWM_EmulationMode emulationMode);

/* ---- ADC ---- */

void     ADC_setMode(uint32_t base, ADC_Resolution resolution, ADC_SignalMode signalMode);
void     ADC_setPrescaler(uint32_t base, ADC_ClkPrescale clkPrescale);
void     ADC_setInterruptPulseMode(uint32_t base, ADC_PulseMode pulseMode);
void     ADC_enableConverter(uint32_t base);
void     ADC_setupSOC(uint32_t base, ADC_SOCNumber socNumber, ADC_Trigger trigger, ADC_Channel channel, uint32_t sampleWindow);
uint16_t ADC_readResult(uint32_t resultBase, ADC_SOCNumber socNumber);
void     ADC_setInterruptSource(uint32_t base, ADC_IntNumber adcIntNum, uint16_t intTrigger);
void     ADC_enableInterrupt(uint32_t base, ADC_IntNumber adcIntNum);
void     ADC_clearInterruptStatus(uint32_t base, ADC_IntNumber adcIntNum);
bool     ADC_getInterruptOverflowStatus(uint32_t base, ADC_IntNumber adcIntNum);
void     ADC_clearInterruptOverflowStatus(uint32_t base, ADC_IntNumber adcIntNum);

/* ---- CMPSS ---- */

void CMPSS_enableModule(uint32_t base);
void CMPSS_configHighComparator(uint32_t base, uint16_t config);
void CMPSS_configLowComparator(uint32_t base, uint16_t config);
void CMPSS_configOutputsHigh(uint32_t base, uint16_t config);
void CMPSS_configOutputsLow(uint32_t base, uint16_t config);
void CMPSS_configDAC(uint32_t base, uint16_t config);
void CMPSS_setDACValueHigh(uint32_t base, uint16_t value);
void CMPSS_setDACValueLow(uint32_t base, uint16_t value);
void CMPSS_configFilterHigh(uint32_t base, uint16_t samplePrescale, uint16_t sampleWindow, uint16_t threshold);
void CMPSS_configFilterLow(uint32_t base, uint16_t samplePrescale, uint16_t sampleWindow, uint16_t threshold);
void CMPSS_initFilterHigh(uint32_t base);
void CMPSS_initFilterLow(uint32_t base);
void CMPSS_clearFilterLatchHigh(uint32_t base);
void CMPSS_clearFilterLatchLow(uint32_t base);

/* ---- eQEP ---- */

void     EQEP_enableModule(uint32_t base);
void     EQEP_setDecoderConfig(uint32_t base, uint16_t config);
void     EQEP_setPositionCounterConfig(uint32_t base, EQEP_PositionResetMode mode, uint32_t maxPosition);
uint32_t EQEP_getPosition(uint32_t base);
void     EQEP_setPosition(uint32_t base, uint32_t position);
int16_t  EQEP_getDirection(uint32_t base);
void     EQEP_setLatchMode(uint32_t base, uint32_t latchMode);
uint32_t EQEP_getIndexPositionLatch(uint32_t base);
void     EQEP_setCaptureConfig(uint32_t base, EQEP_CAPCLKPrescale capPrescale, EQEP_UPEVNTPrescale evntPrescale);
void     EQEP_enableCapture(uint32_t base);
uint16_t EQEP_getCaptureTimerLatch(uint32_t base);
uint16_t EQEP_getInterruptStatus(uint32_t base);
void     EQEP_clearInterruptStatus(uint32_t base, uint16_t intFlags);
void     EQEP_setEmulationMode(uint32_t base, EQEP_EmulationMode emuMode);

/* ---- CPU timers ---- */

void     CPUTimer_setPeriod(uint32_t base, uint32_t periodCount);
void     CPUTimer_setPreScaler(uint32_t base, uint16_t prescaler);
void     CPUTimer_reloadTimerCounter(uint32_t base);
void     CPUTimer_stopTimer(uint32_t base);
void     CPUTimer_startTimer(uint32_t base);
uint32_t CPUTimer_getTimerCount(uint32_t base);
void     CPUTimer_setEmulationMode(uint32_t base, CPUTimer_EmulationMode mode);

/* ---- Interrupt / PIE ---- */

void Interrupt_initModule(void);
void Interrupt_initVectorTable(void);
void Interrupt_register(uint32_t interruptNumber, void (*handler)(void));
void Interrupt_enable(uint32_t interruptNumber);
void Interrupt_clearACKGroup(uint16_t group);
bool Interrupt_enableGlobal(void);
bool Interrupt_disableGlobal(void);

/* ---- SCI (UART) ---- */

void            SCI_setConfig(uint32_t base, uint32_t lspclkHz, uint32_t baud, uint32_t config);
void            SCI_enableModule(uint32_t base);
void            SCI_performSoftwareReset(uint32_t base);
void            SCI_resetChannels(uint32_t base);
void            SCI_enableFIFO(uint32_t base);
void            SCI_resetTxFIFO(uint32_t base);
void            SCI_resetRxFIFO(uint32_t base);
SCI_TxFIFOLevel SCI_getTxFIFOStatus(uint32_t base);
SCI_RxFIFOLevel SCI_getRxFIFOStatus(uint32_t base);
void            SCI_writeCharNonBlocking(uint32_t base, uint16_t data);
uint16_t        SCI_readCharNonBlocking(uint32_t base);
uint16_t        SCI_getRxStatus(uint32_t base);
bool            SCI_getOverflowStatus(uint32_t base);
void            SCI_clearOverflowStatus(uint32_t base);

/* ---- SPI ---- */

void            SPI_setConfig(uint32_t base, uint32_t lspclkHz, SPI_TransferProtocol protocol, SPI_Mode mode, uint32_t bitRate,
                              uint16_t dataWidth);
void            SPI_enableModule(uint32_t base);
void            SPI_disableModule(uint32_t base);
void            SPI_enableFIFO(uint32_t base);
void            SPI_resetRxFIFO(uint32_t base);
SPI_RxFIFOLevel SPI_getRxFIFOStatus(uint32_t base);
void            SPI_writeDataNonBlocking(uint32_t base, uint16_t data);
uint16_t        SPI_readDataNonBlocking(uint32_t base);
void            SPI_setEmulationMode(uint32_t base, SPI_EmulationMode mode);

/* ---- Flash ---- */

void     Flash_initModule(uint32_t ctrlBase, uint32_t eccBase, uint16_t waitstates);
void     Flash_setErrorThreshold(uint32_t eccBase, uint16_t threshold);
uint32_t Flash_getErrorCount(uint32_t eccBase);

/* ---- memories ---- */

uint32_t MemCfg_getCorrErrorCount(void);

#define FLASHPUMPSEMAPHORE_BASE 0x00050024U
#define EALLOW fake_eallow()
#define EDIS fake_edis()
typedef enum { FLASH_CPU1_WRAPPER = 0x2, FLASH_CPU2_WRAPPER = 0x1 } Flash_PumpOwnership;

void fake_eallow(void);
void fake_edis(void);
void Flash_claimPumpSemaphore(uint32_t pumpSemBase, Flash_PumpOwnership wrapper);
void Flash_releasePumpSemaphore(uint32_t pumpSemBase);
void Flash_disableECC(uint32_t eccBase);
void Flash_enableECC(uint32_t eccBase);

#endif
