/* control/position/profile.c: limits are kept, targets are met exactly, and speed and acceleration are the differences. */
#include <stdlib.h>

#include "tests/support/numeric.h"

#include "control/position/profile.h"

#define SCALE (1.0 / 1024.0)
#define SPEED_OF(step) ((double)(step) / 65536.0 * SCALE)    /* 2^-16 turns */
#define ACCEL_OF(change) ((double)(change) / 4096.0 * SCALE) /* 2^-20 turns */
#define SPEED 20000000LL                                     /* 0.0047 turns per sample */
#define ACCEL 150000LL
#define DOWN_TO 4 /* steps of 2^-32 turn: the mean cuts, and the differences see it */

static ctl_profile_t profile;

static ctl_profile_params_t params(int64_t speed, int64_t acceleration, uint16_t smooth)
{
    const ctl_profile_params_t p = {.speed = speed,
                                    .acceleration = acceleration,
                                    .smooth = smooth,
                                    .speed_scale = num_of(SCALE),
                                    .accel_scale = num_of(SCALE)};
    return p;
}

static void start(int64_t speed, int64_t acceleration, uint16_t smooth)
{
    const ctl_profile_params_t p = params(speed, acceleration, smooth);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_profile_init(&profile, &p).status);
}

void setUp(void) { start(SPEED, ACCEL, 1U); }
void tearDown(void) {}

/* One sample of the motion, everything that always has to hold asserted; the step. */
static int64_t watch(ctl_position_t target, ctl_setpoint_t *out)
{
    const ctl_profile_params_t *const p = &profile.params;
    const ctl_position_t              before = profile.state.position;
    const int64_t                     last = profile.state.last;
    const ctl_setpoint_t              s = ctl_profile_step(&profile, target);
    const int64_t                     step = s.position - before;
    const int64_t                     change = step - last;

    TEST_ASSERT_TRUE_MESSAGE(llabs(step) <= p->speed, at("step %lld", (long long)step));
    if (p->acceleration > 0) {
        /* the mean over n samples may round the position by less than one each time */
        const int64_t round = (p->smooth > 1U) ? 2 : 0;
        TEST_ASSERT_TRUE_MESSAGE(llabs(change) <= p->acceleration + round,
                                 at("change %lld at step %lld", (long long)change, (long long)last));
        const double acceleration = ACCEL_OF(change);
        if (fabs(acceleration) < 127.0) {
            ASSERT_NUM_WITHIN(per_numeric(2e-7 * fabs(acceleration), FIXED_STEP), acceleration, s.acceleration);
        }
    } else {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(s.acceleration));
    }
    const double speed = SPEED_OF(step);
    ASSERT_NUM_WITHIN(per_numeric(2e-7 * fabs(speed), FIXED_STEP), speed, s.speed); /* up to half a turn: 32 */
    *out = s;
    return step;
}

/* Until done, at most `most` samples; how many it took. */
static int run_to(ctl_position_t target, int most)
{
    ctl_setpoint_t s;
    for (int k = 1; k <= most; k++) {
        (void)watch(target, &s);
        if (s.done) {
            TEST_ASSERT_EQUAL_INT64(target, s.position);
            for (int more = 0; more < 100; more++) { /* and it stays there */
                TEST_ASSERT_EQUAL_INT64(0, watch(target, &s));
                TEST_ASSERT_TRUE(s.done);
            }
            return k;
        }
    }
    TEST_FAIL_MESSAGE(at("not at %lld after %d samples", (long long)target, most));
    return 0;
}

/* ---- one motion -------------------------------------------------------------------------------------------------------- */

void test_ctl_profile_stands_at_zero_after_init(void)
{
    ctl_setpoint_t s;

    TEST_ASSERT_EQUAL_INT64(0, watch(0, &s));
    TEST_ASSERT_TRUE(s.done);
    TEST_ASSERT_EQUAL_INT64(0, s.position);
}

void test_ctl_profile_stands_where_it_was_reset_to(void)
{
    ctl_setpoint_t s;
    (void)run_to(3 * CTL_ONE_TURN, 3000);
    ctl_profile_reset(&profile.state, -7 * CTL_ONE_TURN + 3);

    TEST_ASSERT_EQUAL_INT64(0, watch(-7 * CTL_ONE_TURN + 3, &s));
    TEST_ASSERT_TRUE(s.done);

    start(SPEED, ACCEL, 64U); /* with a mean, too, from the first sample on */
    TEST_ASSERT_EQUAL_INT64(0, watch(0, &s));
    TEST_ASSERT_TRUE(s.done);
}

