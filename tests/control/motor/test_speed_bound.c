/* control/motor/speed_bound.c: torque as asked between two limits of a speed, on a shaft, without steps at either end. */
#include "control/motor/speed_bound.h"
#include "tests/support/numeric.h"

#define TS 1e-3
#define KP 0.5
#define KI_TS 0.005
#define ROOM 4.0

static const ctl_speed_bound_params_t *params(void)
{
    static ctl_speed_bound_params_t p;
    p = (ctl_speed_bound_params_t){num_of(KP), num_of(KI_TS), num_of(KI_TS / KP)};
    return &p;
}

static ctl_speed_bound_t bound;
static double            speed, out, last_out, largest_step;

void setUp(void)
{
    bound = (ctl_speed_bound_t){(num_t)0, 0U};
    speed = out = last_out = largest_step = 0.0;
}
void tearDown(void) {}

/* dw/dt = 20 (torque - load); a sample */
static void turn(double asked, double limit, double load)
{
    out = value_of(
        ctl_speed_bound_step(params(), &bound, num_of(asked), num_of(-limit - speed), num_of(limit - speed), num_of(ROOM)));
    speed += 20.0 * TS * (out - load);
    largest_step = fmax(largest_step, fabs(out - last_out));
    last_out = out;
}

void test_speed_bound_torque_far_from_the_limits_is_the_torque_asked_for(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        setUp();
        for (int k = 0; k < 50; k++) { /* to 2 of 20: 4 - 2 / 0.5 would be 18 */
            turn(2.0 * sign, 20.0, 0.0);
            ASSERT_NUM_WITHIN(per_numeric(1e-6, FIXED_STEP), 2.0 * sign, num_of(out));
        }
    }
}

/* PI with k = 20 on an integrator: damping k_p sqrt(k / k_i) / 2 = 0.5 sqrt(20 / 5) / 2 = 0.5, its step overshoots by 16 % at most
 * of what it covers, which here is the band k_p of 2 / 0.5 = 4 below the limit and no more */
void test_speed_bound_speed_comes_to_the_limit_in_either_direction_and_stays(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        setUp();
        double top = 0.0;
        for (int k = 0; k < 4000; k++) {
            turn(2.0 * sign, 10.0, 0.5 * sign);
            top = fmax(top, fabs(speed));
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 10.0 * sign, speed);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.5 * sign, out); /* what the load takes */
        TEST_ASSERT_TRUE_MESSAGE(top < 10.0 + 0.3 * 4.0, at("top %g", top));
    }
}

/* No step where the limit begins or ends to act: the steps are those of k_p times the change of speed in a sample, and of the integral
 * part: 0.5 20 1e-3 (2 + 3) and 0.005 4. */
void test_speed_bound_output_has_no_step_when_the_limit_begins_and_ends(void)
{
    turn(2.0, 10.0, 0.0);
    largest_step = 0.0;
    for (int k = 0; k < 8000; k++) {
        turn(2.0, 10.0, (k < 3000) ? 0.5 : ((k < 4500) ? 3.0 : 0.0)); /* into the limit, out of it by a load, into it again */
    }
    TEST_ASSERT_TRUE_MESSAGE(largest_step < 0.5 * 20.0 * TS * 5.0 + KI_TS * 4.0, at("step %g", largest_step));
    TEST_ASSERT_DOUBLE_WITHIN(1e-2, 10.0, speed);
    largest_step = 0.0;
    for (int k = 0; k < 3000; k++) { /* asked for less and less: out of the limit at the torque of the load, 0 */
        turn(2.0 - 0.001 * k, 10.0, 0.0);
    }
    TEST_ASSERT_TRUE_MESSAGE(largest_step < 0.5 * 20.0 * TS * 5.0 + KI_TS * 4.0, at("step %g", largest_step));
}

