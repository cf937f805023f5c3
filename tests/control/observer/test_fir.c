/* control/observer/fir.c: taps of a windowed ideal low-pass, a delay that is half the order for every signal. */
#include "tests/support/numeric.h"

#include "control/observer/fir_cascade.h"
#include "tests/control/golden/fir.h"

static ctl_fir_t         fir;
static ctl_fir_cascade_t cascade;

static ctl_fir_params_t designed(uint16_t order, double cutoff)
{
    ctl_fir_params_t p;
    TEST_ASSERT_EQUAL(CTL_OK, ctl_fir_design(&p, order, num_of(cutoff)).status);
    return p;
}

/* 1 2 3 2 1 over 16: exact in both numerics, and no two shifts of it look alike. */
static ctl_fir_params_t valid_params(void)
{
    const ctl_fir_params_t p = {.order = 4U,
                                .tap = {num_of(0.0625), num_of(0.125), num_of(0.1875), num_of(0.125), num_of(0.0625)}};
    return p;
}

static void start(const ctl_fir_params_t *p) { TEST_ASSERT_EQUAL(CTL_OK, ctl_fir_init(&fir, p).status); }

static double step(double x) { return value_of(ctl_fir_step(&fir, num_of(x))); }

void setUp(void)
{
    const ctl_fir_params_t p = valid_params();
    start(&p);
}
void tearDown(void) {}

/* ---- two filters in one --------------------------------------------------------------------------------------------- */

void test_ctl_fir_cascade_is_two_filters_one_after_the_other_times_the_gain(void)
{
    for (uint16_t first = 0; first <= CTL_FIR_ORDER_MAX; first++) {
        for (uint16_t second = 0; second <= CTL_FIR_ORDER_MAX; second++) {
            const ctl_fir_params_t a = designed(first, 0.1);
            const ctl_fir_params_t b = designed(second, 0.23);
            ctl_fir_t              one, other;
            noise_t                noise = {first + (16U * second) + 1U};
            start(&a);
            one = fir;
            start(&b);
            other = fir;
            ctl_fir_cascade_tune(&cascade, &a, &b, num_of(16.0));
            ctl_fir_cascade_reset(&cascade, (num_t)0);

            TEST_ASSERT_EQUAL_UINT16(first + second, cascade.order);
            for (int k = 0; k < 80; k++) {
                const num_t  x = num_of(0.2 * noise_next(&noise));
                const double want = 16.0 * value_of(ctl_fir_step(&other, ctl_fir_step(&one, x)));
                /* 0.2 times 16: float to 2^-24 of that in some ten sums; fixed: half a step a sum, the first ones times 16 */
                ASSERT_NUM_WITHIN_AT(per_numeric(3e-6, 3e-5), want, ctl_fir_cascade_step_unchecked(&cascade, x),
                                     at("orders %u and %u, sample %d", first, second, k));
            }
        }
    }
}

/* ---- design --------------------------------------------------------------------------------------------------------- */

/* Sine and cosine are good to 1.2e-7 and 2.5e-7; measured 6.6e-8 and 1.8e-7. */
#define TAP_BOUND per_numeric(1.2e-7, 3e-7)

void test_ctl_fir_design_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_FIR); i++) {
        const golden_fir_t *const g = &GOLDEN_FIR[i];
        const ctl_fir_params_t    p = designed(g->order, g->cutoff);

        TEST_ASSERT_EQUAL_UINT16(g->order, p.order);
        for (uint16_t k = 0; k <= CTL_FIR_ORDER_MAX; k++) {
            ASSERT_NUM_WITHIN_AT(TAP_BOUND, (k <= g->order) ? g->tap[k] : 0.0, p.tap[k],
                                 at("order %u, corner %g, tap %u", g->order, g->cutoff, k));
        }
    }
}