/* way v t with ramps of v / a: t = way / v + v / a samples */
void test_ctl_profile_long_motion_takes_the_time_of_a_trapezoid(void)
{
    const int64_t ways[] = {CTL_ONE_TURN, 10 * CTL_ONE_TURN, 5000000000LL, -CTL_ONE_TURN, -12345678901LL};
    for (size_t k = 0; k < COUNT_OF(ways); k++) {
        ctl_profile_reset(&profile.state, 0);
        const double time = fabs((double)ways[k]) / (double)SPEED + (double)SPEED / (double)ACCEL;

        /* ramps and cruise are cut to whole samples each, and that it is done shows one sample later */
        ASSERT_DOUBLE_WITHIN_AT(2.0, time + 1.0, (double)run_to(ways[k], 10000), at("way %lld", (long long)ways[k]));
    }
}

/* where the speed is a whole number of accelerations and one step more, the last step of braking is a tiny one */
void test_ctl_profile_does_not_creep_at_the_end_whatever_the_ratio_of_the_limits(void)
{
    noise_t noise = {131U};
    for (int n = 0; n < 500; n++) {
        const int64_t rest[] = {0, 1, 2, ACCEL - 1, (int64_t)noise_pick(&noise, (uint32_t)ACCEL)};
        const int64_t speed = ACCEL * (1 + (int64_t)noise_pick(&noise, 100U)) + rest[n % 5];
        const int64_t way = 1 + (int64_t)noise_bits(&noise) / ((n % 7) + 1);
        start(speed, ACCEL, 1U);
        const double ramp = (double)speed / (double)ACCEL;
        const double time =
            ((double)way > ramp * (double)speed) ? (double)way / (double)speed + ramp : 2.0 * sqrt((double)way / (double)ACCEL);

        ASSERT_DOUBLE_WITHIN_AT(2.5, time + 1.0, (double)run_to(way, 100000),
                                at("way %lld at %lld", (long long)way, (long long)speed));
    }
}

/* too short for the speed: a triangle, t = 2 sqrt(way / a) */
void test_ctl_profile_short_motion_takes_the_time_of_a_triangle(void)
{
    const int64_t ways[] = {ACCEL * 9, ACCEL * 100, ACCEL * 5000, -ACCEL * 2500, SPEED * SPEED / ACCEL};
    for (size_t k = 0; k < COUNT_OF(ways); k++) {
        ctl_profile_reset(&profile.state, 0);
        const double time = 2.0 * sqrt(fabs((double)ways[k]) / (double)ACCEL);

        ASSERT_DOUBLE_WITHIN_AT(2.0, time + 1.0, (double)run_to(ways[k], 10000), at("way %lld", (long long)ways[k]));
    }
}

void test_ctl_profile_reaches_and_keeps_its_speed(void)
{
    ctl_setpoint_t s;
    int            at_speed = 0;
    for (int k = 0; k < 600; k++) {
        at_speed += (watch(100 * CTL_ONE_TURN, &s) == SPEED) ? 1 : 0;
        TEST_ASSERT_FALSE(s.done);
    }
    TEST_ASSERT_INT_WITHIN(1, 600 - (int)(SPEED / ACCEL), at_speed);
}

void test_ctl_profile_accelerates_at_its_limit_from_the_first_sample(void)
{
    ctl_setpoint_t s;
    for (int k = 1; k <= 100; k++) {
        TEST_ASSERT_EQUAL_INT64(k * ACCEL, watch(100 * CTL_ONE_TURN, &s));
    }
}

