/* control/motor/mt_speed.c: speed from edges and their times, with every wrap, stop and reversal. */
#include "tests/support/numeric.h"

#include "control/motor/mt_speed.h"
#include "tests/control/golden/mt_speed.h"

#define SAMPLE UINT32_C(10000) /* cycles */

static ctl_mt_t mt;

/* Speed unit: counts per sample, so the numbers can be read. */
static ctl_mt_params_t valid_params(void)
{
    const ctl_mt_params_t p = {.sample_cyc = SAMPLE, .speed_1_count = num_of(1.0), .speed_max = num_of(50.0), .stop_samples = 4U};
    return p;
}

void setUp(void)
{
    const ctl_mt_params_t p = valid_params();
    TEST_ASSERT_EQUAL(CTL_OK, ctl_mt_init(&mt, &p).status);
}
void tearDown(void) {}

/* Float: three roundings. Fixed: the time in samples is cut to its step, the quotient, too; both times the speed. */
static double bound(double speed) { return per_numeric(3e-7 * fabs(speed), FIXED_STEP * (1.0 + 2.0 * speed * speed)); }

void test_ctl_mt_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_MT); i++) {
        const num_t w = ctl_mt_step(&mt, GOLDEN_MT[i].count, GOLDEN_MT[i].edge_cyc, GOLDEN_MT[i].now_cyc);

        ASSERT_NUM_WITHIN_AT(bound(GOLDEN_MT[i].speed), GOLDEN_MT[i].speed, w, at("row %u", (unsigned)i));
    }
}

/* Steady motion of `speed` counts per sample from a given count and clock; the worst error after the first two samples. */
static void assert_steady(double speed, int32_t count0, uint32_t clock0)
{
    setUp();
    for (int k = 1; k < 60; k++) {
        const double   position = 0.37 + (speed * k);
        const double   edge = (speed > 0.0) ? floor(position) : ceil(position);
        const uint32_t edge_cyc = clock0 + (uint32_t)llround((edge - 0.37) / speed * SAMPLE);
        const int32_t  count = (int32_t)((uint32_t)count0 + (uint32_t)(int32_t)edge);

        const num_t w = ctl_mt_step(&mt, count, edge_cyc, clock0 + ((uint32_t)k * SAMPLE));

        if (k >= 8) { /* edges are known by then at 0.3 counts per sample */
            /* the edge times are rounded to a cycle: up to one cycle in the distance of two edges */
            const double way = fmax(1.0, floor(fabs(speed)));
            const double timing = fabs(speed) * fabs(speed) / (way * SAMPLE);
            ASSERT_NUM_WITHIN_AT(bound(speed) + timing, speed, w, at("%g counts per sample, sample %d", speed, k));
        }
    }
}

void test_ctl_mt_at_constant_speed_has_no_quantisation_error(void)
{
    static const double SPEEDS[] = {0.3, -0.3, 0.99, 1.01, -1.7, 3.3, -12.34, 42.9, -42.9};
    for (size_t i = 0; i < COUNT_OF(SPEEDS); i++) {
        assert_steady(SPEEDS[i], 0, 0U);
    }
}

void test_ctl_mt_does_not_notice_the_wrap_of_the_clock(void)
{
    assert_steady(3.3, 0, UINT32_MAX - (20U * SAMPLE));
    assert_steady(-0.3, 0, UINT32_MAX - (20U * SAMPLE));
    assert_steady(3.3, 0, UINT32_C(0x7FFFFFFF) - (20U * SAMPLE));
}

void test_ctl_mt_does_not_notice_the_wrap_of_the_count(void)
{
    assert_steady(3.3, INT32_MAX - 30, 0U);
    assert_steady(-3.3, INT32_MIN + 30, 0U);
}

/* An encoder of 2^22 counts passes 32767 of them in a millisecond at 49 rad/s: a speed that stops there lets the motor run away. */
void test_ctl_mt_more_counts_than_16_bits_hold_are_the_speed_that_they_are(void)
{
    ctl_mt_params_t p = valid_params();
    p.speed_1_count = num_of(1.0 / 1024.0);
    p.speed_max = num_of(100.0);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_mt_init(&mt, &p).status);

    (void)ctl_mt_step(&mt, 0, SAMPLE, SAMPLE);
    ASSERT_NUM_WITHIN(bound(90.0), 90.0, ctl_mt_step(&mt, 92160, 2U * SAMPLE, 2U * SAMPLE));
    ASSERT_NUM_WITHIN(bound(90.0), -90.0, ctl_mt_step(&mt, 0, 3U * SAMPLE, 3U * SAMPLE));
    ASSERT_NUM_WITHIN(0.0, 100.0, ctl_mt_step(&mt, INT32_MAX, 4U * SAMPLE, 4U * SAMPLE));
    ASSERT_NUM_WITHIN(0.0, -100.0, ctl_mt_step(&mt, 0, 5U * SAMPLE, 5U * SAMPLE));
    ASSERT_NUM_WITHIN(0.0, -100.0, ctl_mt_step(&mt, INT32_MIN, 6U * SAMPLE, 6U * SAMPLE));
}

