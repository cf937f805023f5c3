/**
 * @file  hal/f28379d/board.h
 * @brief LAUNCHXL-F28379D with BOOSTXL-DRV8305EVM on site 1: every pin, scale and time of the port, in one place.
 *
 * How sure a number is:
 *   [sheet]    data sheet, user guide or SDK of the part
 *   [derived]  follows from other lines here
 *   [bench]    measured by a public project on this pair of boards (foc-f28379d-fsae, 2026)
 *   [check]    believed, not proven: docs/bring-up.md says where to measure it
 */
#ifndef HAL_F28379D_BOARD_H
#define HAL_F28379D_BOARD_H

#include "driverlib.h"

/* ---- clocks ------------------------------------------------------------------------------------------------------------ */

#define BOARD_SYSCLK_HZ UINT32_C(200000000) /* [sheet] crystal 10 MHz x 40 / 2 */
#define BOARD_CLOCK_CONFIG (SYSCTL_OSCSRC_XTAL | SYSCTL_IMULT(40) | SYSCTL_FMULT_NONE | SYSCTL_SYSDIV(2) | SYSCTL_PLL_ENABLE)
#define BOARD_LSPCLK_HZ UINT32_C(50000000)              /* [sheet] SYSCLK / 4: SCI and SPI */
#define BOARD_FLASH_WAITS 3U                            /* [sheet] up to 200 MHz */
#define BOARD_US(n) ((((n) * UINT32_C(200)) + 4U) / 5U) /* SysCtl_delay counts for n us: 5 cycles each [sheet] */

/* ---- bridge: ePWM1, 2, 3 = phases A, B, C --------------------------------------------------------------------------------- */

#define BOARD_PHASES 3U
#define BOARD_EPWM_BASES {EPWM1_BASE, EPWM2_BASE, EPWM3_BASE}
#define BOARD_PWM_HZ 10000U
#define BOARD_PWM_COUNTS 5000U     /* [derived] EPWMCLK 100 MHz / (2 x 10 kHz), up-down */
#define BOARD_DEAD_BAND_COUNTS 50U /* 500 ns at 10 ns; the driver adds 52 ns of its own [sheet] */

/* Pulses are centred on the period event, so all low sides conduct around zero: there the currents are sampled and the
 * next duties loaded. One sample, one whole period to calculate, one load: the delay that the simulator has. */
#define BOARD_DUTY_MAX 0.97f          /* low side on for 3 us - 0.5 us: the shunts are read in every period [derived] */
#define BOARD_DUTY_MEASURABLE 0.94f   /* above it a shunt has less than 2.5 us to settle before the sample [check] */
#define BOARD_COMPARE_MEASURABLE 300U /* [derived] that duty as a compare value */

/* Pins of the bridge stay inputs, pulled down in the driver, until the trip is armed. */
#define BOARD_PIN_PWM_FIRST 0U /* GPIO0..5: HA LA HB LB HC LC */
#define BOARD_PIN_PWM_LAST 5U
#define BOARD_PWM_PIN_CONFIGS {GPIO_0_EPWM1A, GPIO_1_EPWM1B, GPIO_2_EPWM2A, GPIO_3_EPWM2B, GPIO_4_EPWM3A, GPIO_5_EPWM3B}

/* ---- currents and dc link --------------------------------------------------------------------------------------------------- */

#define BOARD_ADC_REFERENCE_V 3.0f /* VREFHI of this LaunchPad; 3.3 V is VDDA, which the comparators use [bench] */
#define BOARD_COMPARATOR_REFERENCE_V 3.3f
#define BOARD_CODES 4096.0f
#define BOARD_SHUNT_OHM 0.007f                                      /* low side, one per phase [sheet] */
#define BOARD_SHUNT_GAIN 10.0f                                      /* amplifier in the DRV8305, register 0xA = 0 [sheet] */
#define BOARD_SHUNT_ZERO_V 1.65f                                    /* output without current [sheet]; 1.68 V seen [bench] */
#define BOARD_CURRENT_SIGN 1.0f                                     /* positive into the motor [bench, one board] */
#define BOARD_A_PER_V (1.0f / (BOARD_SHUNT_OHM * BOARD_SHUNT_GAIN)) /* 14.286 [derived] */
#define BOARD_A_PER_CODE (BOARD_ADC_REFERENCE_V / BOARD_CODES * BOARD_A_PER_V)             /* 10.46 mA [derived] */
#define BOARD_CURRENT_ZERO_CODE (BOARD_SHUNT_ZERO_V / BOARD_ADC_REFERENCE_V * BOARD_CODES) /* 2252.8, not 2048 [derived] */
#define BOARD_OFFSET_LIMIT_A 1.1f  /* 100 codes of zero error: more is a dead amplifier; default and maximum */
#define BOARD_DC_LINK_RATIO 13.42f /* divider, 13.13 measured on one board [check]; its pole lies at 345 Hz */
#define BOARD_V_PER_CODE (BOARD_ADC_REFERENCE_V / BOARD_CODES * BOARD_DC_LINK_RATIO) /* 9.83 mV; 40.3 V full scale */
/* Default and maximum. The driver warns of over-voltage, and thereby trips the bridge, from 32.5 to 36 V on [check]; at 40 V its
 * start-up check failed, below 35 V it passed [bench]. The board itself takes 45 V, the converter reads 40 V. */