void test_ctl_profile_never_turns_back_on_the_way_to_a_fixed_target(void)
{
    noise_t noise = {113U};
    for (int n = 0; n < 300; n++) {
        start(1 + (int64_t)noise_pick(&noise, 50000000U), 1 + (int64_t)noise_pick(&noise, 2000000U),
              (uint16_t)(1U + noise_pick(&noise, 64U)));
        const double   full = fmin((double)profile.params.speed * 200.0, 1e13);
        const int64_t  way = (int64_t)(full * 2.0 * noise_next(&noise));
        ctl_setpoint_t s = {0, (num_t)0, (num_t)0, false};
        for (int k = 0; (k < 100000) && !s.done; k++) {
            const int64_t step = watch(way, &s);
            TEST_ASSERT_TRUE_MESSAGE((way >= 0) ? (step >= 0) : (step <= 0), at("motion %d", n));
        }
        TEST_ASSERT_TRUE_MESSAGE(s.done, at("motion %d does not end", n));
        TEST_ASSERT_EQUAL_INT64(way, s.position);
    }
}

void test_ctl_profile_back_is_the_mirror_image(void)
{
    ctl_profile_t back = profile;
    for (int k = 0; k < 2000; k++) {
        const ctl_setpoint_t a = ctl_profile_step(&profile, 5 * CTL_ONE_TURN / 3);
        const ctl_setpoint_t b = ctl_profile_step(&back, -5 * CTL_ONE_TURN / 3);
        TEST_ASSERT_EQUAL_INT64(a.position, -b.position);
        TEST_ASSERT_DOUBLE_WITHIN(per_numeric(0.0, FIXED_STEP), value_of(a.speed), -value_of(b.speed));
        TEST_ASSERT_EQUAL(a.done, b.done);
    }
}

void test_ctl_profile_tiny_ways_end_exactly(void)
{
    const int64_t ways[] = {1, -1, 2, 3, ACCEL - 1, ACCEL, ACCEL + 1, 2 * ACCEL, 3 * ACCEL - 1, -3 * ACCEL - 1};
    for (uint16_t smooth = 1U; smooth <= 64U; smooth = (uint16_t)(smooth + 21U)) {
        start(SPEED, ACCEL, smooth);
        for (size_t k = 0; k < COUNT_OF(ways); k++) {
            ctl_profile_reset(&profile.state, 12345);
            TEST_ASSERT_TRUE(run_to(12345 + ways[k], 80) <= 10 + (int)smooth);
        }
    }
}

void test_ctl_profile_slowest_motion_there_is_ends_exactly(void)
{
    start(1, 1, 1U);
    TEST_ASSERT_EQUAL_INT(201, run_to(200, 300));
    start(100, 1, 1U);
    TEST_ASSERT_INT_WITHIN(2, 200, run_to(10000, 300));
}

void test_ctl_profile_fastest_motion_there_is_ends_exactly(void)
{
    const int64_t most = 0x7FFFFFFF;
    start(most, most, 1U);
    TEST_ASSERT_INT_WITHIN(2, 2000, run_to(1000 * CTL_ONE_TURN, 3000));
    start(most, 1000, 64U);
    ctl_setpoint_t s;
    for (int k = 0; k < 3000; k++) {
        (void)watch(1000000 * CTL_ONE_TURN, &s);
    }
    TEST_ASSERT_INT64_WITHIN(64 * 1000, 3000 * 1000, profile.state.last);
}

/* ---- smoothing ---------------------------------------------------------------------------------------------------------- */

/* the mean over n samples delays by (n - 1) / 2 and ends n - 1 later */
void test_ctl_profile_smoothing_adds_its_samples_to_the_time(void)
{
    const int      plain = run_to(3 * CTL_ONE_TURN, 3000);
    const uint16_t lengths[] = {2U, 7U, 20U, 64U};
    for (size_t k = 0; k < COUNT_OF(lengths); k++) {
        start(SPEED, ACCEL, lengths[k]);
        TEST_ASSERT_EQUAL_INT(plain + (int)lengths[k] - 1, run_to(3 * CTL_ONE_TURN, 3000));
    }
}

