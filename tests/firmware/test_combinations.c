/* firmware/app/combinations.def: what does not go together is refused by name, and by the name of what it does not go with; its
 * neighbours are accepted. */
#include "firmware/app/combinations.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

void setUp(void) { bench_start(); }
void tearDown(void) {}

/* Sets by hand: method, disturbance_observer, position_method, rdc_learn_gain, rc_freeze_above_unit, rc_memory; then who is named. */
typedef struct {
    uint16_t method, observer, position;
    float    learn, freeze;
    uint16_t memory;
    int      param, other; /* -1: accepted */
} set_t;

#define FINE -1, -1
static const set_t SETS[] = {
    {DRIVE_METHOD_PI, 0U, DRIVE_POSITION_PPI, 0.0f, 0.0f, CTL_RC_KEEP, FINE},
    {DRIVE_METHOD_PI, 3U, DRIVE_POSITION_PPI, 0.0f, 0.0f, CTL_RC_KEEP, FINE},
    {DRIVE_METHOD_FAL_FORC, 1U, DRIVE_POSITION_PPI, 0.0f, 0.0f, CTL_RC_KEEP, FINE},
    {DRIVE_METHOD_FORC, 2U, DRIVE_POSITION_PPI, 0.0f, 0.0f, CTL_RC_CLEAR, FINE},
    {DRIVE_METHOD_CRC, 3U, DRIVE_POSITION_PPI, 0.0f, 0.0f, CTL_RC_ANGLE, FINE},
    /* two words for one observer */
    {DRIVE_METHOD_DOB, 1U, DRIVE_POSITION_PPI, 0.0f, 0.0f, CTL_RC_KEEP, PARAM_disturbance_observer, PARAM_method},
    {DRIVE_METHOD_ARO, 1U, DRIVE_POSITION_PPI, 0.0f, 0.0f, CTL_RC_KEEP, PARAM_disturbance_observer, PARAM_method},
    /* a freeze that would not end */
    {DRIVE_METHOD_FORC, 0U, DRIVE_POSITION_PPI, 0.0f, 10.0f, CTL_RC_ANGLE, FINE},
    {DRIVE_METHOD_FORC, 0U, DRIVE_POSITION_PPI, 0.0f, 10.0f, CTL_RC_KEEP, PARAM_rc_freeze_above_unit, PARAM_rc_memory},
    {DRIVE_METHOD_FAL_FORC, 0U, DRIVE_POSITION_PPI, 0.0f, 10.0f, CTL_RC_CLEAR, PARAM_rc_freeze_above_unit, PARAM_rc_memory},
    {DRIVE_METHOD_PI, 0U, DRIVE_POSITION_PPI, 0.0f, 10.0f, CTL_RC_KEEP, FINE}, /* nothing that learns: a stored value may stay */
    /* one memory */
    {DRIVE_METHOD_RO, 0U, DRIVE_POSITION_SILC, 0.0f, 0.0f, CTL_RC_KEEP, PARAM_position_method, PARAM_method},
    {DRIVE_METHOD_PI, 2U, DRIVE_POSITION_SRC, 0.0f, 0.0f, CTL_RC_KEEP, PARAM_position_method, PARAM_disturbance_observer},
    {DRIVE_METHOD_ARO, 0U, DRIVE_POSITION_SRC, 0.0f, 0.0f, CTL_RC_KEEP, FINE},
    /* two that learn against each other */
    {DRIVE_METHOD_DOB, 0U, DRIVE_POSITION_SILC, 0.0f, 0.0f, CTL_RC_KEEP, PARAM_position_method, PARAM_method},
    {DRIVE_METHOD_PI, 3U, DRIVE_POSITION_SILC, 0.0f, 0.0f, CTL_RC_KEEP, PARAM_position_method, PARAM_disturbance_observer},
    {DRIVE_METHOD_PI, 0U, DRIVE_POSITION_SILC, 0.0f, 0.0f, CTL_RC_KEEP, FINE},
    {DRIVE_METHOD_PI, 1U, DRIVE_POSITION_SRC, 0.0f, 0.0f, CTL_RC_KEEP, FINE},
    /* two learners of one torque */
    {DRIVE_METHOD_ARO, 0U, DRIVE_POSITION_RDC, 0.3f, 0.0f, CTL_RC_KEEP, PARAM_rdc_learn_gain, PARAM_method},
    {DRIVE_METHOD_PI, 2U, DRIVE_POSITION_RDC, 0.3f, 0.0f, CTL_RC_KEEP, PARAM_rdc_learn_gain, PARAM_disturbance_observer},
    {DRIVE_METHOD_ARO, 0U, DRIVE_POSITION_RDC, 0.0f, 0.0f, CTL_RC_KEEP, FINE},
    {DRIVE_METHOD_DOB, 0U, DRIVE_POSITION_RDC, 0.3f, 0.0f, CTL_RC_KEEP, FINE},
    {DRIVE_METHOD_PI, 0U, DRIVE_POSITION_RDC, 0.3f, 0.0f, CTL_RC_KEEP, FINE},
};

static const char *name(uint16_t param) { return params_info(param)->name; }

static void assert_answer(const drive_params_t *p, int param, int other, const char *what)
{
    drive_init(&drive, p);
    const combination_info_t *const broken = combinations_info(combinations_broken(p));
    if (param < 0) {
        TEST_ASSERT_EQUAL_STRING_MESSAGE("none", faults_info((uint16_t)drive.fault)->name, what);
        TEST_ASSERT_NULL_MESSAGE(broken, what);
        return;
    }
    ASSERT_FAULT(FAULT_configuration, what);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(name((uint16_t)param), name(drive.fault_detail), what);
    TEST_ASSERT_NOT_NULL_MESSAGE(broken, what);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(name((uint16_t)param), name(broken->param), what);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(name((uint16_t)other), name(broken->other), what);
    TEST_ASSERT_TRUE_MESSAGE(strlen(broken->why) > 20U, what);
}