#define BOARD_OVER_VOLTAGE_V 32.0f
/* Above it an open bridge works as a rectifier and charges a link of 24 V from the motor: sqrt(3) x 4 x 6.4 mWb per rad/s [derived] */
#define BOARD_OVER_SPEED_RAD_S 540.0f
/* The mean of |ia + ib + ic| over about 64 samples: what three gains off by 2 % leave at 18 A is 0.4 A; an amplifier that is
 * dead at 1.8 A is beyond it [derived] */
#define BOARD_SUM_LIMIT_A 1.0f
#define BOARD_OVER_CURRENT_A                                                                                                     \
    15.0f /* software limit, the default; its maximum is BOARD_TRIP_A. The converter clips at -23.6 and
                                       +19.3 A [derived] */

/* Phase A ADCINC2 = CMPSS6, B ADCINB2 = CMPSS3, C ADCINA2 = CMPSS1 [sheet]; dc link ADCINA3. */
#define BOARD_ADC_BASES {ADCA_BASE, ADCB_BASE, ADCC_BASE}
#define BOARD_RESULT_A ADCCRESULT_BASE
#define BOARD_RESULT_B ADCBRESULT_BASE
#define BOARD_RESULT_C ADCARESULT_BASE
#define BOARD_CHANNEL_CURRENT ADC_CH_ADCIN2
#define BOARD_CHANNEL_DC_LINK ADC_CH_ADCIN3 /* on ADCA, after its current */
#define BOARD_SAMPLE_WINDOW 30U             /* SYSCLK: 150 ns behind an RC filter; the minimum is 15 [sheet] */

/* ---- over-current comparators ------------------------------------------------------------------------------------------------- */

#define BOARD_CMPSS_BASES {CMPSS6_BASE, CMPSS3_BASE, CMPSS1_BASE} /* A, B, C */
#define BOARD_CMPSS_MUX_CONFIGS                                                                                                  \
    {XBAR_EPWM_MUX10_CMPSS6_CTRIPH_OR_L, XBAR_EPWM_MUX04_CMPSS3_CTRIPH_OR_L, XBAR_EPWM_MUX00_CMPSS1_CTRIPH_OR_L}
#define BOARD_CMPSS_MUXES (XBAR_MUX10 | XBAR_MUX04 | XBAR_MUX00)
#define BOARD_TRIP_A 18.0f /* below where the converter clips, below 20 A, the peak rating of the board */
#define BOARD_TRIP_CODE(amps)                                                                                                    \
    ((uint16_t)(((BOARD_SHUNT_ZERO_V + ((amps) / BOARD_A_PER_V)) / BOARD_COMPARATOR_REFERENCE_V * BOARD_CODES) + 0.5f))
/* 16 of 20 samples, one every 10 SYSCLK: 0.8 us of over-current; shorter is ringing after an edge. */
#define BOARD_TRIP_FILTER_PRESCALE 9U
#define BOARD_TRIP_FILTER_WINDOW 20U
#define BOARD_TRIP_FILTER_THRESHOLD 16U
#define BOARD_TRIP_TEST_US 5U /* the self test waits so long for the filter and the X-BAR */

/* ---- hardware switches the bridge off when the processor does not serve it ------------------------------------------------------- */

/* eCAP1 as a PWM that never gets to its pulse while every current interrupt restarts it: two PWM periods, and a tenth of one
 * for the latency of an interrupt. Then the pulse of 5 us sets the one-shot of all modules. */
#define BOARD_GUARD_BASE ECAP1_BASE
#define BOARD_GUARD_CYC UINT32_C(42000)
#define BOARD_GUARD_PULSE_CYC UINT32_C(1000)
#define BOARD_PERIOD_CYC UINT32_C(20000)

/* A halt by the debugger trips as well: the last voltage would else stay on the motor for as long as somebody reads a
 * breakpoint. 0 for the one step of docs/bring-up.md that needs a halted processor with gates on, without a motor. */
#ifndef BOARD_TRIP_ON_HALT
#define BOARD_TRIP_ON_HALT 1
#endif

/* ---- gate driver --------------------------------------------------------------------------------------------------------------------- */