void test_ctl_profile_smoothing_limits_the_jerk(void)
{
    const uint16_t lengths[] = {2U, 7U, 20U, 64U};
    for (size_t n = 0; n < COUNT_OF(lengths); n++) {
        start(SPEED, ACCEL, lengths[n]);
        const int64_t  jerk = ACCEL / lengths[n];
        int64_t        change = 0;
        int64_t        largest = 0;
        int64_t        last = 0;
        ctl_setpoint_t s = {0, (num_t)0, (num_t)0, false};
        for (int k = 0; (k < 3000) && !s.done; k++) {
            const int64_t step = watch(CTL_ONE_TURN, &s);
            const int64_t found = llabs((step - last) - change);
            largest = (found > largest) ? found : largest;
            change = step - last;
            last = step;
        }
        /* two edges of the trapezoid within one window, where it stops sharing what is left, may meet */
        TEST_ASSERT_TRUE_MESSAGE(largest <= 2 * jerk + DOWN_TO, at("jerk %lld of %lld", (long long)largest, (long long)jerk));
        TEST_ASSERT_TRUE_MESSAGE(largest >= jerk - DOWN_TO, "no jerk at all");
    }
}

void test_ctl_profile_smoothed_positions_are_the_mean_of_the_plain_ones(void)
{
    enum { N = 16 };
    ctl_profile_t  plain = profile;
    ctl_position_t past[N] = {0};
    start(SPEED, ACCEL, N);
    for (int k = 0; k < 1500; k++) {
        const ctl_position_t target = (k < 500) ? CTL_ONE_TURN : -CTL_ONE_TURN;
        past[k % N] = ctl_profile_step(&plain, target).position;
        double mean = 0.0;
        for (int i = 0; i < N; i++) {
            mean += (double)past[i] / N;
        }
        ASSERT_DOUBLE_WITHIN_AT(2.0, mean, (double)ctl_profile_step(&profile, target).position, at("sample %d", k));
    }
}

/* ---- the target moves ----------------------------------------------------------------------------------------------------- */

void test_ctl_profile_follows_a_target_that_is_moved_or_reversed_on_the_way(void)
{
    noise_t noise = {127U};
    for (uint16_t smooth = 1U; smooth <= 61U; smooth = (uint16_t)(smooth + 20U)) {
        start(SPEED, ACCEL, smooth);
        for (int n = 0; n < 200; n++) {
            const ctl_position_t target = (ctl_position_t)(noise_next(&noise) * 8.0 * (double)CTL_ONE_TURN);
            const int            samples = (int)noise_pick(&noise, 400U);
            ctl_setpoint_t       s;
            for (int k = 0; k < samples; k++) {
                (void)watch(target, &s);
            }
        }
        (void)run_to(17, 20000);
    }
}

/* the mean of the first steps is no whole step yet: it stands on the target, but what was begun is on its way */
void test_ctl_profile_is_not_done_while_the_mean_still_holds_a_motion(void)
{
    start(10, 1, 64U);
    ctl_setpoint_t s;
    (void)watch(100, &s);
    (void)watch(100, &s);
    TEST_ASSERT_EQUAL_INT64(0, watch(0, &s));
    TEST_ASSERT_EQUAL_INT64(0, s.position);
    TEST_ASSERT_FALSE(s.done);
    (void)run_to(0, 200);
}

/* braking from full speed: overshoots, because it has to, and by the braking way only */
void test_ctl_profile_target_too_near_to_stop_is_passed_by_the_braking_way(void)
{
    ctl_setpoint_t s = {0, (num_t)0, (num_t)0, false};
    for (int k = 0; k < 400; k++) {
        (void)watch(100 * CTL_ONE_TURN, &s);
    }
    const ctl_position_t target = s.position + 1000;
    ctl_position_t       furthest = s.position;
    for (int k = 0; k < 2000; k++) {
        (void)watch(target, &s);
        furthest = (s.position > furthest) ? s.position : furthest;
    }
    const double braking = (double)SPEED * (double)SPEED / (2.0 * (double)ACCEL);

    TEST_ASSERT_TRUE(s.done);
    TEST_ASSERT_EQUAL_INT64(target, s.position);
    TEST_ASSERT_DOUBLE_WITHIN(1.0 * (double)SPEED, braking, (double)(furthest - target));
}

void test_ctl_profile_target_at_the_other_end_of_the_world_is_no_trouble(void)
{
    const ctl_position_t targets[] = {INT64_MAX, INT64_MIN, INT64_MAX / 2, INT64_MIN / 2};
    for (size_t k = 0; k < COUNT_OF(targets); k++) {
        ctl_setpoint_t s;
        ctl_profile_reset(&profile.state, 0);
        for (int i = 0; i < 1000; i++) {
            (void)watch(targets[k], &s);
        }
        TEST_ASSERT_EQUAL_INT64((targets[k] > 0) ? SPEED : -SPEED, profile.state.last);
        TEST_ASSERT_FALSE(s.done);
        (void)run_to(0, 3000);
    }
}

