/* An interrupt between any two accesses of the main loop to memory: what is handed over is seen as a whole, or not at all. */
#include <string.h>

#include "firmware/app/internal.h"
#include "firmware/app/telemetry.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"
#include "tests/firmware/support/accesses.h"

void setUp(void) { bench_start(); }
void tearDown(void) {}

#define NEVER UINT32_MAX

/* The drive and its board as they were, at the same place: the drive has pointers into itself. */
static drive_t drive_then;
static bench_t bench_then;

static void keep(void)
{
    (void)memcpy(&drive_then, &drive, sizeof drive);
    bench_then = bench;
}

static void back(void)
{
    (void)memcpy(&drive, &drive_then, sizeof drive);
    bench = bench_then;
}

static void main_loop(void) { drive_background(&drive); }

/* ---- the electrical zero ------------------------------------------------------------------------------------------------ */

static uint16_t culprit;

/* A change of a gain waits for the interrupt while the main loop finishes the alignment. */
static void into_the_end_of_an_alignment(void)
{
    drive_params_t p = bench_params();
    p.align_periods = BENCH_ALIGN_PERIODS;
    p.encoder_offset_rad = 1.0f;
    drive_init(&drive, &p);
    drive_background(&drive);
    bench_rotor(4.0, 2.3);
    drive_start(&drive);
    drive_background(&drive);
    for (uint32_t k = 0U; (k < 100000U) && (drive.align.phase != (uint16_t)DRIVE_ALIGN_DONE); k++) {
        bench_period();
        if (drive.align.phase != (uint16_t)DRIVE_ALIGN_DONE) {
            drive_background(&drive);
        }
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_ALIGN, drive.state);
    TEST_ASSERT_EQUAL_UINT16(DRIVE_ALIGN_DONE, drive.align.phase);
    p = *drive.params;
    p.current_kp_v_per_a = 0.5f;
    TEST_ASSERT_TRUE(drive_tune(&drive, &p, &culprit));
    keep();
}

void test_preemption_take_over_at_the_end_of_an_alignment_leaves_the_zero_that_was_found(void)
{
    into_the_end_of_an_alignment();
    const uint32_t length = accesses_run(main_loop, NEVER, bench_period);
    const angle_t  found = drive.zero.e;
    TEST_ASSERT_TRUE(drive.zero.found);
    TEST_ASSERT_TRUE(angle_size(found - drive.set[0].setup.tracking.encoder_offset) >
                     (ANGLE_QUARTER / 4U)); /* the two can be distinguished */
    TEST_ASSERT_TRUE(length > 20U);

    for (uint32_t n = 1U; n <= length; n++) {
        back();
        (void)accesses_run(main_loop, n, bench_period);
        bench_period();
        TEST_ASSERT_TRUE(drive.zero.found);
        TEST_ASSERT_EQUAL_HEX32_MESSAGE(found, drive.zero.e, at("before access %u", (unsigned)n));
        TEST_ASSERT_EQUAL_FLOAT(0.5f, drive.params->current_kp_v_per_a);
    }
}

/* The other way round: a fault makes the zero void while another offset, set at rest, waits for the interrupt. */
void test_preemption_zero_that_a_fault_voids_follows_the_newest_parameter(void)
{
    into_the_end_of_an_alignment();
    drive_background(&drive);
    bench_periods(20U);
    drive_trip(&drive, FAULT_encoder_error);
    drive_background(&drive);
    drive_params_t p = *drive.params;
    p.encoder_offset_rad = 2.0f;
    TEST_ASSERT_TRUE(drive_tune(&drive, &p, &culprit));
    drive_clear_fault(&drive);
    keep();
    const uint32_t length = accesses_run(main_loop, NEVER, bench_period);

    for (uint32_t n = 1U; n <= length + 1U; n++) {
        back();
        (void)accesses_run(main_loop, n, bench_period);
        bench_period();
        TEST_ASSERT_FALSE(drive.zero.found);
        TEST_ASSERT_EQUAL_HEX32_MESSAGE(angle_from_rad(num_of(2.0)), drive.zero.e, at("before access %u", (unsigned)n));
    }
}

/* ---- commands ------------------------------------------------------------------------------------------------------------- */

static const drive_command_t OTHER = {.mode = DRIVE_MODE_CURRENT, .id_ref_a = -3.0f, .iq_ref_a = -4.0f};

static void give_command(void) { (void)drive_command(&drive, &OTHER); }

static float d_seen, q_seen;

static void see(void)
{
    bench_period();
    d_seen = telemetry_read(&drive, SIGNAL_id_ref_a);
    q_seen = telemetry_read(&drive, SIGNAL_iq_ref_a);
}