#define BOARD_PIN_NFAULT 19U /* open drain, low = fault */
#define BOARD_PIN_EN_GATE 124U
#define BOARD_PIN_WAKE 125U
#define BOARD_PIN_CHIP_SELECT 61U
#define BOARD_SPI_BASE SPIA_BASE
#define BOARD_SPI_HZ UINT32_C(1000000)
#define BOARD_SPI_POLLS 2000U /* far more than the 16 us of a frame */
#define BOARD_DRIVER_SLEEP_US UINT32_C(2000)
#define BOARD_DRIVER_WAKE_US UINT32_C(2000)    /* between two tries; SPI answers 5 to 10 ms after the motor supply [check] */
#define BOARD_DRIVER_TRIES 50U                 /* 100 ms, which TI's own software waits for this board [bench] */
#define BOARD_DRIVER_POLL_CYC UINT32_C(400000) /* one register every 2 ms: all of them in 22 ms */
/* 0x400 on a DRV8305xE, whose over-temperature shutdown is off else; on a DRV8305xQ the same bit switches it off [sheet]. Read the
 * marking [check]. On both the over-temperature warning, which comes first, pulls nFAULT and trips the bridge. */
#define BOARD_DRIVER_FLIP_OTSD UINT16_C(0x000)

/* ---- encoder: eQEP1 on J14 -------------------------------------------------------------------------------------------------------------- */

#define BOARD_EQEP_BASE EQEP1_BASE
#define BOARD_PIN_QEP_A 20U
#define BOARD_PIN_QEP_B 21U
#define BOARD_PIN_QEP_I 99U
#define BOARD_ENCODER_COUNTS UINT32_C(4000)     /* 1000 lines, every edge */
#define BOARD_ANGLE_PER_COUNT UINT32_C(1073741) /* [derived] 2^32 / counts, whole part */
#define BOARD_ANGLE_REST_16 UINT32_C(54002)     /* [derived] fraction of 2^32 / counts, 2^-16 */
#define BOARD_QEP_FILTER_SYSCLK 20U /* 6 equal samples 100 ns apart: edges closer than 0.6 us are noise; 390 r/s at 4000 counts */
/* Phase errors: one may be a glitch, and at most one count is off then, which encoder_jump_rad judges. Several within this time
 * mean that the angle cannot be trusted. */
#define BOARD_PHASE_ERRORS 4U
#define BOARD_PHASE_ERROR_CYC UINT32_C(20000000) /* 100 ms */
#define BOARD_EDGES_HZ 1.5e6f                    /* [derived] counts per second that pass that filter, with a tenth to spare */
#define BOARD_CAPTURE_CYC UINT32_C(2)            /* SYSCLK per step of the edge timer: wraps after 131 070 cycles, 6 periods */
#define BOARD_CAPTURE_DIVIDER EQEP_CAPTURE_CLK_DIV_2

/* ---- link and probe ------------------------------------------------------------------------------------------------------------------------ */

#define BOARD_SCI_BASE SCIA_BASE /* virtual COM port of the probe */
#define BOARD_PIN_SCI_TX 42U
#define BOARD_PIN_SCI_RX 43U
#define BOARD_LINK_BAUD                                                                                                          \
    UINT32_C(625000) /* divider 9, exact; so are 250000 and 781250, not 460800 and 921600. The probe divides
                                            12 MHz by 19.25: -0.26 % [sheet] */
#define BOARD_LINK_FIFO 16U
#define BOARD_PIN_PROBE 67U /* high while the current interrupt runs */

/* ---- watchdog --------------------------------------------------------------------------------------------------------------------------------- */

#define BOARD_WATCHDOG_PRESCALE SYSCTL_WD_PRESCALE_4 /* 10 MHz / 512 / 4 / 256: resets after 52 ms */
#define BOARD_WATCHDOG_WINDOW 20U                    /* steps of 0.2 ms: whoever serves it within 4.1 ms resets, too */
#define BOARD_WATCHDOG_SERVE_CYC UINT32_C(2000000)   /* 10 ms: far from both ends, whatever the 10 MHz really are */

/* ---- light-emitting diodes of the LaunchPad, low = on ---------------------------------------------------------------------------- */

#define BOARD_PIN_LED_RED 34U  /* flashes the code of what is wrong: port_led_show */
#define BOARD_PIN_LED_BLUE 31U /* on while the gates may follow the duties */

/* Functions that interrupts run and tables that they read: in RAM, without wait states. */
#ifdef __TMS320C28XX__
#define BOARD_RAM_CODE __attribute__((ramfunc))
#define BOARD_RAM_TABLE /* not const: .const lies in flash, .data in RAM */
#else
#define BOARD_RAM_CODE
#define BOARD_RAM_TABLE const
#endif

#endif