void test_ctl_mt_first_sample_has_no_speed_yet(void) { ASSERT_NUM_WITHIN(0.0, 0.0, ctl_mt_step(&mt, 1000, 5U, 100U)); }

void test_ctl_mt_at_a_reversal_over_one_edge_is_zero_then_follows(void)
{
    (void)ctl_mt_step(&mt, 10, 1000U, 10000U);
    (void)ctl_mt_step(&mt, 12, 17000U, 20000U);

    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_mt_step(&mt, 12, 23000U, 30000U)); /* the same edge, passed backwards */
    ASSERT_NUM_WITHIN(bound(2.0), -2.0, ctl_mt_step(&mt, 10, 33000U, 40000U));
}

void test_ctl_mt_without_an_edge_falls_with_the_time_since_the_last_one(void)
{
    (void)ctl_mt_step(&mt, 0, 0U, SAMPLE);
    ASSERT_NUM_WITHIN(bound(8.0), 8.0, ctl_mt_step(&mt, 16, 2U * SAMPLE, 2U * SAMPLE));

    ASSERT_NUM_WITHIN(bound(1.0), 1.0, ctl_mt_step(&mt, 16, 2U * SAMPLE, 3U * SAMPLE));
    ASSERT_NUM_WITHIN(bound(0.5), 0.5, ctl_mt_step(&mt, 16, 2U * SAMPLE, 4U * SAMPLE));
    ASSERT_NUM_WITHIN(bound(1.0 / 3.0), 1.0 / 3.0, ctl_mt_step(&mt, 16, 2U * SAMPLE, 5U * SAMPLE));
    ASSERT_NUM_WITHIN(bound(0.25), 0.25, ctl_mt_step(&mt, 16, 2U * SAMPLE, 6U * SAMPLE));
    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_mt_step(&mt, 16, 2U * SAMPLE, 7U * SAMPLE)); /* stop_samples = 4 are over */
    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_mt_step(&mt, 16, 2U * SAMPLE, 8U * SAMPLE));
}

void test_ctl_mt_without_an_edge_falls_backwards_too(void)
{
    (void)ctl_mt_step(&mt, 0, 0U, SAMPLE);
    ASSERT_NUM_WITHIN(bound(8.0), -8.0, ctl_mt_step(&mt, -16, 2U * SAMPLE, 2U * SAMPLE));

    ASSERT_NUM_WITHIN(bound(1.0), -1.0, ctl_mt_step(&mt, -16, 2U * SAMPLE, 3U * SAMPLE));
}

void test_ctl_mt_between_edges_of_a_slow_motion_keeps_the_speed(void)
{
    (void)ctl_mt_step(&mt, 0, 0U, SAMPLE);
    (void)ctl_mt_step(&mt, 1, 25000U, 30000U); /* 0.4 counts per sample */

    ASSERT_NUM_WITHIN(bound(0.4), 0.4, ctl_mt_step(&mt, 1, 25000U, 40000U));
    ASSERT_NUM_WITHIN(bound(0.4), 0.4, ctl_mt_step(&mt, 1, 25000U, 50000U)); /* 2.5 samples since the edge */
}

void test_ctl_mt_after_a_stop_longer_than_the_clock_starts_without_a_spike(void)
{
    uint32_t now = 0U;
    (void)ctl_mt_step(&mt, 0, 0U, SAMPLE);
    (void)ctl_mt_step(&mt, 4, 2U * SAMPLE, 2U * SAMPLE);
    for (int k = 3; k < 20; k++) {
        now = (uint32_t)k * SAMPLE;
        (void)ctl_mt_step(&mt, 4, 2U * SAMPLE, now);
    }

    /* 2^32 cycles and a bit later the shaft moves by one count: the clock alone would say 100 cycles */
    const num_t first = ctl_mt_step(&mt, 5, (2U * SAMPLE) + 100U, (2U * SAMPLE) + 200U);
    const num_t second = ctl_mt_step(&mt, 7, (3U * SAMPLE) + 100U, (3U * SAMPLE) + 200U);

    ASSERT_NUM_WITHIN(0.0, 0.0, first);
    ASSERT_NUM_WITHIN(bound(2.0), 2.0, second);
}

void test_ctl_mt_never_exceeds_its_limit(void)
{
    (void)ctl_mt_step(&mt, 0, 0U, SAMPLE);

    ASSERT_NUM_WITHIN(0.0, 50.0, ctl_mt_step(&mt, 1000, SAMPLE, 2U * SAMPLE));
    ASSERT_NUM_WITHIN(0.0, -50.0, ctl_mt_step(&mt, -2000000000, 2U * SAMPLE, 3U * SAMPLE));
    ASSERT_NUM_WITHIN(0.0, 50.0, ctl_mt_step(&mt, 100, (2U * SAMPLE) + 1U, 4U * SAMPLE)); /* next edge a cycle later */
}