/* a load drives it beyond the limit with no torque asked for: it brakes */
void test_speed_bound_a_load_that_drives_is_held_at_the_limit(void)
{
    for (int k = 0; k < 6000; k++) {
        turn(0.0, 10.0, -2.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-2, 10.0, speed);
    TEST_ASSERT_DOUBLE_WITHIN(1e-2, -2.0, out);
}

/* a limit far away knows nothing of an old load: x is gone after some k_p / k_i */
void test_speed_bound_old_load_does_not_move_the_other_limit(void)
{
    for (int k = 0; k < 4000; k++) {
        turn(4.0, 10.0, 3.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 3.0, value_of(bound.x));
    speed = 0.0;
    for (int k = 0; k < 2000; k++) { /* 20 time constants */
        speed = 0.0;
        turn(1.0, 10.0, 0.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, value_of(bound.x));
}

void test_speed_bound_takes_any_input_and_stays_in_its_room(void)
{
    const float any[] = {0.0f, 1.0f, -1.0f, 100.0f, -100.0f, NAN, INFINITY, -INFINITY};
    uint32_t    noise = 1U;
    for (int k = 0; k < 20000; k++) {
        num_t in[3];
        for (int i = 0; i < 3; i++) {
            noise = (noise * 1664525U) + 1013904223U;
            in[i] = num_from_float(any[(noise >> 16) % 8U]);
        }
        const num_t o = ctl_speed_bound_step(params(), &bound, in[0], in[1], in[2], num_of(ROOM));
        TEST_ASSERT_TRUE(fabs(value_of(o)) <= ROOM + 1e-6);
        TEST_ASSERT_TRUE(fabs(value_of(bound.x)) <= ROOM + 1e-6);
    }
}

/* One step from an integral part, errors in the unit of the loop: x + k_p err are the bounds. */
static double step_from(double x, double asked, double err_low, double err_high)
{
    bound.x = num_of(x);
    return value_of(ctl_speed_bound_step(params(), &bound, num_of(asked), num_of(err_low), num_of(err_high), num_of(ROOM)));
}

static double tiny(void) { return per_numeric(1e-6, 2.0 * FIXED_STEP); }

void test_speed_bound_torque_that_just_reaches_the_bound_leaves_the_integral_part_at_rest(void)
{
    ASSERT_NUM_WITHIN(0.0, -2.0, num_of(step_from(0.0, -2.0, -4.0, 20.0)));
    ASSERT_NUM_WITHIN(0.0, 0.0, bound.x);
    ASSERT_NUM_WITHIN(0.0, 2.0, num_of(step_from(0.0, 2.0, -20.0, 4.0)));
    ASSERT_NUM_WITHIN(0.0, 0.0, bound.x);
}

/* 3.9 + 0.5 0.5 and -(0 + 0.5 20) lie beyond the room of 4 */
void test_speed_bound_integral_part_does_not_grow_where_the_room_is_the_limit(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        const double low = (sign > 0) ? 0.5 : -20.0, high = (sign > 0) ? 20.0 : -0.5;
        TEST_ASSERT_DOUBLE_WITHIN(tiny(), 4.0 * sign, step_from(3.9 * sign, -4.0 * sign, low, high));
        ASSERT_NUM_WITHIN(tiny(), 3.9 * sign, bound.x);
    }
    TEST_ASSERT_DOUBLE_WITHIN(tiny(), -4.0, step_from(0.0, 2.0, -40.0, -20.0));
    ASSERT_NUM_WITHIN(0.0, 0.0, bound.x);
    TEST_ASSERT_DOUBLE_WITHIN(tiny(), -1.0, step_from(1.0, 2.0, -40.0, -4.0)); /* within it, it does: 1 - 0.005 4 */
    ASSERT_NUM_WITHIN(tiny(), 0.98, bound.x);
}

/* 2 - 0.01 2 = 1.98 would leave 1.98 + 0.25 below the 2.245 that are asked for: 2.245 - 0.25 does not */
void test_speed_bound_integral_part_goes_back_no_further_than_the_torque_that_passes_now(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        const double low = (sign > 0) ? -20.0 : -0.5, high = (sign > 0) ? 0.5 : 20.0;
        TEST_ASSERT_DOUBLE_WITHIN(tiny(), 2.245 * sign, step_from(2.0 * sign, 2.245 * sign, low, high));
        ASSERT_NUM_WITHIN(tiny(), 1.995 * sign, bound.x);
        TEST_ASSERT_DOUBLE_WITHIN(tiny(), 1.0 * sign, step_from(2.0 * sign, 1.0 * sign, low, high));
        ASSERT_NUM_WITHIN(tiny(), 1.98 * sign, bound.x);
    }
}

/* No torque asked for, no distance to a limit: that is the cautious side. */
void test_speed_bound_takes_what_is_no_number_for_zero_and_counts_it(void)
{
    const ctl_speed_bound_params_t *const p = params();
    for (size_t k = 0; k < COUNT_OF(NOT_FINITE); k++) {
        setUp();
        const num_t bad = NOT_FINITE[k], far = num_of(20.0), near = num_neg(far), room = num_of(ROOM);
        ASSERT_NUM_WITHIN(0.0, 0.0, ctl_speed_bound_step(p, &bound, bad, near, far, room));
        TEST_ASSERT_EQUAL_UINT32(1U, bound.rejected);
        ASSERT_NUM_WITHIN(0.0, 0.0, ctl_speed_bound_step(p, &bound, num_of(2.0), near, bad, room));
        ASSERT_NUM_WITHIN(0.0, 0.0, bound.x);
        ASSERT_NUM_WITHIN(0.0, 0.0, ctl_speed_bound_step(p, &bound, num_of(-2.0), bad, far, room));
        ASSERT_NUM_WITHIN(0.0, 0.0, bound.x);
    }
}
