/* What a client may ask of the drive: within the board's maxima, the limits in force and the bridge's state, and where the client learns the
 * limit lies when it is not. */
#include <math.h>

#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_link.h"
#include "mock_hal_sample.h"
#include "mock_hal_storage.h"
#include "tests/firmware/support/line.h"

void setUp(void)
{
    line_start();
    const hal_limits_t board = {25.0f, 45.0f, 700.0f, 0.8f, 0.0f, true};
    bench.limits = board;
    line_hello(services.schema);
}
void tearDown(void) {}

static void ask_set(uint16_t param, float value)
{
    codec_writer_t *const w = line_begin(LINK_set);
    codec_put_u8(w, 3U);
    codec_put_u8(w, 1U);
    codec_put_u16(w, param);
    codec_put_f32(w, value);
}

static void expect_set_refusal(uint16_t code, uint16_t param, float low, float high)
{
    const char *const name = params_info(param)->name;
    TEST_ASSERT_EQUAL_UINT16_MESSAGE(code, line_refusal(LINK_set), name);
    TEST_ASSERT_EQUAL_UINT16_MESSAGE(param, codec_get_u16(&line.in), name);
    TEST_ASSERT_EQUAL_FLOAT_MESSAGE(low, codec_get_f32(&line.in), name);
    TEST_ASSERT_EQUAL_FLOAT_MESSAGE(high, codec_get_f32(&line.in), name);
}

static void run(void)
{
    line_command(LINK_CMD_arm);
    line_command(LINK_CMD_start);
    line_run(3U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

static void ask_setpoint(uint16_t mode, float speed, float id, float iq)
{
    codec_writer_t *const w = line_begin(LINK_setpoint);
    codec_put_u8(w, mode);
    codec_put_f32(w, speed);
    codec_put_f32(w, id);
    codec_put_f32(w, iq);
    codec_put_u32(w, 0U);
    codec_put_f32(w, 0.0f);
}

static void expect_setpoint_refusal(uint16_t field, float limit)
{
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_range, line_refusal(LINK_setpoint));
    TEST_ASSERT_EQUAL_UINT16(field, codec_get_u16(&line.in));
    TEST_ASSERT_EQUAL_FLOAT(-limit, codec_get_f32(&line.in));
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, limit, codec_get_f32(&line.in));
}

/* At rest and running: what was asked for, and the most that the board bears. */
void test_limits_set_beyond_the_board_is_refused_with_value_and_maximum(void)
{
    for (int running = 0; running < 2; running++) {
        if (running != 0) {
            run();
        }
        ask_set(PARAM_over_current_a, 1000.0f);
        expect_set_refusal(LINK_NO_board, PARAM_over_current_a, 1000.0f, 25.0f);
        ask_set(PARAM_iq_limit_a, 25.1f);
        expect_set_refusal(LINK_NO_board, PARAM_iq_limit_a, 25.1f, 25.0f);
        ask_set(PARAM_over_voltage_v, 46.0f);
        expect_set_refusal(LINK_NO_board, PARAM_over_voltage_v, 46.0f, 45.0f);
        ask_set(PARAM_over_speed_rad_s, 20000.0f);
        expect_set_refusal(LINK_NO_board, PARAM_over_speed_rad_s, 20000.0f, 700.0f);
        ask_set(PARAM_offset_limit_a, 1.0f);
        expect_set_refusal(LINK_NO_board, PARAM_offset_limit_a, 1.0f, 0.8f);
    }
}

