/* Who writes what in the drive, from which interrupt: drive.h says it, and here every store is looked at. */
#include <string.h>

#include "firmware/app/internal.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/accesses.h"
#include "tests/firmware/support/bench.h"

void tearDown(void) {}

/* ---- contexts ----------------------------------------------------------------------------------------------------------- */

enum {
    CURRENT = 1,   /* the current interrupt, without the next one */
    TAKE_OVER = 2, /* its part that puts a changed set in force; not while the speed interrupt is under way */
    SPEED = 4,     /* the speed interrupt */
    MAIN = 8,      /* the main loop while the bridge is armed, */
    REST = 16      /* and while it is off */
};

static uint8_t writers[sizeof(drive_t)];
static uint8_t context;

static void written(const void *at, size_t size)
{
    const size_t offset = (size_t)((const char *)at - (const char *)&drive); /* huge for what lies outside */
    for (size_t k = 0; (offset < sizeof drive) && (k < size) && (offset + k < sizeof drive); k++) {
        writers[offset + k] |= (context == (MAIN | REST)) ? (bench.armed ? MAIN : REST) : context;
    }
}

static void watched(uint8_t in, void (*code)(void))
{
    context = in;
    accesses_watch(code, written);
}

static void current(void)
{
    drive_current_isr(&drive);
    drive_watch_isr(&drive);
}
static void speed(void) { drive_speed_isr(&drive); }
static void take_over(void) { drive_take_over(&drive); }
static void background(void) { drive_background(&drive); }

/* As the board calls them. */
static void period(void)
{
    bench.sample.seq++;
    if ((drive.next_ready != 0U) && (drive.speed_busy == 0U)) {
        watched(TAKE_OVER, take_over);
    }
    watched(CURRENT, current);
    if (bench.speed_requested) {
        bench.speed_requested = false;
        watched(SPEED, speed);
    }
}

/* The bridge may go on or off on the way. */
static void from_main(void (*code)(void)) { watched(MAIN | REST, code); }

static void periods(unsigned count)
{
    for (unsigned k = 0U; k < count; k++) {
        bench_angle(0.001 * k);
        bench.edge.edge_count += 1;
        bench.edge.edge_cyc += 20000U;
        bench.edge.index_passes = (uint16_t)(1U + (k / 100U));
        bench_currents(0.2, 0.1 * (k % 7U), 0.0);
        period();
        if ((k % 10U) == 9U) {
            from_main(background);
        }
    }
}

static drive_params_t  wanted;
static drive_command_t command;
static void            give(void) { (void)drive_command(&drive, &command); }
static void            tune(void)
{
    uint16_t culprit = 0U;
    TEST_ASSERT_TRUE(drive_tune(&drive, &wanted, &culprit));
}
static drive_excitation_t sine;
static void               excite(void)
{
    float low;
    float high;
    float hz;
    (void)drive_excite(&drive, &sine, &low, &high, &hz); /* what learns, and other modes than speed mode, refuse some */
}
static void start(void) { drive_start(&drive); }
static void stop(void) { drive_stop(&drive); }
static void home(void) { drive_home(&drive); }
static void clear(void) { drive_clear_fault(&drive); }