void test_ctl_fir_design_of_every_order_and_corner_is_symmetric_has_unity_gain_and_is_accepted(void)
{
    static const double CUTOFFS[] = {0.0001, 0.0003, 0.001, 0.0033, 0.01, 0.05, 0.1, 0.123, 0.25, 0.3, 0.4, 0.49, 0.4999};
    for (uint16_t order = 0; order <= CTL_FIR_ORDER_MAX; order++) {
        for (size_t c = 0; c < COUNT_OF(CUTOFFS); c++) {
            const char *const      text = at("order %u, corner %g", order, CUTOFFS[c]);
            const ctl_fir_params_t p = designed(order, CUTOFFS[c]);
            double                 sum = 0.0;
            for (uint16_t k = 0; k <= order; k++) {
                sum += value_of(p.tap[k]);
                ASSERT_NUM_WITHIN_AT(2.5e-7, value_of(p.tap[order - k]), p.tap[k], text); /* what init accepts */
            }

            /* each tap is rounded once more when it is divided by their sum */
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(per_numeric(5e-7, (order + 1.0) * FIXED_STEP), 1.0, sum, text);
            TEST_ASSERT_EQUAL_MESSAGE(CTL_OK, ctl_fir_init(&fir, &p).status, text);
        }
    }
}

void test_ctl_fir_design_passes_below_and_stops_above_the_corner(void)
{
    const ctl_fir_params_t p = designed(15U, 0.1);
    static const struct {
        double frequency, least, most;
    } BANDS[] = {{0.0, 0.999999, 1.000001}, {0.02, 0.96, 1.0}, {0.1, 0.4, 0.6}, {0.25, 0.0, 0.005}, {0.4, 0.0, 0.005}};
    for (size_t i = 0; i < COUNT_OF(BANDS); i++) {
        double gain = 0.0;
        for (uint16_t k = 0; k <= p.order; k++) {
            gain += value_of(p.tap[k]) * cos(TWO_PI * BANDS[i].frequency * (k - (p.order / 2.0)));
        }

        TEST_ASSERT_TRUE_MESSAGE((fabs(gain) >= BANDS[i].least) && (fabs(gain) <= BANDS[i].most),
                                 at("gain %g at %g", gain, BANDS[i].frequency));
    }
}

static void assert_not_designed(uint16_t order, num_t cutoff, uint16_t field)
{
    const ctl_fir_params_t before = valid_params();
    ctl_fir_params_t       p = before;

    const ctl_diag_t got = ctl_fir_design(&p, order, cutoff);

    TEST_ASSERT_EQUAL(CTL_ERR_RANGE, got.status);
    TEST_ASSERT_EQUAL_UINT16(field, got.field);
    ASSERT_SAME_BITS(before, p);
}

void test_ctl_fir_design_rejects_an_order_beyond_its_room(void)
{
    assert_not_designed(CTL_FIR_ORDER_MAX + 1U, num_of(0.1), CTL_FIR_ORDER);
    assert_not_designed(UINT16_MAX, num_of(0.1), CTL_FIR_ORDER);
}

void test_ctl_fir_design_rejects_a_corner_outside_of_its_range(void)
{
    static const double WRONG[] = {0.0, 0.00009, 0.5, 0.7, -0.1};
    for (size_t i = 0; i < COUNT_OF(WRONG); i++) {
        assert_not_designed(4U, num_of(WRONG[i]), CTL_FIR_CUTOFF);
    }
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        assert_not_designed(4U, NOT_FINITE[i], CTL_FIR_CUTOFF);
    }
}

void test_ctl_fir_design_without_a_pointer_says_so(void)
{
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_fir_design(NULL, 4U, num_of(0.1)));
}

/* ---- filtering ------------------------------------------------------------------------------------------------------- */

void test_ctl_fir_answers_an_impulse_with_its_taps(void)
{
    static const double TAPS[] = {0.0625, 0.125, 0.1875, 0.125, 0.0625, 0.0, 0.0};
    for (size_t k = 0; k < COUNT_OF(TAPS); k++) {
        TEST_ASSERT_EQUAL_DOUBLE(TAPS[k], step((k == 0U) ? 1.0 : 0.0));
    }
}

