/**
 * @file  hal/f28379d/parts.h
 * @brief What the files of the port share among themselves, in the order in which port_init calls it.
 */
#ifndef HAL_F28379D_PARTS_H
#define HAL_F28379D_PARTS_H

#include "hal/f28379d/board.h"
#include "hal/f28379d/port.h"
#include "hal/hal_inverter.h"

/* system.c */
bool port_system_init(void);

/* stack.c */
void port_stack_start(void);                                            /* fill what is above the caller's frame */
void port_stack_watch(uint16_t *from, uint16_t count, uint16_t in_use); /* any words, the first of them in use */
void port_stack_check(void);                                            /* some words a pass */

/* assertion.c: the first argument that driverlib has refused, in a debug build */
typedef struct {
    const char *file;
    uint32_t    line;
    uint16_t    count;
} port_assertion_t;
extern port_assertion_t port_assertion;
void                    port_assertion_failed(const char *file, uint32_t line);
void                    __error__(const char *filename, uint32_t line);

/* pins.c: everything but the six gates; gates last, when the trip is armed */
void port_pins_init(void);
void port_pins_connect_gates(void);

/* clock.c */
void port_clock_init(void);

/* pwm.c */
void port_pwm_init(void);    /* counters stand */
void port_pwm_start(void);   /* all three at once */
void port_pwm_sampled(void); /* from now on the duties set next count */

/* trip.c */
void port_trip_init(void);      /* ends with the one-shot trip set */
bool port_trip_is_set(void);    /* on all three modules */
bool port_trip_self_test(void); /* every comparator, both signs, and the guard trip each module; leaves the trip set */
void port_trip_give_up(void);   /* never arm */
bool port_trip_is_given_up(void);
void port_trip_release_if_armed(void);
void port_trip_poll(void); /* note what the hardware has found */
void port_trip_note(hal_inverter_fault_t fault);
bool port_trip_bridge_is_off(void);

/* sampling.c, encoder.c */
void port_sampling_init(void);
bool port_sampling_zero_is_off(void); /* the zero errors add up to more than three working amplifiers can have */
bool port_sampling_sum_is_off(void);  /* what the currents add up to, beyond that */
void port_sampling_forget_sum(void);
void port_sampling_take(void);
void port_sampling_resume(void);
void port_encoder_init(void);
void port_encoder_latch(void);

/* gate_driver.c */
bool                 port_driver_init(void);
bool                 port_driver_is_well(hal_inverter_fault_t *reason); /* reads all registers: about 200 us */
bool                 port_driver_set_up(void); /* writes all settings, clears the faults, reads all back: about 400 us */
void                 port_driver_poll(void);
void                 port_driver_ask_why(void); /* once after nFAULT has tripped the bridge */
hal_inverter_fault_t port_driver_reason(const port_driver_status_t *status);

/* link.c */
void port_link_init(void);
void port_link_pump(void); /* current interrupt: octets between the FIFOs and the main loop */

/* interrupts.c */
void port_interrupts_init(void);

/* guard.c */
void port_guard_init(void); /* it runs from now on, and pulses while nobody feeds it */

/* health.c */
void                 port_health_init(void);
void                 port_health_check(void);
hal_inverter_fault_t port_health_of_last_run(void); /* what made the processor reset itself */
void                 port_lock_registers(void);

/* self_test.c: in a program for flash; self_test.h says why not in one for RAM */
#if defined(_FLASH) || !defined(__TMS320C28XX__)
#define PORT_SELF_TEST 1
void port_self_test_start(
    void); /* all of it: about 60 ms by the counted cycles; before anything is kept in the memory of drive and capture */
void                 port_self_test_slice(void); /* in every pass: about 2600 cycles at most */
hal_inverter_fault_t port_self_test_found(void); /* the first that has failed, until the next reset */
uint32_t             port_self_test_address(void);
#else
#define PORT_SELF_TEST 0
static inline void                 port_self_test_start(void) {}
static inline void                 port_self_test_slice(void) {}
static inline hal_inverter_fault_t port_self_test_found(void) { return HAL_INVERTER_FINE; }
static inline uint32_t             port_self_test_address(void) { return 0U; }
#endif

/* led.c */
void port_led_init(void);
void port_led_show(uint16_t code, bool on); /* main loop, every pass */

/* watchdog.c: proofs of life */
void port_watchdog_start(void);
void port_watchdog_service(void);
void port_watchdog_serve(void); /* unasked; not within its window after the last time */

/* ---- between the files, read by an interrupt: a call would cost more than what it does -------------------------------- */

/* trip.c: reasons for which a module has tripped by itself. Those of the processor count only while the bridge is armed. */
#define PORT_TRIP_PROCESSOR_FLAGS (EPWM_TZ_OST_FLAG_OST5 | EPWM_TZ_OST_FLAG_OST6 | EPWM_TZ_OST_FLAG_DCBEVT1)
#define PORT_TRIP_HARDWARE_FLAGS (EPWM_TZ_OST_FLAG_OST1 | EPWM_TZ_OST_FLAG_DCAEVT1 | PORT_TRIP_PROCESSOR_FLAGS)
extern volatile bool                 port_trip_armed; /* from hal_inverter_arm to hal_inverter_disarm */
extern volatile hal_inverter_fault_t port_trip_latched;
static inline uint16_t               port_trip_flags(void)
{
    return (EPWM_getOneShotTripZoneFlagStatus(EPWM1_BASE) | EPWM_getOneShotTripZoneFlagStatus(EPWM2_BASE) |
            EPWM_getOneShotTripZoneFlagStatus(EPWM3_BASE)) &
           PORT_TRIP_HARDWARE_FLAGS;
}

/* guard.c: restart the counter */
static inline void port_guard_feed(void) { ECAP_loadCounter(BOARD_GUARD_BASE); }

/* sampling.c, encoder.c: counted for port_health */
extern volatile uint32_t port_sampling_lost, port_encoder_errors;

/* pwm.c: compare values, small for a long pulse, in force before the newest sample, and that came into force at it */
typedef struct {
    uint16_t compare[BOARD_PHASES];
    uint16_t longest; /* the smallest of them */
} port_pulses_t;
extern port_pulses_t port_pwm_before, port_pwm_after;

/* One instruction each; see control/numeric/fpu.h. */
#ifdef __TMS320C28XX_FPU32__
static inline float port_min(float a, float b) { return __fmin(a, b); }
static inline float port_max(float a, float b) { return __fmax(a, b); }
#elif defined(EVENSPIN_TMU_MARKED)
float port_min(float a, float b);
float port_max(float a, float b);
#else
static inline float port_min(float a, float b) { return (a < b) ? a : b; }
static inline float port_max(float a, float b) { return (a > b) ? a : b; }
#endif

/* encoder.c: as latched */
typedef struct {
    uint32_t position; /* [0, counts) */
    uint32_t at_cyc;
    bool     failed;
} port_encoder_t;
extern port_encoder_t port_encoder;

/* watchdog.c: proofs of life */
typedef struct {
    volatile uint16_t current_runs, speed_wishes, speed_runs;
} port_life_t;
extern port_life_t port_life;

#endif