void test_limits_set_that_needs_rest_is_refused_while_running_with_value_and_the_one_in_force(void)
{
    run();
    ask_set(PARAM_method, 2.0f);
    expect_set_refusal(LINK_NO_at_rest, PARAM_method, 2.0f, 0.0f);
    ask_set(PARAM_encoder_offset_rad, 3.14f);
    expect_set_refusal(LINK_NO_at_rest, PARAM_encoder_offset_rad, 3.14f, 0.0f);
    ask_set(PARAM_encoder_counts, 16.0f);
    expect_set_refusal(LINK_NO_at_rest, PARAM_encoder_counts, 16.0f, 4000.0f);
    ask_set(PARAM_lost_sample_limit, 60000.0f);
    expect_set_refusal(LINK_NO_at_rest, PARAM_lost_sample_limit, 60000.0f, 3.0f);
    ask_set(PARAM_stall_s, 1.0f);
    expect_set_refusal(LINK_NO_at_rest, PARAM_stall_s, 1.0f, 0.0f);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    line_command(LINK_CMD_stop);
    line_run(3U);
    line_set(PARAM_method, 2.0f);
    line_run(3U);
    TEST_ASSERT_EQUAL_UINT16(DRIVE_METHOD_FORC, drive.params->method);
}

void test_limits_set_that_does_not_fit_the_others_is_refused_with_what_they_leave(void)
{
    ask_set(PARAM_iq_limit_a, 21.0f); /* over_current_a is 20 A */
    expect_set_refusal(LINK_NO_relation, PARAM_iq_limit_a, 0.0f, 20.0f);
    ask_set(PARAM_voltage_limit_v, 1.0e-30f);
    expect_set_refusal(LINK_NO_relation, PARAM_voltage_limit_v, 0.1f, 45.0f);
    ask_set(PARAM_profile_speed_rad_s, 651.0f);
    expect_set_refusal(LINK_NO_relation, PARAM_profile_speed_rad_s, params_info(PARAM_profile_speed_rad_s)->min, 650.0f);
    ask_set(PARAM_under_voltage_v, 41.0f);
    expect_set_refusal(LINK_NO_relation, PARAM_under_voltage_v, 0.0f, 40.0f);
}

void test_limits_setpoint_beyond_the_limits_in_force_is_refused_with_them(void)
{
    const float none[] = {NAN, INFINITY, -INFINITY, 2.0e6f};
    for (unsigned k = 0U; k < 4U; k++) {
        ask_setpoint(DRIVE_MODE_SPEED, none[k], 0.0f, 0.0f);
        TEST_ASSERT_EQUAL_UINT16(LINK_NO_range, line_refusal(LINK_setpoint));
        ask_setpoint(DRIVE_MODE_CURRENT, 0.0f, 0.0f, none[k]);
        TEST_ASSERT_EQUAL_UINT16(LINK_NO_range, line_refusal(LINK_setpoint));
    }
    ask_setpoint(DRIVE_MODE_SPEED, 700.0f, 0.0f, 0.0f);
    expect_setpoint_refusal(1U, 650.0f);
    ask_setpoint(DRIVE_MODE_SPEED, -1.0e6f, 0.0f, 0.0f);
    expect_setpoint_refusal(1U, 650.0f);
    ask_setpoint(DRIVE_MODE_SPEED, 0.0f, 10.1f, 0.0f);
    expect_setpoint_refusal(2U, 10.0f);
    ask_setpoint(DRIVE_MODE_CURRENT, 0.0f, 0.0f, -10.1f);
    expect_setpoint_refusal(3U, 10.0f);
    ask_setpoint(DRIVE_MODE_CURRENT, 0.0f, 6.0f, 8.1f); /* 10 A long together: 6 A leave 8 A */
    expect_setpoint_refusal(3U, 8.0f);
    ask_setpoint(DRIVE_MODE_CURRENT, 0.0f, 6.0f, 7.9f);
    TEST_ASSERT_EQUAL_HEX16(LINK_setpoint + LINK_ANSWER, line_ask());
    ask_setpoint(DRIVE_MODE_SPEED, -650.0f, 0.0f, 0.0f);
    TEST_ASSERT_EQUAL_HEX16(LINK_setpoint + LINK_ANSWER, line_ask());
}

static void ask_excite(uint16_t where, float amplitude, float hz)
{
    codec_writer_t *const w = line_begin(LINK_excite);
    codec_put_u8(w, where);
    codec_put_f32(w, amplitude);
    codec_put_f32(w, hz);
}