void test_ctl_fir_of_order_0_is_a_gain_without_delay(void)
{
    const ctl_fir_params_t p = {.order = 0U, .tap = {num_of(-1.5)}};
    start(&p);

    TEST_ASSERT_EQUAL_DOUBLE(-3.0, step(2.0));
    TEST_ASSERT_EQUAL_DOUBLE(0.75, step(-0.5));
    TEST_ASSERT_EQUAL_UINT16(0U, ctl_fir_delay_half(&p));
}

void test_ctl_fir_agrees_with_the_sum_of_the_equation(void)
{
    noise_t noise = {51U};
    for (uint16_t order = 0; order <= CTL_FIR_ORDER_MAX; order++) {
        const ctl_fir_params_t p = designed(order, 0.15);
        double                 past[CTL_FIR_ORDER_MAX + 1U] = {0.0};
        start(&p);
        for (int k = 0; k < 200; k++) {
            double want = 0.0;
            memmove(&past[1], &past[0], sizeof past - sizeof past[0]);
            past[0] = 8.0 * noise_next(&noise);
            for (uint16_t i = 0; i <= order; i++) {
                want += value_of(p.tap[i]) * past[i];
            }

            /* header: fixed within (n + 1) steps; float rounds each of up to 8 sums of size 4 */
            ASSERT_DOUBLE_WITHIN_AT(per_numeric(3e-6, (order + 1.0) * FIXED_STEP) + (4.0 * 2.5e-7), want, step(past[0]),
                                    at("order %u, sample %d", order, k));
        }
    }
}

void test_ctl_fir_delays_a_ramp_by_half_its_order(void)
{
    for (uint16_t order = 0; order <= CTL_FIR_ORDER_MAX; order++) {
        const ctl_fir_params_t p = designed(order, 0.1);
        start(&p);
        for (int k = 0; k < 60; k++) {
            const double y = step(0.125 * k);
            if (k >= order) { /* full of ramp */
                /* sum of taps within 5e-7 of 1 (float), n steps (fixed), times a ramp of up to 7.5 */
                ASSERT_DOUBLE_WITHIN_AT(per_numeric(8e-6, 8.0 * (order + 1.0) * FIXED_STEP),
                                        0.125 * (k - (ctl_fir_delay_half(&p) / 2.0)), y, at("order %u, sample %d", order, k));
            }
        }
    }
}

/* Delay in samples of a sine of that many cycles per sample, from the correlation with sine and cosine. */
static double delay_of_sine(double frequency, double *gain)
{
    const int periods = 2000; /* a whole number of cycles of the frequencies asked for */
    double    in_phase = 0.0;
    double    in_quadrature = 0.0;
    for (int k = -50; k < periods; k++) {
        const double phase = TWO_PI * frequency * k;
        const double y = step(2.0 * sin(phase));
        if (k >= 0) {
            in_phase += y * sin(phase) / periods;
            in_quadrature += y * cos(phase) / periods;
        }
    }
    *gain = hypot(in_phase, in_quadrature);
    return -atan2(in_quadrature, in_phase) / (TWO_PI * frequency);
}

void test_ctl_fir_delays_every_sine_by_what_it_declares(void)
{
    static const double FREQUENCIES[] = {0.0005, 0.004, 0.02, 0.05};
    for (uint16_t order = 0; order <= CTL_FIR_ORDER_MAX; order++) {
        const ctl_fir_params_t p = designed(order, 0.1);
        for (size_t f = 0; f < COUNT_OF(FREQUENCIES); f++) {
            /* a phase of more than half a cycle cannot be distinguished from one of less */
            if ((order / 2.0 * FREQUENCIES[f]) < 0.5) {
                double gain = 0.0;
                start(&p);
                /* the rounding of an output of size 1, averaged, over the slope of the sine */
                ASSERT_DOUBLE_WITHIN_AT(1e-7 / FREQUENCIES[f], ctl_fir_delay_half(&p) / 2.0, delay_of_sine(FREQUENCIES[f], &gain),
                                        at("order %u, frequency %g", order, FREQUENCIES[f]));
                TEST_ASSERT_TRUE(gain > 0.5);
            }
        }
    }
}

