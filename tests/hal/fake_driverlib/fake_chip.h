/**
 * @file  tests/hal/fake_driverlib/fake_chip.h
 * @brief The chip behind the fake of driverlib: what was called, in which order, and as much behaviour as the port needs.
 *
 * Imitated: one-shot trip with its level-sensitive sources, converter interrupt with overflow, eQEP with its capture timer,
 * the gate driver on SPI, serial FIFOs, CPU timer, INTM, IER, IFR and the acknowledge of PIE group 1. Not imitated: time
 * inside an interrupt, the dead band, anything analog.
 */
#ifndef TESTS_HAL_FAKE_DRIVERLIB_FAKE_CHIP_H
#define TESTS_HAL_FAKE_DRIVERLIB_FAKE_CHIP_H

#include <setjmp.h>

#include "driverlib.h"

#define FAKE_ARGUMENTS 6
#define FAKE_PINS 169
#define FAKE_VECTORS 224
#define FAKE_OCTETS 64

typedef struct {
    uint16_t period, compare, compare_active;
    uint16_t red, fed;
    uint16_t tz_flags, ost_flags, tz_signals;
    bool     action_low[5]; /* on a trip, outputs A and B; on the digital compare events, outputs A and B (3 is not used) */
    bool     dc_input[2], dc_condition[2], dc_source[2], dc_direct[2]; /* of modules A and B */
    bool     rises_on_up, falls_on_down;
} fake_epwm_t;

typedef struct {
    bool     on, routed;
    uint16_t high, low;
    double   volts; /* at its pin, of the shunt amplifier */
} fake_cmpss_t;

typedef struct {
    /* clock and CPU */
    uint64_t cycles;
    bool     pll_locks;
    bool     intm; /* interrupts masked */
    bool     pie_ack_group1, adc_pending, adc_flag, adc_overflow;
    uint16_t deepest, depth; /* of nested interrupts */
    void (*vector[FAKE_VECTORS])(void);
    void (*on_eint)(void);        /* called once, inside the next EINT */
    jmp_buf     escape;           /* where NOP jumps to... */
    bool        escape_set;       /* ...if it does: the way out of an endless loop */
    const char *interrupted_call; /* in this call, once, ... */
    int         calls_before;     /* ...after so many of them, ... */
    void (*interrupt)(void);      /* ...this happens before it has its effect */
    uint64_t timer_start;
    uint64_t interrupt_cycles; /* that pass after every look of an interrupt at the cycle counter */
    void (*on_clock)(void);    /* called when the main loop reads the cycle counter: the world goes on */

    /* pins */
    uint32_t pin_config[FAKE_PINS];
    uint32_t latch[FAKE_PINS];
    bool     is_output[FAKE_PINS];
    bool     pulled_up[FAKE_PINS];
    int      unsafe_connections; /* gate pins connected while their module was not tripped, or would float on a trip */

    /* bridge */
    fake_epwm_t  epwm[3];
    fake_cmpss_t cmpss[3];        /* of phases A, B, C */
    uint32_t     epwm_xbar_muxes; /* of trip 4 */
    uint16_t     input_xbar1;
    bool         clocks_run, soc_enabled;
    bool         comparators_dead; /* a broken trip path */
    bool         trip_zone_dead;   /* forcing a trip has no effect */
    bool         nfault_stuck;     /* low without a reason in the status */
    bool         low_comparators_dead;
    bool         xbar_locked, input_locked;
    uint32_t     port_a_locked;
    int          locked_writes; /* to what is locked */

    /* the guard: eCAP1 in its PWM mode, on trip 5 */
    bool     guard_on, guard_apwm, guard_active_low, guard_loads, guard_routed, guard_enabled;
    bool     guard_dead; /* it never pulses */
    uint32_t guard_period, guard_compare;
    uint64_t guard_fed_cycles, guard_pulses;

    /* the processor */
    bool     halted, clock_failed; /* levels of TZ6 and TZ5 */
    uint16_t nmi_shadow;
    uint32_t pie_error_address;
    uint32_t ram_errors, flash_errors;
    uint16_t soc_prescale;

    /* converter: input voltages and results */
    double   dc_link_pin_v;
    bool     adc_on[3]; /* A, B, C */
    bool     soc_set[3][2];
    uint16_t result[3][2];

    /* encoder */
    uint32_t qep_position, qep_max;
    int16_t  qep_direction;
    uint64_t qep_edge_cycles;
    uint16_t qep_captured, qep_flags;
    uint32_t qep_index;
    bool     qep_on;

    /* gate driver */
    uint16_t drv[16];             /* registers */
    uint16_t drv_cause[5];        /* standing causes, by status register */
    bool     drv_mute;            /* nothing on SOMI */
    bool     drv_stuck;           /* SOMI stuck high */
    int      drv_garbled;         /* so many answers to come have a wrong bit */
    uint64_t drv_supplied_cycles; /* its motor supply comes at this time */
    bool     spi_hangs;           /* the SPI never finishes */
    uint64_t en_gate_cycles;
    uint16_t spi_answer;
    bool     spi_full;

    /* link and watchdog */
    uint16_t rx[FAKE_OCTETS], tx[FAKE_OCTETS];
    uint16_t rx_count, tx_count, tx_room;
    uint16_t rx_status;
    bool     rx_overflow;
    bool     watchdog_on;
    uint32_t watchdog_served;
    uint16_t watchdog_window;   /* steps of 40960 cycles */
    uint64_t watchdog_cycles;   /* when it was served last */
    int      watchdog_too_soon; /* it would have reset the chip */
    uint32_t reset_cause;       /* bits of the register; 1 after fake_chip_reset */
} fake_chip_t;