/* sqrt(3) 4 6.4e-3 Wb 650 rad/s = 28.8 V */
void test_combinations_field_weakening_needs_a_d_current_and_a_dc_link_that_withstands_the_motor(void)
{
    drive_params_t p;
    params_default(&p);
    p.field_weakening = 1U;
    p.over_voltage_v = 28.7f;
    assert_answer(&p, PARAM_over_speed_rad_s, PARAM_link_withstand_v, "28.7 V");
    p.over_voltage_v = 28.9f;
    assert_answer(&p, FINE, "28.9 V");
    p.link_withstand_v = 28.7f;
    assert_answer(&p, PARAM_over_speed_rad_s, PARAM_link_withstand_v, "withstands 28.7 V");
    p.link_withstand_v = 28.9f;
    p.over_voltage_v = 20.0f;
    assert_answer(&p, FINE, "withstands 28.9 V");
    p.id_limit_a = 0.0f;
    assert_answer(&p, PARAM_field_weakening, PARAM_id_limit_a, "no d current");
    p.field_weakening = 0U;
    assert_answer(&p, FINE, "off");
}

void test_combinations_are_accepted_or_refused_with_both_names(void)
{
    for (size_t k = 0; k < COUNT_OF(SETS); k++) {
        const set_t *const s = &SETS[k];
        setUp();
        drive_params_t p;
        params_default(&p);
        p.method = s->method;
        p.disturbance_observer = s->observer;
        p.position_method = s->position;
        p.rdc_learn_gain = s->learn;
        p.rc_freeze_above_unit = s->freeze;
        p.rc_memory = s->memory;
        assert_answer(&p, s->param, s->other, at("set %u", (unsigned)k));
    }
}

void test_combinations_set_point_weight_without_integral_part_is_refused(void)
{
    drive_params_t p;
    params_default(&p);
    p.speed_ki_a_per_unit_s = 0.0f;
    assert_answer(&p, -1, -1, "no integral part");
    p.speed_setpoint_weight = 0.9f;
    assert_answer(&p, PARAM_speed_setpoint_weight, PARAM_speed_ki_a_per_unit_s, "the rest of the reference would never come");
}

/* ki / kp = 25 / s: a corner of 4 Hz; 1 kHz / 2 = 500 Hz */
void test_combinations_notch_between_the_speed_controllers_corner_and_half_the_rate_of_its_loop(void)
{
    drive_params_t p;
    params_default(&p);
    p.speed_notch_hz = 31.0f;
    assert_answer(&p, PARAM_speed_notch_hz, PARAM_speed_ki_a_per_unit_s, "below 8 corners of 3.98 Hz");
    p.speed_notch_hz = 32.5f;
    assert_answer(&p, FINE, "above");
    p.speed_notch_hz = 399.0f;
    assert_answer(&p, FINE, "below 0.8 of 500 Hz");
    p.speed_notch_hz = 401.0f;
    assert_answer(&p, PARAM_speed_notch_hz, PARAM_speed_divider, "above");
    p.speed_divider = 5U;
    assert_answer(&p, FINE, "a loop of 2 kHz");
    p.method = DRIVE_METHOD_FAL_FORC;
    assert_answer(&p, PARAM_speed_notch_hz, PARAM_method, "repetitive control");
    p.method = DRIVE_METHOD_ARO;
    assert_answer(&p, FINE, "an observer");
}

void test_combinations_flux_harmonics_need_integral_parts_and_a_motor_without_d_current(void)
{
    const uint16_t flux[] = {PARAM_flux_cos6, PARAM_flux_sin6, PARAM_flux_cos12, PARAM_flux_sin12};
    for (size_t k = 0; k < COUNT_OF(flux); k++) {
        drive_params_t p;
        params_default(&p);
        TEST_ASSERT_TRUE(params_set(&p, flux[k], 0.01f));
        assert_answer(&p, FINE, "pi");
        p.current_controller = 1U;
        assert_answer(&p, PARAM_flux_cos6, PARAM_current_controller, "deadbeat");
        p.current_controller = 0U;
        p.mtpa = 1U;
        assert_answer(&p, PARAM_flux_cos6, PARAM_mtpa, "mtpa");
        p.mtpa = 0U;
        p.field_weakening = 1U;
        assert_answer(&p, PARAM_flux_cos6, PARAM_field_weakening, "field weakening");
    }
}

void test_combinations_beyond_the_list_there_is_nothing(void)
{
    drive_params_t p;
    params_default(&p);
    TEST_ASSERT_NULL(combinations_info(combinations_broken(&p)));
    TEST_ASSERT_NULL(combinations_info(65535U));
}

void test_combinations_a_gain_that_follows_the_inductance_needs_a_gain_and_a_current_at_which_it_falls(void)
{
    drive_params_t p;
    params_default(&p);
    p.saturation_cross = 1.0f;
    assert_answer(&p, PARAM_saturation_cross, PARAM_saturation_a, "nothing falls");
    p.saturation_a = 8.0f;
    assert_answer(&p, FINE, "pi");
    p.current_controller = 1U;
    assert_answer(&p, PARAM_saturation_a, PARAM_current_controller, "deadbeat");
}