void test_ctl_mt_edge_at_the_very_time_of_the_sample_is_no_division_by_zero(void)
{
    (void)ctl_mt_step(&mt, 0, 0U, SAMPLE);
    (void)ctl_mt_step(&mt, 3, 2U * SAMPLE, 2U * SAMPLE);

    ASSERT_NUM_WITHIN(bound(1.5), 1.5, ctl_mt_step(&mt, 3, 2U * SAMPLE, 2U * SAMPLE));
}

void test_ctl_mt_same_count_in_no_time_is_standstill_however_long_the_sample(void)
{
    ctl_mt_params_t p = valid_params();
    p.sample_cyc = UINT32_MAX;
    TEST_ASSERT_EQUAL(CTL_OK, ctl_mt_init(&mt, &p).status);
    (void)ctl_mt_step(&mt, 7, 100U, 200U);

    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_mt_step(&mt, 7, 101U, 300U));
}

void test_ctl_mt_reset_forgets_the_last_edge(void)
{
    (void)ctl_mt_step(&mt, 0, 0U, SAMPLE);
    (void)ctl_mt_step(&mt, 5, SAMPLE, 2U * SAMPLE);

    ctl_mt_reset(&mt);

    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_mt_step(&mt, 9, 2U * SAMPLE, 3U * SAMPLE));
    ASSERT_NUM_WITHIN(bound(1.0), 1.0, ctl_mt_step(&mt, 10, 3U * SAMPLE, 4U * SAMPLE));
}

void test_ctl_mt_fed_with_anything_stays_within_its_limit(void)
{
    noise_t noise = {71U};
    for (uint32_t k = 0; k < 10000U; k++) {
        const int32_t  count = (int32_t)(noise_bits(&noise) >> noise_pick(&noise, 32U));
        const uint32_t edge = noise_bits(&noise) >> noise_pick(&noise, 32U);
        const uint32_t now = noise_bits(&noise);

        ASSERT_BOUNDED_AT(50.0, ctl_mt_step(&mt, count, edge, now), at("sample %u", k));
    }
}

void test_ctl_mt_with_the_largest_parameters_stays_within_its_limit(void)
{
    const ctl_mt_params_t p = {UINT32_MAX, NUM_MAX, NUM_MAX, UINT16_MAX};
    noise_t               noise = {72U};
    TEST_ASSERT_EQUAL(CTL_OK, ctl_mt_init(&mt, &p).status);
    for (uint32_t k = 0; k < 3000U; k++) {
        ASSERT_BOUNDED_AT(num_max_value(), ctl_mt_step(&mt, (int32_t)noise_bits(&noise), noise_bits(&noise), noise_bits(&noise)),
                          at("sample %u", k));
    }
}

/* ---- configuration ---------------------------------------------------------------------------------------------------------- */

static void assert_rejected(const ctl_mt_params_t *p, ctl_status_t status, uint16_t field, num_t given)
{
    (void)ctl_mt_step(&mt, 3, 4U, 5U);
    const ctl_mt_t before = mt;

    const ctl_diag_t got = ctl_mt_init(&mt, p);

    TEST_ASSERT_EQUAL(status, got.status);
    TEST_ASSERT_EQUAL_UINT16(field, got.field);
    ASSERT_SAME_BITS(given, got.given);
    ASSERT_SAME_BITS(before, mt);
}

void test_ctl_mt_init_rejects_a_sample_time_of_zero(void)
{
    ctl_mt_params_t p = valid_params();
    p.sample_cyc = 0U;

    assert_rejected(&p, CTL_ERR_RANGE, CTL_MT_SAMPLE, (num_t)0);
}

void test_ctl_mt_init_rejects_no_samples_to_standstill(void)
{
    ctl_mt_params_t p = valid_params();
    p.stop_samples = 0U;

    assert_rejected(&p, CTL_ERR_RANGE, CTL_MT_STOP, (num_t)0);
}

static void assert_speed_rejected(num_t value)
{
    ctl_mt_params_t p = valid_params();
    p.speed_1_count = value;
    assert_rejected(&p, CTL_ERR_RANGE, CTL_MT_SPEED_1_COUNT, value);
    p = valid_params();
    p.speed_max = value;
    assert_rejected(&p, CTL_ERR_RANGE, CTL_MT_SPEED_MAX, value);
}

void test_ctl_mt_init_rejects_speeds_that_are_not_positive_or_not_finite(void)
{
    assert_speed_rejected((num_t)0);
    assert_speed_rejected(num_of(-1.0));
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        assert_speed_rejected(NOT_FINITE[i]);
    }
}

void test_ctl_mt_init_without_a_pointer_says_so(void)
{
    const ctl_mt_params_t p = valid_params();

    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_mt_init(NULL, &p));
    assert_rejected(NULL, CTL_ERR_NULL, 0U, (num_t)0);
}