extern fake_chip_t chip;

/** Power on: healthy parts, nothing configured, no calls recorded. */
void fake_power_on(void);
/** Bridge: true when phase @p k follows its duty. */
bool fake_gate_follows(int k);
/** Both outputs of phase @p k are driven low, or the pins are still inputs that the driver pulls down. */
bool fake_gate_is_low(int k);
/** On-time share of phase @p k as its registers make it. */
double fake_duty(int k);
/** Look at the trip sources again after a change of the outside. */
void fake_trips(void);
/** The debugger halts the processor for so many cycles, and lets it go on. */
void fake_halt(uint64_t cycles);
/** One PWM zero: load the duties, convert if everything is set up, run the interrupts. */
void fake_pwm_zero(void);
/** Run what is pending and not masked. */
void fake_interrupts(void);

/* ---- what was called ---- */

void fake_forget_calls(void);
int  fake_call_count(void);
/** First call from number @p from on whose name and first @p count arguments agree, or -1. */
int         fake_find(int from, const char *name, int count, const uint32_t *arguments);
int         fake_count(const char *name, int count, const uint32_t *arguments);
const char *fake_call_name(int number);

#define FAKE_ARGS_(...) ((int)(sizeof((const uint32_t[]){__VA_ARGS__}) / sizeof(uint32_t))), ((const uint32_t[]){__VA_ARGS__})
#define CALLED(name, ...) fake_find(0, name, FAKE_ARGS_(__VA_ARGS__))
#define CALLED_AFTER(from, name, ...) fake_find((from), name, FAKE_ARGS_(__VA_ARGS__))
#define TIMES_CALLED(name, ...) fake_count(name, FAKE_ARGS_(__VA_ARGS__))
#define CALLED_AT_ALL(name) fake_find(0, name, 0, NULL)

/* for the bodies */
void fake_record(const char *name, int count, const uint32_t *arguments);
#define RECORD(...) fake_record(__func__, FAKE_ARGS_(__VA_ARGS__))
#define RECORD_NONE() fake_record(__func__, 0, NULL)

#endif