static void expect_excite_refusal(uint16_t field, float low, float high)
{
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_range, line_refusal(LINK_excite));
    TEST_ASSERT_EQUAL_UINT16(field, codec_get_u16(&line.in));
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, low, codec_get_f32(&line.in));
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, high, codec_get_f32(&line.in));
}

void test_limits_excitation_is_refused_at_rest_and_beyond_the_limits_in_force(void)
{
    ask_excite(1U, 1.0f, 100.0f);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_state, line_refusal(LINK_excite));
    ask_setpoint(DRIVE_MODE_SPEED, 50.0f, 0.0f, 0.0f);
    TEST_ASSERT_EQUAL_HEX16(LINK_setpoint + LINK_ANSWER, line_ask());
    run();
    ask_excite(4U, 1.0f, 100.0f);
    expect_excite_refusal(0U, 0.0f, 3.0f);
    const float none[] = {0.0f, -1.0f, 10.1f, NAN, INFINITY};
    for (unsigned k = 0U; k < 5U; k++) {
        ask_excite(1U, none[k], 100.0f);
        expect_excite_refusal(1U, 0.0f, 10.0f);
    }
    ask_excite(3U, 600.1f, 100.0f); /* the reference is 50, the limit 650 rad/s */
    expect_excite_refusal(1U, 0.0f, 600.0f);
    const float outside[] = {0.0f, 0.009f, -5.0f, NAN, 4501.0f, INFINITY};
    for (unsigned k = 0U; k < 6U; k++) {
        ask_excite(2U, 1.0f, outside[k]);
        expect_excite_refusal(2U, 0.01f, 4500.0f);
    }
    for (uint16_t where = 1U; where <= 3U; where = (uint16_t)(where + 2U)) {
        ask_excite(where, 1.0f, 451.0f); /* the speed loop has 1 kHz */
        expect_excite_refusal(2U, 0.01f, 450.0f);
    }
    ask_excite(1U, 1.0f, 100.0f);
    TEST_ASSERT_EQUAL_HEX16(LINK_excite + LINK_ANSWER, line_ask());
    (void)codec_get_u32(&line.in);
    TEST_ASSERT_EQUAL_FLOAT(100.0f, codec_get_f32(&line.in));
    ask_setpoint(DRIVE_MODE_CURRENT, 0.0f, 0.0f, 1.0f);
    TEST_ASSERT_EQUAL_HEX16(LINK_setpoint + LINK_ANSWER, line_ask());
    ask_excite(3U, 1.0f, 100.0f); /* no speed reference in this mode */
    expect_excite_refusal(0U, 0.0f, 2.0f);
    ask_excite(0U, NAN, NAN); /* an end always */
    TEST_ASSERT_EQUAL_HEX16(LINK_excite + LINK_ANSWER, line_ask());
}

void test_limits_excitation_needs_the_schema(void)
{
    line_hello(services.schema + 1U);
    ask_excite(0U, 0.0f, 0.0f);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_schema, line_refusal(LINK_excite));
}

/* A set that another board, or another build of this one, was allowed to save. */
void test_limits_stored_set_beyond_the_board_is_not_taken(void)
{
    static drive_params_t bad;
    static store_t        store;
    bad = line_defaults;
    bad.over_current_a = 100.0f;
    TEST_ASSERT_EQUAL_INT(HAL_OK, param_store_begin(&store, &bad, services.schema));
    while (param_store_step(&store) == HAL_BUSY) {
    }
    line_restart();
    TEST_ASSERT_EQUAL_FLOAT(20.0f, drive.params->over_current_a);
    TEST_ASSERT_FALSE(services.stored_taken);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);

    line_hello(services.schema);
    codec_put_u16(line_begin(LINK_command), LINK_CMD_restore);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_board, line_refusal(LINK_command));
    TEST_ASSERT_EQUAL_UINT16(PARAM_over_current_a, codec_get_u16(&line.in));
    TEST_ASSERT_EQUAL_FLOAT(20.0f, drive.params->over_current_a);
}
