/* Calls that only leave a trace. */
#include "fake_chip.h"

void SysCtl_deviceCal(void) { RECORD_NONE(); }
void SysCtl_setWatchdogMode(SysCtl_WDMode mode) { RECORD((uint32_t)mode); }
void SysCtl_setWatchdogPrescaler(SysCtl_WDPrescaler prescaler) { RECORD((uint32_t)prescaler); }
void SysCtl_clearResetCause(uint32_t rstCauses) { RECORD((uint32_t)rstCauses); }
void SysCtl_setLowSpeedClock(SysCtl_LSPCLKPrescaler prescaler) { RECORD((uint32_t)prescaler); }
void SysCtl_setEPWMClockDivider(SysCtl_EPWMCLKDivider divider) { RECORD((uint32_t)divider); }
void SysCtl_enableNMIGlobalInterrupt(void) { RECORD_NONE(); }
void ECAP_setEmulationMode(uint32_t base, ECAP_EmulationMode mode) { RECORD((uint32_t)base, (uint32_t)mode); }
void Flash_setErrorThreshold(uint32_t eccBase, uint16_t threshold) { RECORD(eccBase, threshold); }
void GPIO_setControllerCore(uint32_t pin, GPIO_CoreSelect core) { RECORD((uint32_t)pin, (uint32_t)core); }
void GPIO_setQualificationMode(uint32_t pin, GPIO_QualificationMode qualification)
{
    RECORD((uint32_t)pin, (uint32_t)qualification);
}
void GPIO_setQualificationPeriod(uint32_t pin, uint32_t divider) { RECORD((uint32_t)pin, (uint32_t)divider); }
void EPWM_setTimeBaseCounter(uint32_t base, uint16_t count) { RECORD((uint32_t)base, (uint32_t)count); }
void EPWM_setClockPrescaler(uint32_t base, EPWM_ClockDivider prescaler, EPWM_HSClockDivider highSpeedPrescaler)
{
    RECORD((uint32_t)base, (uint32_t)prescaler, (uint32_t)highSpeedPrescaler);
}
void EPWM_setSyncOutPulseMode(uint32_t base, EPWM_SyncOutPulseMode mode) { RECORD((uint32_t)base, (uint32_t)mode); }
void EPWM_setPeriodLoadMode(uint32_t base, EPWM_PeriodLoadMode loadMode) { RECORD((uint32_t)base, (uint32_t)loadMode); }
void EPWM_disablePhaseShiftLoad(uint32_t base) { RECORD((uint32_t)base); }
void EPWM_setTimeBaseCounterMode(uint32_t base, EPWM_TimeBaseCountMode counterMode)
{
    RECORD((uint32_t)base, (uint32_t)counterMode);
}
void EPWM_setCounterCompareShadowLoadMode(uint32_t base, EPWM_CounterCompareModule compModule,
                                          EPWM_CounterCompareLoadMode loadMode)
{
    RECORD((uint32_t)base, (uint32_t)compModule, (uint32_t)loadMode);
}
void EPWM_setDeadBandDelayMode(uint32_t base, EPWM_DeadBandDelayMode delayMode, bool enableDelayMode)
{
    RECORD((uint32_t)base, (uint32_t)delayMode, (uint32_t)enableDelayMode);
}
void EPWM_setDeadBandDelayPolarity(uint32_t base, EPWM_DeadBandDelayMode delayMode, EPWM_DeadBandPolarity polarity)
{
    RECORD((uint32_t)base, (uint32_t)delayMode, (uint32_t)polarity);
}
void EPWM_setRisingEdgeDeadBandDelayInput(uint32_t base, uint16_t input) { RECORD((uint32_t)base, (uint32_t)input); }
void EPWM_setFallingEdgeDeadBandDelayInput(uint32_t base, uint16_t input) { RECORD((uint32_t)base, (uint32_t)input); }
void EPWM_setADCTriggerSource(uint32_t base, EPWM_ADCStartOfConversionType adcSOCType, EPWM_ADCStartOfConversionSource socSource)
{
    RECORD((uint32_t)base, (uint32_t)adcSOCType, (uint32_t)socSource);
}
void EPWM_setEmulationMode(uint32_t base, EPWM_EmulationMode emulationMode) { RECORD((uint32_t)base, (uint32_t)emulationMode); }
void ADC_setMode(uint32_t base, ADC_Resolution resolution, ADC_SignalMode signalMode)
{
    RECORD((uint32_t)base, (uint32_t)resolution, (uint32_t)signalMode);
}
void ADC_setPrescaler(uint32_t base, ADC_ClkPrescale clkPrescale) { RECORD((uint32_t)base, (uint32_t)clkPrescale); }
void ADC_setInterruptPulseMode(uint32_t base, ADC_PulseMode pulseMode) { RECORD((uint32_t)base, (uint32_t)pulseMode); }
void ADC_setInterruptSource(uint32_t base, ADC_IntNumber adcIntNum, uint16_t intTrigger)
{
    RECORD((uint32_t)base, (uint32_t)adcIntNum, (uint32_t)intTrigger);
}
void ADC_enableInterrupt(uint32_t base, ADC_IntNumber adcIntNum) { RECORD((uint32_t)base, (uint32_t)adcIntNum); }
void CMPSS_configHighComparator(uint32_t base, uint16_t config) { RECORD((uint32_t)base, (uint32_t)config); }
void CMPSS_configLowComparator(uint32_t base, uint16_t config) { RECORD((uint32_t)base, (uint32_t)config); }
void CMPSS_configOutputsHigh(uint32_t base, uint16_t config) { RECORD((uint32_t)base, (uint32_t)config); }
void CMPSS_configOutputsLow(uint32_t base, uint16_t config) { RECORD((uint32_t)base, (uint32_t)config); }
void CMPSS_configDAC(uint32_t base, uint16_t config) { RECORD((uint32_t)base, (uint32_t)config); }
void CMPSS_configFilterHigh(uint32_t base, uint16_t samplePrescale, uint16_t sampleWindow, uint16_t threshold)
{
    RECORD((uint32_t)base, (uint32_t)samplePrescale, (uint32_t)sampleWindow, (uint32_t)threshold);
}
void CMPSS_configFilterLow(uint32_t base, uint16_t samplePrescale, uint16_t sampleWindow, uint16_t threshold)
{
    RECORD((uint32_t)base, (uint32_t)samplePrescale, (uint32_t)sampleWindow, (uint32_t)threshold);
}
void CMPSS_initFilterHigh(uint32_t base) { RECORD((uint32_t)base); }
void CMPSS_initFilterLow(uint32_t base) { RECORD((uint32_t)base); }
void CMPSS_clearFilterLatchHigh(uint32_t base) { RECORD((uint32_t)base); }
void CMPSS_clearFilterLatchLow(uint32_t base) { RECORD((uint32_t)base); }
void EQEP_setDecoderConfig(uint32_t base, uint16_t config) { RECORD((uint32_t)base, (uint32_t)config); }
void EQEP_setPositionCounterConfig(uint32_t base, EQEP_PositionResetMode mode, uint32_t maxPosition)
{
    RECORD((uint32_t)base, (uint32_t)mode, (uint32_t)maxPosition);
}
void EQEP_setLatchMode(uint32_t base, uint32_t latchMode) { RECORD((uint32_t)base, (uint32_t)latchMode); }
void EQEP_setCaptureConfig(uint32_t base, EQEP_CAPCLKPrescale capPrescale, EQEP_UPEVNTPrescale evntPrescale)
{
    RECORD((uint32_t)base, (uint32_t)capPrescale, (uint32_t)evntPrescale);
}
void EQEP_enableCapture(uint32_t base) { RECORD((uint32_t)base); }
void EQEP_setEmulationMode(uint32_t base, EQEP_EmulationMode emuMode) { RECORD((uint32_t)base, (uint32_t)emuMode); }
void CPUTimer_setPeriod(uint32_t base, uint32_t periodCount) { RECORD((uint32_t)base, (uint32_t)periodCount); }
void CPUTimer_setPreScaler(uint32_t base, uint16_t prescaler) { RECORD((uint32_t)base, (uint32_t)prescaler); }
void CPUTimer_reloadTimerCounter(uint32_t base) { RECORD((uint32_t)base); }
void CPUTimer_stopTimer(uint32_t base) { RECORD((uint32_t)base); }
void CPUTimer_setEmulationMode(uint32_t base, CPUTimer_EmulationMode mode) { RECORD((uint32_t)base, (uint32_t)mode); }
void Interrupt_initModule(void) { RECORD_NONE(); }
void Interrupt_initVectorTable(void) { RECORD_NONE(); }
void SCI_setConfig(uint32_t base, uint32_t lspclkHz, uint32_t baud, uint32_t config)
{
    RECORD((uint32_t)base, (uint32_t)lspclkHz, (uint32_t)baud, (uint32_t)config);
}
void SCI_enableModule(uint32_t base) { RECORD((uint32_t)base); }
void SCI_resetChannels(uint32_t base) { RECORD((uint32_t)base); }
void SCI_enableFIFO(uint32_t base) { RECORD((uint32_t)base); }
void SCI_resetTxFIFO(uint32_t base) { RECORD((uint32_t)base); }
void SPI_setConfig(uint32_t base, uint32_t lspclkHz, SPI_TransferProtocol protocol, SPI_Mode mode, uint32_t bitRate,
                   uint16_t dataWidth)
{
    RECORD((uint32_t)base, (uint32_t)lspclkHz, (uint32_t)protocol, (uint32_t)mode, (uint32_t)bitRate, (uint32_t)dataWidth);
}
void SPI_enableModule(uint32_t base) { RECORD((uint32_t)base); }
void SPI_disableModule(uint32_t base) { RECORD((uint32_t)base); }
void SPI_enableFIFO(uint32_t base) { RECORD((uint32_t)base); }
void SPI_setEmulationMode(uint32_t base, SPI_EmulationMode mode) { RECORD((uint32_t)base, (uint32_t)mode); }
void Flash_initModule(uint32_t ctrlBase, uint32_t eccBase, uint16_t waitstates)
{
    RECORD((uint32_t)ctrlBase, (uint32_t)eccBase, (uint32_t)waitstates);
}