/* From power-up over an alignment into each mode, with changed sets, faults and all that the main loop may ask for. */
static void live(uint16_t method, uint16_t position_method, uint16_t deadbeat)
{
    bench_start();
    drive_params_t p = bench_params();
    p.method = method;
    p.position_method = position_method;
    p.current_controller = deadbeat;
    p.offset_calibration_periods = 20U;
    p.align_periods = BENCH_ALIGN_PERIODS;
    p.speed_deviation_s = 0.05f;
    p.zero_check = 1U;
    p.following_error_rad = 100.0f;
    p.rdc_learn_gain = 0.1f;
    p.current_correction = (uint16_t)(method % 3U);
    p.motor_resistance_ohm = 0.36f;
    p.dead_time_s = ((deadbeat == 0U) && (method < 2U)) ? 1.0e-6f : 0.0f;
    p.speed_model_ff = method & 1U;
    p.mtpa = (uint16_t)(position_method & 1U);
    p.field_weakening = (uint16_t)(method & 1U);
    p.link_withstand_v = 100.0f;
    p.motor_continuous_a = 5.0f;
    p.speed_ramp_rad_s2 = (float)(method & 1U) * 100.0f;
    p.stop_action = DRIVE_STOP_RAMP;
    p.restart_limit = 8U;
    p.motor_trip_c = 100.0f;
    p.regeneration_limit_v = 30.0f;
    p.chopper_v = 20.0f;
    bench.seq_by_itself = false;
    drive_init(&drive, &p);
    if (drive.fault != FAULT_none) {
        return; /* these do not go together */
    }
    periods(60U);
    bench_rotor(4.0, 0.5);
    from_main(start);
    for (unsigned k = 0U; (k < 20000U) && (drive.state != DRIVE_RUN) && (drive.state != DRIVE_FAULT); k++) {
        bench.seq_by_itself = false;
        double alpha, beta;
        bench_voltage(&alpha, &beta);
        if (bench.armed && (hypot(alpha, beta) > 1.0e-3)) {
            bench.rotor_e += 0.05 * remainder(atan2(beta, alpha) - bench.rotor_e, TWO_PI);
            bench_angle(bench.rotor_e / 4.0);
        }
        period();
        if ((k % 10U) == 9U) {
            from_main(background);
        }
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    for (int mode = DRIVE_MODE_CURRENT; mode <= DRIVE_MODE_POSITION; mode++) {
        command = (drive_command_t){.mode = (drive_mode_t)mode, .speed_ref_rad_s = 15.0f, .iq_ref_a = 0.5f, .target_turns = 1};
        from_main(give);
        from_main(home);
        for (int place = DRIVE_EXCITE_TORQUE; place <= DRIVE_EXCITE_SPEED; place++) {
            sine = (drive_excitation_t){(drive_excite_t)place, 0.1f, 150.0f};
            from_main(excite);
            periods(100U);
        }
        wanted = *drive.params;
        wanted.current_kp_v_per_a *= 0.9f;
        wanted.rc_fal_alpha *= 0.9f;
        from_main(tune);
        periods(30U);
        from_main(clear);
        from_main(start);
        periods(300U);
    }
    from_main(stop); /* down a ramp, and withdrawn */
    from_main(background);
    periods(60U);
    from_main(start);
    from_main(background);
    bench.edge_status = ((method & 1U) != 0U) ? HAL_SENSOR_FAULT : HAL_OK; /* a fault that the speed interrupt finds, */
    periods(30U);
    bench.edge_status = HAL_OK;
    from_main(clear);
    periods(30U);
    bench.sample_status = HAL_SENSOR_FAULT; /* and one that the current interrupt finds */
    periods(30U);
    bench.sample_status = HAL_OK;
    from_main(stop);
    from_main(clear);
    periods(30U);
    command = (drive_command_t){.mode = DRIVE_MODE_SPEED}; /* repetitive control does not go with position mode */
    from_main(give);
    wanted = *drive.params;
    wanted.method = (uint16_t)((method + 1U) % 4U);
    wanted.position_method = 0U;
    wanted.aro_cells = 100U;
    from_main(tune);
    periods(30U);
}

void setUp(void)
{
    static bool lived;
    if (!lived) {
        lived = true;
        for (uint16_t method = 0U; method < 7U; method++) {
            for (uint16_t position = 0U; position < 4U; position++) {
                live(method, position, (uint16_t)(position & 1U));
            }
        }
    }
}

/* ---- what is allowed --------------------------------------------------------------------------------------------------------- */

typedef struct {
    const char *name;
    size_t      offset, size;
    uint8_t     allowed;
} member_t;

#define MEMBER(path, who) {#path, offsetof(drive_t, path), sizeof(((drive_t *)0)->path), (who)}
#define ANYBODY (CURRENT | SPEED | MAIN | REST)

/* A longer name stands before the object that it is part of. */
static const member_t MEMBERS[] = {
    /* sets: the interrupt switches, and never writes into one */
    MEMBER(params, TAKE_OVER),
    MEMBER(setup, TAKE_OVER),
    MEMBER(set, MAIN | REST),
    MEMBER(next, MAIN | REST),
    MEMBER(next_ready, TAKE_OVER | MAIN | REST),
    MEMBER(speed_busy, CURRENT | SPEED),
    MEMBER(scale, 0),
    MEMBER(kept, MAIN | REST),
    /* commands and requests */
    MEMBER(command, MAIN | REST),
    MEMBER(order, MAIN | REST),
    MEMBER(command_at, MAIN | REST),
    MEMBER(excitation, MAIN | REST),
    MEMBER(start_wanted, MAIN | REST),
    MEMBER(stop_wanted, MAIN | REST),
    MEMBER(clear_wanted, MAIN | REST),
    MEMBER(home_wanted, SPEED | MAIN | REST),
    /* state: whoever finds a fault */
    MEMBER(state, ANYBODY),
    MEMBER(fault, ANYBODY),
    MEMBER(fault_detail, MAIN | REST),
    MEMBER(started_up, REST),
    MEMBER(permitted, MAIN | REST),
    MEMBER(stopping, MAIN | REST),
    MEMBER(stall, MAIN | REST),
    MEMBER(restarts, MAIN | REST),
    MEMBER(index, MAIN | REST),
    MEMBER(thermal.share, MAIN | REST),
    MEMBER(thermal.celsius, MAIN | REST),
    MEMBER(thermal.bad, MAIN | REST),
    MEMBER(thermal, SPEED),
    MEMBER(braking, SPEED),
    MEMBER(sto, MAIN | REST),
    /* the current interrupt's; the main loop sets up what stands while the bridge is off */
    MEMBER(sample, CURRENT),
    MEMBER(ia_a, CURRENT),
    MEMBER(ib_a, CURRENT),
    MEMBER(ic_a, CURRENT),
    MEMBER(offset_a_a, REST),
    MEMBER(offset_b_a, REST),
    MEMBER(offset_c_a, REST),
    MEMBER(sum_a_a, CURRENT | REST),
    MEMBER(sum_b_a, CURRENT | REST),
    MEMBER(sum_c_a, CURRENT | REST),
    MEMBER(sum_count, CURRENT | REST),
    MEMBER(tracking.jump_periods, CURRENT | REST),
    MEMBER(tracking, CURRENT | TAKE_OVER),
    MEMBER(zero, MAIN | REST),
    MEMBER(align, CURRENT | MAIN | REST), /* the main loop before the vector moves, and after */
    MEMBER(current.meas, CURRENT),
    MEMBER(current.ref, CURRENT | REST),
    MEMBER(current.volt, CURRENT | REST),
    MEMBER(current.excite_phase, CURRENT),
    MEMBER(current.excitation, CURRENT),
    MEMBER(current.excite_held, CURRENT),
    MEMBER(current, CURRENT | TAKE_OVER | REST),
    MEMBER(reference, SPEED | REST),
    /* the speed loop's quality figure and target: words that the current interrupt only reads */
    MEMBER(observer.observer.prepared, MAIN | REST),
    MEMBER(observer.observer.state.seen, MAIN | REST),
    MEMBER(observer.observer.state.memory.state.change, MAIN | REST),
    MEMBER(observer.observer.state.turn_samples, MAIN | REST),
    MEMBER(observer.observer.state.rounding, MAIN | REST),
    MEMBER(observer.observer.state.kept, MAIN | REST),
    MEMBER(observer.observer.state.kept_rounding, MAIN | REST),
    MEMBER(observer.observer.state.synchronous, MAIN | REST),
    MEMBER(observer.observer.state.drifts, MAIN | REST),
    MEMBER(observer.observer.state.drifting, MAIN | REST),
    MEMBER(observer.observer.state.drift, MAIN | REST),
    MEMBER(observer.observer, CURRENT | TAKE_OVER | REST),
    MEMBER(observer.meter.prepared, MAIN | REST),
    MEMBER(observer.meter, CURRENT | TAKE_OVER | REST),
    MEMBER(observer.seen, CURRENT),
    MEMBER(observer.estimate, CURRENT | TAKE_OVER | REST),
    MEMBER(sensors.log.ready, CURRENT | MAIN | REST),
    MEMBER(sensors.log.turn, CURRENT | MAIN | REST), /* the complete one by the main loop */
    MEMBER(sensors.log, CURRENT),
    MEMBER(sensors.held, CURRENT | REST),
    MEMBER(sensors, MAIN | REST),
    MEMBER(link_mean_v, CURRENT),
    MEMBER(plausibility, CURRENT | TAKE_OVER | REST),
    MEMBER(speed_count, CURRENT),
    MEMBER(bad_samples, CURRENT | REST),
    MEMBER(lost_samples, CURRENT | REST),
    MEMBER(seen_sample, CURRENT),
    MEMBER(rejected, CURRENT),
    MEMBER(timing.current, CURRENT),
    MEMBER(timing.used_cyc, CURRENT),
    MEMBER(timing.least_cyc, CURRENT),
    MEMBER(timing.span_cyc, CURRENT | MAIN | REST), /* by the main loop: 0, for a restart */
    /* the speed interrupt's */
    MEMBER(speed.now_cyc, CURRENT),
    MEMBER(speed.theta_e, CURRENT),
    MEMBER(speed.drift, MAIN | REST),
    MEMBER(speed.excite_phase, SPEED),
    MEMBER(speed.rc.table, MAIN | REST),
    MEMBER(speed.rc.prepared, TAKE_OVER | MAIN | REST),
    MEMBER(speed.rc.state.frozen, SPEED | TAKE_OVER | MAIN | REST), /* by the main loop where rc.fast: then no step touches it */
    MEMBER(speed, SPEED | TAKE_OVER | REST),
    MEMBER(position, SPEED | TAKE_OVER | REST),
    MEMBER(motion, SPEED),
    MEMBER(timing.speed, SPEED),
    MEMBER(rc_memory, SPEED | REST),
    /* the observer's part by the current interrupt, the position loop's by the speed interrupt (drive_build_position_memory);
     * at a synchronous speed the main loop takes an order out of the former, cell by cell, each one word (kept_order.h) */
    MEMBER(observer_memory, CURRENT | SPEED | MAIN | REST),
    /* the main loop's */
    MEMBER(timing.epoch, MAIN | REST),
    MEMBER(storage, MAIN | REST),
    MEMBER(saved_cells, MAIN | REST),
};

static const member_t *member_at(size_t offset)
{
    size_t i = 0;
    while ((i < COUNT_OF(MEMBERS)) && ((offset < MEMBERS[i].offset) || (offset >= (MEMBERS[i].offset + MEMBERS[i].size)))) {
        i++;
    }
    return (i < COUNT_OF(MEMBERS)) ? &MEMBERS[i] : NULL;
}

static const char *names(uint8_t who)
{
    return at("%s%s%s%s%s", ((who & CURRENT) != 0U) ? " current interrupt" : "", ((who & TAKE_OVER) != 0U) ? " take-over" : "",
              ((who & SPEED) != 0U) ? " speed interrupt" : "", ((who & MAIN) != 0U) ? " main loop, armed" : "",
              ((who & REST) != 0U) ? " main loop at rest" : "");
}

void test_writers_every_member_is_written_by_those_who_may_and_by_nobody_else(void)
{
    for (size_t k = 0; k < sizeof drive; k++) {
        if (writers[k] == 0U) {
            continue;
        }
        const member_t *const m = member_at(k);
        TEST_ASSERT_NOT_NULL_MESSAGE(m, at("byte %u of drive_t is written, and stands in no line of MEMBERS", (unsigned)k));
        if ((writers[k] & (uint8_t)~m->allowed) != 0U) {
            char text[160];
            (void)snprintf(text, sizeof text, "%s, byte %u, is written by:%s", m->name, (unsigned)(k - m->offset),
                           names(writers[k] & (uint8_t)~m->allowed));
            TEST_FAIL_MESSAGE(text);
        }
    }
}

/* Else the test above would look at nothing. */
void test_writers_every_context_was_seen_at_work(void)
{
    uint8_t seen = 0U;
    for (size_t k = 0; k < sizeof drive; k++) {
        seen |= writers[k];
    }
    TEST_ASSERT_EQUAL_HEX8(CURRENT | TAKE_OVER | SPEED | MAIN | REST, seen);
    const size_t some[] = {offsetof(drive_t, state),     offsetof(drive_t, position.now),    offsetof(drive_t, speed.rc.state),
                           offsetof(drive_t, rc_memory), offsetof(drive_t, observer_memory), offsetof(drive_t, zero)};
    for (size_t i = 0; i < COUNT_OF(some); i++) {
        bool any = false;
        for (size_t k = some[i]; k < (some[i] + 40U); k++) {
            any = any || (writers[k] != 0U);
        }
        TEST_ASSERT_TRUE_MESSAGE(any, at("member %u", (unsigned)i));
    }
}