/* from INT64_MAX the way back is the shorter one around: wraps, as positions do, and never beyond a limit */
void test_ctl_profile_way_that_does_not_fit_is_still_bounded(void)
{
    ctl_setpoint_t s;
    ctl_profile_reset(&profile.state, INT64_MAX - 5);
    for (int i = 0; i < 300; i++) {
        const int64_t before = profile.state.last;
        s = ctl_profile_step(&profile, -6);
        TEST_ASSERT_TRUE(llabs(profile.state.last) <= SPEED);
        TEST_ASSERT_TRUE(llabs(profile.state.last - before) <= ACCEL);
        TEST_ASSERT_FALSE(s.done);
    }
}

/* ---- unlimited acceleration ------------------------------------------------------------------------------------------------ */

void test_ctl_profile_without_acceleration_limit_is_a_ramp(void)
{
    start(SPEED, 0, 1U);
    ctl_setpoint_t s;
    for (int k = 1; k <= 214; k++) {
        TEST_ASSERT_EQUAL_INT64(SPEED, watch(CTL_ONE_TURN, &s));
        TEST_ASSERT_EQUAL_INT64(k * SPEED, s.position);
        TEST_ASSERT_FALSE(s.done);
    }
    TEST_ASSERT_EQUAL_INT64(CTL_ONE_TURN - 214 * SPEED, watch(CTL_ONE_TURN, &s));
    TEST_ASSERT_EQUAL_INT64(CTL_ONE_TURN, s.position);
    TEST_ASSERT_EQUAL_INT64(0, watch(CTL_ONE_TURN, &s));
    TEST_ASSERT_TRUE(s.done);
}

void test_ctl_profile_ramp_reverses_at_once(void)
{
    start(SPEED, 0, 1U);
    ctl_setpoint_t s;
    (void)watch(CTL_ONE_TURN, &s);

    TEST_ASSERT_EQUAL_INT64(-SPEED, watch(-CTL_ONE_TURN, &s));
    (void)run_to(-CTL_ONE_TURN, 300);
}

/* ---- limits changed on the way ----------------------------------------------------------------------------------------------- */

void test_ctl_profile_lower_speed_limit_is_reached_by_braking_and_higher_by_accelerating(void)
{
    ctl_setpoint_t s;
    for (int k = 0; k < 400; k++) {
        (void)watch(1000 * CTL_ONE_TURN, &s);
    }
    profile.params.speed = SPEED / 3;
    for (int k = 1; k < 200; k++) {
        const int64_t last = profile.state.last;
        (void)ctl_profile_step(&profile, 1000 * CTL_ONE_TURN);
        const int64_t expected = (last - ACCEL > SPEED / 3) ? (last - ACCEL) : SPEED / 3;
        TEST_ASSERT_EQUAL_INT64_MESSAGE(expected, profile.state.last, at("sample %d", k));
    }
    profile.params.speed = SPEED;
    for (int k = 0; k < 200; k++) {
        (void)watch(1000 * CTL_ONE_TURN, &s);
    }
    TEST_ASSERT_EQUAL_INT64(SPEED, profile.state.last);
    (void)run_to(CTL_ONE_TURN, 10000);
}

void test_ctl_profile_tune_on_the_way_keeps_the_motion_and_ends_on_the_target(void)
{
    noise_t noise = {151U};
    start(SPEED, ACCEL, 20U);
    for (int n = 0; n < 300; n++) {
        ctl_setpoint_t       s;
        const ctl_position_t target = (ctl_position_t)(noise_next(&noise) * 8.0 * (double)CTL_ONE_TURN);
        const int            samples = (int)noise_pick(&noise, 300U);
        for (int k = 0; k < samples; k++) {
            (void)watch(target, &s);
        }
        ctl_profile_params_t p = profile.params;
        p.smooth = (uint16_t)(1U + noise_pick(&noise, 64U));
        TEST_ASSERT_EQUAL(CTL_OK, ctl_profile_tune(&profile, &p).status); /* watch() sees to it that nothing jumps */
        if (n % 10 == 0) {
            (void)run_to(target, 20000);
        }
    }
}