void test_ctl_fir_fresh_gives_zero_and_reset_starts_in_a_steady_state(void)
{
    TEST_ASSERT_EQUAL_DOUBLE(0.0, step(0.0));
    (void)step(50.0);

    ctl_fir_reset(&fir, num_of(3.0));

    TEST_ASSERT_EQUAL_DOUBLE(3.0 * 0.5625, step(3.0)); /* the taps of this filter sum to 9/16 */
}

/* ---- what is not a number ---------------------------------------------------------------------------------------------- */

void test_ctl_fir_input_that_is_not_finite_counts_as_the_one_before_it(void)
{
    ctl_fir_t twin = fir;
    noise_t   noise = {52U};
    double    last = 0.0;
    uint32_t  wrong = 0U;
    for (int k = 0; k < 100; k++) {
        const bool is_wrong = (k % 7) == 3;
        last = is_wrong ? last : (4.0 * noise_next(&noise));
        const num_t given = is_wrong ? NOT_FINITE[(size_t)k % COUNT_OF(NOT_FINITE)] : num_of(last);
        wrong += is_wrong ? 1U : 0U;

        ASSERT_NUM_WITHIN(0.0, value_of(ctl_fir_step(&twin, num_of(last))), ctl_fir_step(&fir, given));
    }
    TEST_ASSERT_EQUAL_UINT32(wrong, fir.state.rejected);
    TEST_ASSERT_EQUAL_UINT32(0U, twin.state.rejected);
}

void test_ctl_fir_counter_stops_at_its_end(void)
{
    fir.state.rejected = UINT32_MAX - 1U;

    (void)ctl_fir_step(&fir, NOT_FINITE[0]);
    (void)ctl_fir_step(&fir, NOT_FINITE[0]);

    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, fir.state.rejected);
}

void test_ctl_fir_reset_to_what_is_not_finite_is_zero_and_counted(void)
{
    (void)step(5.0);

    ctl_fir_reset(&fir, NOT_FINITE[0]);

    TEST_ASSERT_EQUAL_UINT32(1U, fir.state.rejected);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, step(0.0));
}

void test_ctl_fir_output_stays_below_the_sum_of_tap_sizes_whatever_comes(void)
{
    const ctl_fir_params_t p = designed(9U, 0.1);
    noise_t                noise = {53U};
    double                 size = 0.0;
    for (uint16_t k = 0; k <= p.order; k++) {
        size += fabs(value_of(p.tap[k]));
    }
    start(&p);
    for (int k = 0; k < 3000; k++) {
        ASSERT_BOUNDED_AT(1.00001 * size * num_max_value(), ctl_fir_step(&fir, noise_nasty(&noise)), at("sample %d", k));
    }
}

/* ---- configuration ----------------------------------------------------------------------------------------------------- */

static void assert_rejected(const ctl_fir_params_t *p, ctl_status_t status, uint16_t field)
{
    (void)step(1.0);
    const ctl_fir_t  before = fir;
    const ctl_diag_t got = ctl_fir_init(&fir, p);

    TEST_ASSERT_EQUAL(status, got.status);
    TEST_ASSERT_EQUAL_UINT16(field, got.field);
    ASSERT_SAME_BITS(before, fir);
}

void test_ctl_fir_init_rejects_asymmetric_taps(void)
{
    for (uint16_t k = 0; k <= 4U; k++) {
        if (k != 2U) { /* the middle has no partner */
            for (double off = -1e-6; off < 1e-6; off += 1.9e-6) {
                ctl_fir_params_t p = valid_params();
                p.tap[k] = num_add(p.tap[k], num_of(off));
                assert_rejected(&p, CTL_ERR_RANGE, CTL_FIR_TAP);
            }
        }
    }
}