void test_preemption_command_is_seen_as_a_whole(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 1.0, 2.0);
    bench_period();
    keep();
    const uint32_t length = accesses_run(give_command, NEVER, see);
    TEST_ASSERT_TRUE(length > 10U);
    for (uint32_t n = 1U; n <= length; n++) {
        back();
        (void)accesses_run(give_command, n, see);
        const bool old = d_seen > 0.0f;
        TEST_ASSERT_FLOAT_WITHIN_MESSAGE(1e-5f, old ? 1.0f : -3.0f, d_seen, at("before access %u", (unsigned)n));
        TEST_ASSERT_FLOAT_WITHIN_MESSAGE(1e-5f, old ? 2.0f : -4.0f, q_seen, at("before access %u", (unsigned)n));
        see();
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, -3.0f, d_seen);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, -4.0f, q_seen);
    }
}

/* ---- parameters ----------------------------------------------------------------------------------------------------------- */

static drive_params_t wanted;

static void change(void) { TEST_ASSERT_TRUE(drive_tune(&drive, &wanted, &culprit)); }

/* The numbers that the blocks have are those of the set in force. */
static void assert_blocks_fit(const char *when)
{
    const drive_setup_t *const s = drive.setup;
    TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(value_of(s->current.pi.kp), value_of(drive.current.q.params.kp), when);
    TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(value_of(s->speed.pi.kp), value_of(drive.speed.pi.params.kp), when);
    if (s->speed.rc_used) {
        TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(value_of(s->speed.rc.gain), value_of(drive.speed.rc.params.gain), when);
        TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(value_of(s->speed.rc.fal.alpha), value_of(drive.speed.rc.fal->params.alpha), when);
        const num_t slope = num_pow(s->speed.rc.fal.delta, num_sub(s->speed.rc.fal.alpha, NUM_C(1.0f)));
        TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(value_of(slope), value_of(drive.speed.rc.fal->slope), when);
    }
    if (s->observer.used) {
        TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(value_of(s->observer.observer.memory.gain),
                                         value_of(drive.observer.observer.params.memory.gain), when);
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(s->observer.observer.age_half >> 1, drive.observer.observer.derived.age, when);
        TEST_ASSERT_EQUAL_UINT16_MESSAGE((uint16_t)num_floor(s->observer.meter.actuation), drive.observer.meter.held.whole, when);
    }
}

void test_preemption_parameter_set_is_taken_over_as_a_whole(void)
{
    const uint16_t method[] = {DRIVE_METHOD_FAL_FORC, DRIVE_METHOD_ARO};
    for (size_t m = 0; m < COUNT_OF(method); m++) {
        bench_start();
        drive_params_t p = bench_params();
        p.method = method[m];
        bench_run_with(&p);
        bench_command(DRIVE_MODE_SPEED, 15.0, 0.0, 0.0);
        bench_periods(50U);
        wanted = *drive.params;
        wanted.current_kp_v_per_a = 0.5f;
        wanted.speed_kp_a_per_unit = 0.02f;
        wanted.rc_gain = 0.4f;
        wanted.rc_fal_alpha = 0.5f;
        wanted.observer_gain = 0.02f;
        wanted.observer_age_samples = 7.0f;
        wanted.observer_actuation_samples = 4.5f;
        keep();
        const uint32_t length = accesses_run(change, NEVER, bench_period);
        uint32_t       with_old = 0U;
        uint32_t       tried = 0U;
        for (uint32_t n = 1U; n <= length; n++) {
            back();
            (void)accesses_run(change, n, bench_period);
            const bool old = drive.params->current_kp_v_per_a > 0.55f;
            with_old += old ? 1U : 0U;
            tried++;
            assert_blocks_fit(at("method %u before access %u", (unsigned)method[m], (unsigned)n));
            bench_period();
            TEST_ASSERT_EQUAL_MEMORY(&wanted, drive.params, sizeof wanted);
            assert_blocks_fit("then");
        }
        TEST_ASSERT_TRUE((with_old > 0U) && (with_old < tried)); /* drive_command_again comes after the flag */
    }
}

/* ---- 64 bits ---------------------------------------------------------------------------------------------------------------- */

/* On the chip the two halves of a position are two accesses; here any values stand for a position that is half written. */
void test_preemption_position_that_is_being_written_does_not_show(void)
{
    bench_into(DRIVE_RUN);
    bench_angle(0.3);
    bench_periods(30U);
    const float now = telemetry_read(&drive, SIGNAL_position_rad);
    const float ref = telemetry_read(&drive, SIGNAL_position_ref_rad);
    drive.position.now = 5 * CTL_ONE_TURN;
    drive.position.setpoint.position = -7 * CTL_ONE_TURN;
    drive.position.now_shown.value[(drive.position.now_shown.at & 1U) ^ 1U] = 9 * CTL_ONE_TURN;
    drive.position.ref_shown.value[(drive.position.ref_shown.at & 1U) ^ 1U] = 9 * CTL_ONE_TURN;

    TEST_ASSERT_EQUAL_FLOAT(now, telemetry_read(&drive, SIGNAL_position_rad));
    TEST_ASSERT_EQUAL_FLOAT(ref, telemetry_read(&drive, SIGNAL_position_ref_rad));
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.3, (double)now);
}