void test_ctl_profile_tune_with_the_same_mean_changes_nothing_but_the_limits(void)
{
    start(SPEED, ACCEL, 20U);
    ctl_setpoint_t s;
    for (int k = 0; k < 77; k++) {
        (void)watch(CTL_ONE_TURN, &s);
    }
    const ctl_profile_state_t  before = profile.state;
    const ctl_profile_params_t p = params(SPEED / 2, ACCEL / 2, 20U);

    TEST_ASSERT_EQUAL(CTL_OK, ctl_profile_tune(&profile, &p).status);

    TEST_ASSERT_EQUAL_MEMORY(&before, &profile.state, sizeof before);
    TEST_ASSERT_EQUAL_INT64(SPEED / 2, profile.params.speed);
    TEST_ASSERT_EQUAL_INT64(ACCEL / 2, profile.params.acceleration);
}

void test_ctl_profile_tune_refuses_what_init_refuses_and_changes_nothing(void)
{
    const ctl_profile_t        before = profile;
    const ctl_profile_params_t p = params(SPEED, ACCEL, 65U);

    TEST_ASSERT_EQUAL(CTL_PROFILE_SMOOTH, ctl_profile_tune(&profile, &p).field);
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_profile_tune(&profile, NULL));
    TEST_ASSERT_EQUAL_MEMORY(&before, &profile, sizeof profile);
}

void test_ctl_profile_shift_is_the_same_motion_from_another_zero(void)
{
    const ctl_position_t shifts[] = {12345678901LL, -CTL_ONE_TURN / 3};
    for (size_t n = 0; n < COUNT_OF(shifts); n++) {
        start(SPEED, ACCEL, 7U);
        for (int k = 0; k < 99; k++) {
            (void)ctl_profile_step(&profile, CTL_ONE_TURN);
        }
        ctl_profile_t moved = profile;
        ctl_profile_shift(&moved.state, shifts[n]);
        for (int k = 0; k < 600; k++) {
            const ctl_setpoint_t a = ctl_profile_step(&profile, CTL_ONE_TURN);
            const ctl_setpoint_t b = ctl_profile_step(&moved, CTL_ONE_TURN - shifts[n]);
            TEST_ASSERT_EQUAL_INT64(a.position - shifts[n], b.position);
            TEST_ASSERT_EQUAL(a.done, b.done);
        }
    }
}

/* ---- refused ------------------------------------------------------------------------------------------------------------------ */

static void assert_refused(const ctl_profile_params_t *p, ctl_status_t status, uint16_t field)
{
    const ctl_profile_t before = profile;
    const ctl_diag_t    got = ctl_profile_init(&profile, p);

    TEST_ASSERT_EQUAL(status, got.status);
    TEST_ASSERT_EQUAL(field, got.field);
    if ((field == CTL_PROFILE_SPEED) || (field == CTL_PROFILE_ACCELERATION)) { /* 64 bits, which a num_t does not show */
        ASSERT_NUM_WITHIN(0.0, 0.0, got.given);
    }
    TEST_ASSERT_EQUAL_MEMORY(&before, &profile, sizeof profile);
}

void test_ctl_profile_init_without_object_or_parameters_is_null(void)
{
    const ctl_profile_params_t p = params(SPEED, ACCEL, 1U);

    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_profile_init(NULL, &p));
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_profile_tune(NULL, &p));
    assert_refused(NULL, CTL_ERR_NULL, 0U);
}

void test_ctl_profile_init_rejects_steps_out_of_range(void)
{
    const int64_t speeds[] = {0, -1, 0x80000000LL, INT64_MIN, INT64_MAX};
    const int64_t accelerations[] = {-1, 0x80000000LL, INT64_MIN, INT64_MAX};
    for (size_t k = 0; k < COUNT_OF(speeds); k++) {
        const ctl_profile_params_t p = params(speeds[k], ACCEL, 1U);
        assert_refused(&p, CTL_ERR_RANGE, CTL_PROFILE_SPEED);
    }
    for (size_t k = 0; k < COUNT_OF(accelerations); k++) {
        const ctl_profile_params_t p = params(SPEED, accelerations[k], 1U);
        assert_refused(&p, CTL_ERR_RANGE, CTL_PROFILE_ACCELERATION);
    }
}