void test_ctl_fir_init_forgives_the_rounding_of_a_design(void)
{
    ctl_fir_params_t p = valid_params();
    p.tap[0] = num_add(p.tap[0], num_of(4.0 * FIXED_STEP));

    TEST_ASSERT_EQUAL(CTL_OK, ctl_fir_init(&fir, &p).status);

    p.tap[0] = num_add(valid_params().tap[0], num_of(per_numeric(2.6e-7, 5.0 * FIXED_STEP)));
    assert_rejected(&p, CTL_ERR_RANGE, CTL_FIR_TAP);
}

void test_ctl_fir_init_rejects_taps_that_are_not_finite(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        ctl_fir_params_t p = valid_params();
        p.tap[1] = NOT_FINITE[i];
        p.tap[3] = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_FIR_TAP);
        p = valid_params();
        p.tap[2] = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_FIR_TAP);
    }
}

void test_ctl_fir_init_rejects_taps_whose_sizes_sum_to_more_than_4(void)
{
    ctl_fir_params_t p = {.order = 2U, .tap = {num_of(-1.0), num_of(2.0), num_of(-1.0)}};
    TEST_ASSERT_EQUAL(CTL_OK, ctl_fir_init(&fir, &p).status);

    p.tap[1] = num_of(2.001);

    assert_rejected(&p, CTL_ERR_RANGE, CTL_FIR_TAP);
}

void test_ctl_fir_init_rejects_an_order_beyond_its_room(void)
{
    ctl_fir_params_t p = valid_params();
    p.order = CTL_FIR_ORDER_MAX + 1U;
    assert_rejected(&p, CTL_ERR_RANGE, CTL_FIR_ORDER);
    p.order = UINT16_MAX;
    assert_rejected(&p, CTL_ERR_RANGE, CTL_FIR_ORDER);
}

void test_ctl_fir_init_without_a_pointer_says_so(void)
{
    const ctl_fir_params_t p = valid_params();

    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_fir_init(NULL, &p));
    assert_rejected(NULL, CTL_ERR_NULL, 0U);
}

void test_ctl_fir_init_starts_from_zero_and_clears_the_counter(void)
{
    (void)step(9.0);
    (void)ctl_fir_step(&fir, NOT_FINITE[0]);

    const ctl_fir_params_t p = valid_params();
    start(&p);

    TEST_ASSERT_EQUAL_UINT32(0U, fir.state.rejected);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, step(0.0));
}

/* ---- other taps ------------------------------------------------------------------------------------------------------------- */

void test_ctl_fir_tune_changes_the_taps_without_a_break_in_the_samples(void)
{
    const ctl_fir_params_t p = valid_params();
    ctl_fir_params_t       other = p;
    other.order = 1U;
    other.tap[0] = other.tap[1] = num_of(0.5);
    (void)step(2.0);
    (void)step(6.0);

    ctl_fir_tune(&fir, &other);

    TEST_ASSERT_EQUAL_DOUBLE(0.5 * (6.0 + 10.0), step(10.0));
    ctl_fir_tune(&fir, &p);
    TEST_ASSERT_EQUAL_DOUBLE((1.0 * 4.0 + 2.0 * 10.0 + 3.0 * 6.0 + 2.0 * 2.0) / 16.0, step(4.0));
}

void test_ctl_fir_design_leaves_no_tap_of_another_filter_behind_its_order(void)
{
    ctl_fir_params_t p;
    memset(&p, 0x3F, sizeof p);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_fir_design(&p, 4U, num_of(0.1)).status);
    for (uint16_t i = 5U; i <= CTL_FIR_ORDER_MAX; i++) {
        ASSERT_NUM_WITHIN_AT(0.0, 0.0, p.tap[i], at("tap %u", (unsigned)i));
    }
}

void test_ctl_fir_without_a_pointer_is_null(void)
{
    ctl_fir_params_t p;
    ctl_fir_t        one;
    TEST_ASSERT_EQUAL(CTL_OK, ctl_fir_design(&p, 4U, num_of(0.1)).status);
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_fir_init(NULL, &p));
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_fir_init(&one, NULL));
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_fir_design(NULL, 4U, num_of(0.1)));
}
