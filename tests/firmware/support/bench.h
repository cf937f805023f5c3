/**
 * @file  tests/firmware/support/bench.h
 * @brief A drive on a board of CMock stubs: what the board shows, what the drive did to it, and in which order.
 *
 * bench_start() connects the stubs; the fields of `bench` are then the board. A test file includes the mock headers
 * itself, so that its runner initialises and verifies them.
 */
#ifndef TESTS_FIRMWARE_SUPPORT_BENCH_H
#define TESTS_FIRMWARE_SUPPORT_BENCH_H

#include "firmware/app/drive.h"
#include "hal/hal_inverter.h"
#include "hal/hal_limits.h"
#include "hal/hal_sample.h"
#include "tests/support/numeric.h"

#define BENCH_CPU_HZ 200000000U
#define BENCH_PERIOD_CYC 20000U /* 200 MHz / 10 kHz */
#define BENCH_VDC 24.0
#define BENCH_LOG 32
#define BENCH_ALIGN_PERIODS 9000U /* the shortest that there is */
#define BENCH_WAIT_PERIODS 1000U  /* before it: 0.1 s in which the shaft rests */

#define PI_OF_CIRCLE 3.14159265358979323846
#define SQRT3 1.7320508075688772935

typedef enum { CALL_READ = 1, CALL_EDGE, CALL_DUTY, CALL_ARM, CALL_DISARM, CALL_CLEAR, CALL_REQUEST_SPEED } bench_call_t;

typedef struct {
    /* what the board shows */
    hal_sample_t         sample;
    hal_status_t         sample_status;
    hal_encoder_edge_t   edge;
    hal_status_t         edge_status;
    hal_status_t         arm_status;
    hal_inverter_fault_t inverter_fault;
    uint16_t             sto; /* channels that ask for safe torque off; each is a fault of the inverter, too */
    float                celsius[HAL_TEMPERATURES];        /* what its temperature sensors show, */
    hal_status_t         celsius_status[HAL_TEMPERATURES]; /* if it has any */
    hal_limits_t         limits; /* what it bears: as much as the list of parameters knows, unless a test says less */
    uint32_t             clock_cyc;
    uint32_t             isr_cyc;       /* how far the clock goes between two readings */
    bool                 seq_by_itself; /* every period has the next sequence number */

    /* what the drive did */
    hal_duty_t   duty;
    float        brake_duty;
    bool         armed, speed_requested;
    uint32_t     brakes, reads, edges, duties, arms, disarms, clears, requests;
    bench_call_t log[BENCH_LOG]; /* since bench_forget_calls */
    uint16_t     logged;

    /* a rotor that the vector of the duties draws along, by a twentieth of the way in a period */
    double rotor_pairs; /* pole pairs; negative: the encoder counts down; 0: no rotor, the angle is what it is set to */
    double rotor_e;     /* its electrical angle */
    double rotor_load;  /* how far behind the vector it stays at 2.4 V, rad; more at less */

    /* run in the middle of the call of this name, once: an interrupt that comes there */
    void (*in_arm)(void);
    void (*in_disarm)(void);
    void (*in_clear)(void);
    void (*in_clock_hz)(void);
} bench_t;

extern bench_t bench;
extern drive_t drive;

/** A board with 24 V, no currents, angle 0; the drive forgotten. */
void bench_start(void);
void bench_forget_calls(void);

/** Parameters of a drive that needs no start-up and runs by itself: current loop 0.6 V/A without integral part, no
 *  check of the motion against torque and voltage. */
drive_params_t bench_params(void);
/** drive_init and as many passes of the main loop as take it to RUN. */
void bench_run_with(const drive_params_t *params);
/** Into state @p state with @p params changed where that is needed. */
void bench_into(drive_state_t state);

/** One PWM period: next sequence number, current interrupt, speed interrupt if it was requested. */
void bench_period(void);
void bench_periods(uint32_t count);
/** Periods with passes of the main loop in between, one every 10. */
void bench_live(uint32_t periods);

/** A command, taken for granted. */
void bench_command(drive_mode_t mode, double speed_ref_rad_s, double id_ref_a, double iq_ref_a);

/** Phase currents of a vector in the frame at @p theta_e. */
void bench_currents(double d_a, double q_a, double theta_e);
/** A rotor, see above, at electrical angle @p theta_e. */
void bench_rotor(double pole_pairs, double theta_e);
/** With a rotor: from READY through an alignment to what comes after it; FAULT or RUN. */
void bench_align(void);
/** Mechanical angle into [0, 2 pi). */
void bench_angle(double theta_m);
/** Voltage vector that the duties make on the dc link of the sample. */
void bench_voltage(double *alpha_v, double *beta_v);
/** Turn at constant speed until the tracking filter has it, ending at mechanical angle @p end. */
void bench_spin(double speed_rad_s, double end);

/** Position of the first such call in the log, or -1. */
int bench_first(bench_call_t call);

/** Asserts zero voltage, exactly. */
#define ASSERT_ZERO_VOLTAGE(text)                                                                                                \
    do {                                                                                                                         \
        TEST_ASSERT_EQUAL_FLOAT_MESSAGE(0.5f, bench.duty.a, (text));                                                             \
        TEST_ASSERT_EQUAL_FLOAT_MESSAGE(0.5f, bench.duty.b, (text));                                                             \
        TEST_ASSERT_EQUAL_FLOAT_MESSAGE(0.5f, bench.duty.c, (text));                                                             \
    } while (0)
/* The board cuts what rounding leaves beside 0 and 1: below 4e-7, see control/motor/svm.h. */
#define BENCH_DUTY_IS_LEGAL(duty) (((duty) >= -4.0e-7f) && ((duty) <= 1.0000004f))
#define ASSERT_DUTIES_LEGAL(text)                                                                                                \
    do {                                                                                                                         \
        TEST_ASSERT_TRUE_MESSAGE(BENCH_DUTY_IS_LEGAL(bench.duty.a), (text));                                                     \
        TEST_ASSERT_TRUE_MESSAGE(BENCH_DUTY_IS_LEGAL(bench.duty.b), (text));                                                     \
        TEST_ASSERT_TRUE_MESSAGE(BENCH_DUTY_IS_LEGAL(bench.duty.c), (text));                                                     \
    } while (0)
#define ASSERT_FAULT(expected, text)                                                                                             \
    do {                                                                                                                         \
        TEST_ASSERT_EQUAL_STRING_MESSAGE(faults_info(expected)->name, faults_info((uint16_t)drive.fault)->name, (text));         \
        TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_FAULT, drive.state, (text));                                                         \
        TEST_ASSERT_FALSE_MESSAGE(bench.armed, (text));                                                                          \
    } while (0)
#define ASSERT_NO_FAULT(text)                                                                                                    \
    do {                                                                                                                         \
        TEST_ASSERT_EQUAL_STRING_MESSAGE("none", faults_info((uint16_t)drive.fault)->name, (text));                              \
        TEST_ASSERT_NOT_EQUAL_INT_MESSAGE(DRIVE_FAULT, drive.state, (text));                                                     \
    } while (0)

#endif