void test_ctl_profile_init_rejects_a_mean_of_none_or_too_many(void)
{
    const uint16_t lengths[] = {0U, CTL_PROFILE_SMOOTH_MAX + 1U, 65535U};
    for (size_t k = 0; k < COUNT_OF(lengths); k++) {
        const ctl_profile_params_t p = params(SPEED, ACCEL, lengths[k]);
        assert_refused(&p, CTL_ERR_RANGE, CTL_PROFILE_SMOOTH);
    }
}

void test_ctl_profile_init_rejects_scales_that_are_no_scales(void)
{
    for (size_t k = 0; k < COUNT_OF(NOT_FINITE) + 2U; k++) {
        const num_t bad = (k < COUNT_OF(NOT_FINITE)) ? NOT_FINITE[k] : ((k == COUNT_OF(NOT_FINITE)) ? (num_t)0 : num_of(-1.0));
        ctl_profile_params_t p = params(SPEED, ACCEL, 1U);
        p.speed_scale = bad;
        assert_refused(&p, CTL_ERR_RANGE, CTL_PROFILE_SCALE);
        p = params(SPEED, ACCEL, 1U);
        p.accel_scale = bad;
        assert_refused(&p, CTL_ERR_RANGE, CTL_PROFILE_SCALE);
    }
}

/* The mean of n equal steps ends (n - 1) / 2 steps behind, half a unit of it in the remainder: at rest nothing of that is left. */
void test_ctl_profile_tuned_in_a_motion_of_odd_steps_has_no_remainder_when_it_stands(void)
{
    static const uint16_t SMOOTH[] = {2U, 3U, 4U, 5U, 8U, 64U};
    for (size_t n = 0; n < COUNT_OF(SMOOTH); n++) {
        for (int way = -1; way <= 1; way += 2) {
            for (int64_t speed = 1001; speed <= 1003; speed++) {
                ctl_setpoint_t             s = {0};
                const ctl_position_t       target = (ctl_position_t)(way * 1234567);
                const ctl_profile_params_t other = params(speed, 50, SMOOTH[n]);
                start(speed, 50, 1U);
                for (int k = 0; k < 200; k++) {
                    s = ctl_profile_step(&profile, target);
                }
                TEST_ASSERT_EQUAL_INT64(way * speed, profile.state.last);
                TEST_ASSERT_EQUAL(CTL_OK, ctl_profile_tune(&profile, &other).status);
                for (int k = 0; (k < 3000) && !s.done; k++) {
                    s = ctl_profile_step(&profile, target);
                }
                TEST_ASSERT_TRUE(s.done);
                TEST_ASSERT_EQUAL_INT64(target, s.position);
                TEST_ASSERT_EQUAL_INT64_MESSAGE(0, profile.state.remainder, at("mean of %u, %d", (unsigned)SMOOTH[n], way));
            }
        }
    }
}

/* 2^16 samples and more on the way: what is counted up to the length of the mean stops there. */
void test_ctl_profile_keeps_its_speed_for_longer_than_sixteen_bits_count(void)
{
    start(1000, 100, 7U);
    for (int k = 0; k < 66000; k++) {
        const ctl_setpoint_t s = ctl_profile_step(&profile, 100000000);
        TEST_ASSERT_FALSE(s.done);
        TEST_ASSERT_TRUE((k < 50) || (profile.state.last == 1000));
    }
}

void test_ctl_profile_with_a_mean_of_none_that_nobody_has_checked_moves_as_with_one(void)
{
    ctl_profile_state_t        none, one;
    const ctl_profile_params_t without = params(SPEED, ACCEL, 0U), with = params(SPEED, ACCEL, 1U);
    memset(&none, 0, sizeof none);
    memset(&one, 0, sizeof one);
    ctl_profile_reset(&none, 0);
    ctl_profile_reset(&one, 0);
    for (int k = 0; k < 500; k++) {
        const ctl_position_t a = ctl_profile_step_unchecked(&without, &none, CTL_ONE_TURN).position;
        TEST_ASSERT_EQUAL_INT64(ctl_profile_step_unchecked(&with, &one, CTL_ONE_TURN).position, a);
    }
}
