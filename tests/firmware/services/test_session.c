/* firmware/services: hello, lists, parameters, commands, the timeout, events. Payloads as docs/protocol.md has them. */
#include "firmware/app/telemetry.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_link.h"
#include "mock_hal_sample.h"
#include "mock_hal_storage.h"
#include "tests/firmware/support/line.h"

void setUp(void) { line_start(); }
void tearDown(void) {}

static void get_text(char *out)
{
    const uint16_t n = codec_get_u8(&line.in);
    for (uint16_t i = 0U; i < n; i++) {
        out[i] = (char)codec_get_u8(&line.in);
    }
    out[n] = '\0';
}

static void skip(uint16_t octets) { line.in.at = (uint16_t)(line.in.at + octets); }

static void master(void) { line_hello(services.schema); }

static void run_at(float speed)
{
    master();
    line_command(LINK_CMD_arm);
    codec_writer_t *const w = line_begin(LINK_setpoint);
    codec_put_u8(w, DRIVE_MODE_SPEED);
    codec_put_f32(w, speed);
    codec_put_f32(w, 0.0f);
    codec_put_f32(w, 0.0f);
    codec_put_u32(w, 0U);
    codec_put_f32(w, 0.0f);
    TEST_ASSERT_EQUAL_HEX16(LINK_setpoint + LINK_ANSWER, line_ask());
    line_command(LINK_CMD_start);
    line_run(2U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

/* ---- hello, lists ------------------------------------------------------------------------------------------------------ */

void test_session_hello_says_what_the_drive_is(void)
{
    char text[256];
    master();
    TEST_ASSERT_EQUAL_UINT16(1U, codec_get_u16(&line.in));
    TEST_ASSERT_EQUAL_HEX32(services.schema, codec_get_u32(&line.in));
    TEST_ASSERT_EQUAL_UINT16(1U, codec_get_u8(&line.in)); /* may write */
#ifdef EVENSPIN_FIXED
    TEST_ASSERT_EQUAL_UINT16(1U, codec_get_u8(&line.in));
#else
    TEST_ASSERT_EQUAL_UINT16(0U, codec_get_u8(&line.in));
#endif
    TEST_ASSERT_EQUAL_UINT32(10000U, codec_get_u32(&line.in));
    TEST_ASSERT_EQUAL_UINT32(BENCH_CPU_HZ, codec_get_u32(&line.in));
    TEST_ASSERT_EQUAL_UINT16(248U, codec_get_u16(&line.in));
    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, codec_get_u16(&line.in));
    TEST_ASSERT_EQUAL_UINT16(SIGNAL_COUNT, codec_get_u16(&line.in));
    TEST_ASSERT_EQUAL_UINT16(FAULT_COUNT, codec_get_u16(&line.in));
    TEST_ASSERT_EQUAL_UINT16(12U, codec_get_u16(&line.in));
    TEST_ASSERT_EQUAL_UINT16(12U, codec_get_u8(&line.in));
    TEST_ASSERT_EQUAL_UINT16(8U, codec_get_u8(&line.in));
    TEST_ASSERT_EQUAL_UINT16(2U, codec_get_u8(&line.in));
    TEST_ASSERT_EQUAL_UINT32(LINE_CAPTURE_VALUES, codec_get_u32(&line.in));
    TEST_ASSERT_EQUAL_UINT32(LINE_BOX_VALUES, codec_get_u32(&line.in));
    TEST_ASSERT_EQUAL_UINT16(1U, codec_get_u8(&line.in)); /* has storage */
    TEST_ASSERT_EQUAL_UINT16(500U, codec_get_u16(&line.in));
    TEST_ASSERT_EQUAL_UINT32(services.counter, codec_get_u32(&line.in));
    get_text(text);
    TEST_ASSERT_EQUAL_STRING("test board", text);
    get_text(text);
    TEST_ASSERT_FALSE(line.in.over);
    TEST_ASSERT_EQUAL_UINT16(line.in.count, line.in.at);
}

void test_session_lists_every_parameter_with_its_limits(void)
{
    char     text[256];
    uint16_t next = 0U;
    while (next < (uint16_t)PARAM_COUNT) {
        codec_writer_t *const w = line_begin(LINK_list);
        codec_put_u8(w, 0U);
        codec_put_u16(w, next);
        TEST_ASSERT_EQUAL_HEX16(LINK_list + LINK_ANSWER, line_ask());
        TEST_ASSERT_EQUAL_UINT16(0U, codec_get_u8(&line.in));
        TEST_ASSERT_EQUAL_UINT16(next, codec_get_u16(&line.in));
        const uint16_t count = codec_get_u8(&line.in);
        TEST_ASSERT_TRUE(count > 0U);
        for (uint16_t i = 0U; i < count; i++, next++) {
            const param_info_t *const p = params_info(next);
            TEST_ASSERT_EQUAL_UINT16(p->kind, codec_get_u8(&line.in));
            TEST_ASSERT_EQUAL_UINT16(params_only_at_rest(next) ? 1U : 0U, codec_get_u8(&line.in));
            TEST_ASSERT_EQUAL_FLOAT(p->min, codec_get_f32(&line.in));
            TEST_ASSERT_EQUAL_FLOAT(p->max, codec_get_f32(&line.in));
            TEST_ASSERT_EQUAL_FLOAT(p->def, codec_get_f32(&line.in));
            get_text(text);
            TEST_ASSERT_EQUAL_STRING(p->name, text);
            get_text(text);
            TEST_ASSERT_EQUAL_STRING(params_unit(p), text);
            get_text(text);
            TEST_ASSERT_EQUAL_STRING(params_choices(p), text);
        }
        TEST_ASSERT_FALSE(line.in.over);
        TEST_ASSERT_EQUAL_UINT16(line.in.count, line.in.at);
    }
}

void test_session_tells_the_documentation_in_pieces(void)
{
    static char       text[512];
    uint16_t          at = 0U;
    uint16_t          total = 1U;
    const char *const expected = faults_info(FAULT_following_error)->check;
    while (at < total) {
        codec_writer_t *const w = line_begin(LINK_text);
        codec_put_u8(w, 2U);
        codec_put_u16(w, FAULT_following_error);
        codec_put_u8(w, 1U);
        codec_put_u16(w, at);
        TEST_ASSERT_EQUAL_HEX16(LINK_text + LINK_ANSWER, line_ask());
        skip(6U);
        total = codec_get_u16(&line.in);
        const uint16_t n = (uint16_t)(line.in.count - line.in.at);
        for (uint16_t i = 0U; i < ((n > 50U) ? 50U : n); i++) { /* a client that reads 50 at a time */
            text[at++] = (char)codec_get_u8(&line.in);
        }
    }
    TEST_ASSERT_EQUAL_STRING(expected, text);
}

void test_session_of_another_schema_reads_but_does_not_write(void)
{
    line_hello(services.schema ^ 1U);
    TEST_ASSERT_EQUAL_UINT16(0U, line.answer.octet[6]);

    codec_writer_t *w = line_begin(LINK_get);
    codec_put_u16(w, PARAM_pole_pairs);
    codec_put_u8(w, 1U);
    TEST_ASSERT_EQUAL_HEX16(LINK_get + LINK_ANSWER, line_ask());
    w = line_begin(LINK_set);
    codec_put_u8(w, 3U);
    codec_put_u8(w, 1U);
    codec_put_u16(w, PARAM_speed_kp_a_per_unit);
    codec_put_f32(w, 0.1f);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_schema, line_refusal(LINK_set));
    for (uint16_t command = 0U; command < LINK_COMMANDS; command++) {
        const bool always = (command == LINK_CMD_stop) || (command == LINK_CMD_disarm) || (command == LINK_CMD_clear_fault);
        codec_put_u16(line_begin(LINK_command), command);
        if (always) {
            TEST_ASSERT_EQUAL_HEX16(LINK_command + LINK_ANSWER, line_ask());
        } else {
            TEST_ASSERT_EQUAL_UINT16(LINK_NO_schema, line_refusal(LINK_command));
        }
    }
    codec_put_u16(line_begin(LINK_timeout), 0U);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_schema, line_refusal(LINK_timeout));
    w = line_begin(LINK_setpoint);
    for (uint16_t i = 0U; i < 21U; i++) {
        codec_put_u8(w, 0U);
    }
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_schema, line_refusal(LINK_setpoint));
}

void test_session_request_of_the_wrong_length_or_type_is_refused_with_what_is_expected(void)
{
    codec_put_u8(line_begin(LINK_hello), 1U);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_length, line_refusal(LINK_hello));
    TEST_ASSERT_EQUAL_UINT16(1U, codec_get_u16(&line.in));
    TEST_ASSERT_EQUAL_FLOAT(6.0f, codec_get_f32(&line.in));
    (void)line_begin(0x3FU);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_unknown, line_refusal(0x3FU));
    codec_writer_t *const w = line_begin(LINK_read);
    codec_put_u8(w, 2U);
    codec_put_u16(w, 0U); /* one of two */
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_length, line_refusal(LINK_read));
    TEST_ASSERT_EQUAL_UINT16(3U, codec_get_u16(&line.in));
    TEST_ASSERT_EQUAL_FLOAT(5.0f, codec_get_f32(&line.in));
}

void test_session_damaged_request_is_not_answered_and_the_next_one_is(void)
{
    uint16_t wire[FRAME_WIRE_MAX];
    (void)line_begin(LINK_state);
    const uint16_t n = frame_end(&line.request, wire);
    wire[2] ^= 0x10U;
    line_send(wire, n);
    line_run(10U);
    TEST_ASSERT_EQUAL_UINT16(0U, line.frames);

    (void)line_begin(LINK_state);
    TEST_ASSERT_EQUAL_HEX16(LINK_state + LINK_ANSWER, line_ask());
    skip(20U);
    TEST_ASSERT_EQUAL_UINT32(1U, codec_get_u32(&line.in)); /* frames_bad */
}

void test_session_takes_few_octets_a_pass_and_one_request(void)
{
    uint16_t wire[FRAME_WIRE_MAX];
    for (uint16_t i = 0U; i < 4U; i++) {
        (void)line_begin(LINK_alive);
        line_send(wire, frame_end(&line.request, wire));
    }
    line_run(1U);
    TEST_ASSERT_EQUAL_UINT16(1U, line.frames);
    line_run(3U);
    TEST_ASSERT_EQUAL_UINT16(4U, line.frames);
    for (uint16_t i = 0U; i < 300U; i++) {
        wire[0] = 0x55U;
        line_send(wire, 1U);
    }
    line_run(20U);
    TEST_ASSERT_EQUAL_UINT16(SERVICES_OCTETS_PER_PASS, line.most_reads_per_pass);
}

void test_session_on_a_slow_line_answers_whole(void)
{
    line.room = 3U; /* octets a call */
    master();
    TEST_ASSERT_EQUAL_UINT16(0U, line.dropped);
    line.room = 0U; /* and one that takes nothing: the drive goes on, and answers later */
    (void)line_begin(LINK_alive);
    TEST_ASSERT_EQUAL_UINT16(0U, line_ask());
    line.room = 1U;
    line_run(20U);
    TEST_ASSERT_EQUAL_UINT16(1U, line_count(LINK_alive + LINK_ANSWER));
}

/* ---- parameters ---------------------------------------------------------------------------------------------------------- */

void test_session_set_is_taken_over_by_the_next_interrupt(void)
{
    master();
    line_set(PARAM_current_kp_v_per_a, 0.75f);
    TEST_ASSERT_EQUAL_UINT16(3U, codec_get_u8(&line.in));
    TEST_ASSERT_EQUAL_UINT16(1U, codec_get_u8(&line.in));
    TEST_ASSERT_EQUAL_FLOAT(0.75f, codec_get_f32(&line.in));
    TEST_ASSERT_EQUAL_UINT16(1U, drive.next_ready); /* offered, not yet taken: no interrupt since */
    TEST_ASSERT_EQUAL_FLOAT(0.6f, drive.params->current_kp_v_per_a);

    codec_writer_t *const w = line_begin(LINK_get); /* shows what waits */
    codec_put_u16(w, PARAM_current_kp_v_per_a);
    codec_put_u8(w, 1U);
    (void)line_ask();
    skip(3U);
    TEST_ASSERT_EQUAL_FLOAT(0.75f, codec_get_f32(&line.in));
    TEST_ASSERT_EQUAL_FLOAT(0.75f, drive.params->current_kp_v_per_a);
}

void test_session_set_with_one_bad_value_changes_nothing_and_names_it_with_its_limits(void)
{
    master();
    static const float BAD[] = {-1.0f, 1001.0f};
    for (uint16_t i = 0U; i < 3U; i++) {
        codec_writer_t *const w = line_begin(LINK_set);
        codec_put_u8(w, 3U);
        codec_put_u8(w, 2U);
        codec_put_u16(w, PARAM_pole_pairs);
        codec_put_f32(w, 5.0f);
        codec_put_u16(w, PARAM_current_kp_v_per_a);
        codec_put_f32(w, (i < 2U) ? BAD[i] : codec_float(UINT32_C(0x7FC00000)));
        TEST_ASSERT_EQUAL_UINT16(LINK_NO_range, line_refusal(LINK_set));
        TEST_ASSERT_EQUAL_UINT16(PARAM_current_kp_v_per_a, codec_get_u16(&line.in));
        TEST_ASSERT_EQUAL_FLOAT(0.0f, codec_get_f32(&line.in));
        TEST_ASSERT_EQUAL_FLOAT(1000.0f, codec_get_f32(&line.in));
        line_run(2U);
        TEST_ASSERT_EQUAL_UINT16(4U, drive.params->pole_pairs);
    }
    codec_writer_t *const w = line_begin(LINK_set);
    codec_put_u8(w, 3U);
    codec_put_u8(w, 1U);
    codec_put_u16(w, PARAM_COUNT);
    codec_put_f32(w, 5.0f);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_index, line_refusal(LINK_set));
}

void test_session_set_that_does_not_fit_the_others_names_the_parameter(void)
{
    master();
    codec_writer_t *const w = line_begin(LINK_set);
    codec_put_u8(w, 3U);
    codec_put_u8(w, 2U);
    codec_put_u16(w, PARAM_position_min_turn);
    codec_put_f32(w, 5.0f);
    codec_put_u16(w, PARAM_position_max_turn);
    codec_put_f32(w, -5.0f);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_relation, line_refusal(LINK_set));
    const uint16_t culprit = codec_get_u16(&line.in);
    TEST_ASSERT_TRUE((culprit == PARAM_position_min_turn) || (culprit == PARAM_position_max_turn));
}

/* Over several frames; no interrupt ever sees half of it. */
void test_session_long_set_is_taken_over_as_a_whole(void)
{
    static const struct {
        uint16_t flags, index;
        float    value;
    } PARTS[3] = {{1U, PARAM_speed_kp_a_per_unit, 0.02f}, {0U, PARAM_speed_ki_a_per_unit_s, 0.5f}, {2U, PARAM_iq_limit_a, 2.0f}};
    master();
    for (uint16_t part = 0U; part < 3U; part++) {
        codec_writer_t *const w = line_begin(LINK_set);
        codec_put_u8(w, PARTS[part].flags);
        codec_put_u8(w, 1U);
        codec_put_u16(w, PARTS[part].index);
        codec_put_f32(w, PARTS[part].value);
        TEST_ASSERT_EQUAL_HEX16(LINK_set + LINK_ANSWER, line_ask());
        if (part < 2U) {
            line_run(5U);
            TEST_ASSERT_EQUAL_FLOAT(0.0368f, drive.params->speed_kp_a_per_unit);
            TEST_ASSERT_EQUAL_FLOAT(0.92f, drive.params->speed_ki_a_per_unit_s);
        }
    }
    line_run(1U);
    for (uint16_t part = 0U; part < 3U; part++) {
        TEST_ASSERT_EQUAL_FLOAT(PARTS[part].value, params_get(drive.params, PARTS[part].index));
    }
}

void test_session_set_that_was_begun_again_forgets_the_first_beginning(void)
{
    master();
    codec_writer_t *const w = line_begin(LINK_set);
    codec_put_u8(w, 1U);
    codec_put_u8(w, 1U);
    codec_put_u16(w, PARAM_iq_limit_a);
    codec_put_f32(w, 2.0f);
    TEST_ASSERT_EQUAL_HEX16(LINK_set + LINK_ANSWER, line_ask());
    line_set(PARAM_id_limit_a, 3.0f);
    line_run(2U);
    TEST_ASSERT_EQUAL_FLOAT(10.0f, drive.params->iq_limit_a);
    TEST_ASSERT_EQUAL_FLOAT(3.0f, drive.params->id_limit_a);
}

/* ---- commands ------------------------------------------------------------------------------------------------------------ */

void test_session_start_needs_arm(void)
{
    master();
    codec_put_u16(line_begin(LINK_command), LINK_CMD_start);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_not_armed, line_refusal(LINK_command));
    codec_put_u16(line_begin(LINK_command), LINK_CMD_home);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_not_armed, line_refusal(LINK_command));
    line_run(5U);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    run_at(10.0f);
    TEST_ASSERT_EQUAL_FLOAT(10.0f, drive.command[drive.command_at & 1U].speed_ref_rad_s);
    line_command(LINK_CMD_stop);
    line_run(1U);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_FALSE(bench.armed);
}

void test_session_hello_disarms_the_client_and_lets_the_motor_run_until_the_timeout(void)
{
    run_at(0.0f); /* the encoder of this bench stands still */
    line_hello(0U);
    line_run(4900U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    line_run(110U);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
}

void test_session_silence_after_a_start_stops_the_drive_in_half_a_second(void)
{
    run_at(10.0f);
    const uint32_t started = services.session.alive_at;
    while ((drive.state == DRIVE_RUN) && (services.counter < started + 20000U)) {
        line_run(1U);
    }
    TEST_ASSERT_UINT32_WITHIN(2U, started + 5000U, services.counter); /* passes of the main loop */
    TEST_ASSERT_FALSE(bench.armed);
    line_run(2U);
    const line_frame_t *const event = line_last(LINK_event);
    TEST_ASSERT_NOT_NULL(event);
    TEST_ASSERT_EQUAL_UINT16(DRIVE_READY, event->octet[4]);
    TEST_ASSERT_EQUAL_HEX16(0x08U, event->octet[9] & 0x0DU); /* by the timeout; neither armed nor counting */
    TEST_ASSERT_EQUAL_FLOAT(0.0f, drive.command[drive.command_at & 1U].speed_ref_rad_s);
    codec_put_u16(line_begin(LINK_command), LINK_CMD_start);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_not_armed, line_refusal(LINK_command));
}

/* a ramp from 10 rad/s of a shaft that stands still: off after 20 ms at rest, and no reference is left */
void test_session_silence_ends_in_the_ramp_or_the_short_that_was_chosen_and_is_reported(void)
{
    const drive_stop_word_t how[] = {DRIVE_STOP_RAMP, DRIVE_STOP_SHORT};
    for (size_t k = 0; k < COUNT_OF(how); k++) {
        line_start();
        line_defaults.timeout_action = (uint16_t)how[k];
        line_defaults.motor_resistance_ohm = 100.0f; /* shorted, it drives next to nothing */
        line_restart();
        run_at(10.0f);
        line_run(5010U);
        TEST_ASSERT_EQUAL_INT((how[k] == DRIVE_STOP_RAMP) ? DRIVE_RUN : DRIVE_SHORT, drive.state);
        TEST_ASSERT_TRUE(bench.armed);
        TEST_ASSERT_TRUE(services.session.timed_out);
        TEST_ASSERT_EQUAL_HEX16(0x08U, line_last(LINK_event)->octet[9] & 0x0DU);
        line_run(300U);
        TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
        TEST_ASSERT_FALSE(bench.armed);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, drive.command[drive.command_at & 1U].speed_ref_rad_s);
        TEST_ASSERT_EQUAL_INT(DRIVE_MODE_SPEED, drive.command[drive.command_at & 1U].mode);
    }
}

/* stop as chosen, disarm at once */
void test_session_disarm_is_at_once_where_a_stop_takes_its_time(void)
{
    line_defaults.stop_action = DRIVE_STOP_RAMP;
    line_restart();
    run_at(0.0f);
    line_command(LINK_CMD_stop);
    line_run(50U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    line_command(LINK_CMD_disarm);
    line_run(2U);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_FALSE(bench.armed);
}

static void torque_mode(float speed_limit, float iq)
{
    codec_writer_t *const w = line_begin(LINK_setpoint);
    codec_put_u8(w, DRIVE_MODE_TORQUE);
    codec_put_f32(w, speed_limit);
    codec_put_f32(w, 0.0f);
    codec_put_f32(w, iq);
    codec_put_u32(w, 0U);
    codec_put_f32(w, 0.0f);
}

void test_session_torque_mode_is_taken_within_its_limits_and_refused_with_an_observer(void)
{
    run_at(0.0f);
    torque_mode(50.0f, 2.0f);
    TEST_ASSERT_EQUAL_HEX16(LINK_setpoint + LINK_ANSWER, line_ask());
    line_run(20U);
    TEST_ASSERT_EQUAL_FLOAT(2.0f, telemetry_read(&drive, SIGNAL_iq_ref_a));
    torque_mode(50.0f, 10.5f); /* iq_limit_a is 10 */
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_range, line_refusal(LINK_setpoint));
    torque_mode(651.0f, 2.0f); /* over_speed_rad_s is 650 */
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_range, line_refusal(LINK_setpoint));
    line_defaults.method = DRIVE_METHOD_ARO;
    line_restart();
    master();
    torque_mode(50.0f, 2.0f);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_range, line_refusal(LINK_setpoint));
}

void test_session_signs_of_life_keep_the_drive_running(void)
{
    run_at(0.0f); /* the encoder of this bench stands still */
    for (uint16_t i = 0U; i < 20U; i++) {
        line_run(4900U);
        (void)line_begin(LINK_alive);
        TEST_ASSERT_EQUAL_HEX16(LINK_alive + LINK_ANSWER, line_ask());
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

void test_session_rubbish_is_no_sign_of_life(void)
{
    run_at(0.0f); /* the encoder of this bench stands still */
    for (uint16_t i = 0U; i < 120U; i++) {
        static const uint16_t rubbish[3] = {3U, 7U, 0U};
        line_send(rubbish, 3U);
        line_run(50U);
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
}

void test_session_timeout_can_be_longer_or_off(void)
{
    run_at(0.0f); /* the encoder of this bench stands still */
    codec_put_u16(line_begin(LINK_timeout), 1000U);
    TEST_ASSERT_EQUAL_HEX16(LINK_timeout + LINK_ANSWER, line_ask());
    line_run(9900U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    codec_put_u16(line_begin(LINK_timeout), 0U);
    TEST_ASSERT_EQUAL_HEX16(LINK_timeout + LINK_ANSWER, line_ask());
    line_run(30000U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    codec_put_u16(line_begin(LINK_timeout), 49U);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_range, line_refusal(LINK_timeout));
}

void test_session_setpoint_out_of_range_is_refused_with_its_position(void)
{
    master();
    for (uint16_t bad = 0U; bad < 6U; bad++) {
        codec_writer_t *const w = line_begin(LINK_setpoint);
        codec_put_u8(w, (bad == 0U) ? 4U : 2U);
        codec_put_f32(w, (bad == 1U) ? 1.1e6f : 1.0f);
        codec_put_f32(w, (bad == 2U) ? codec_float(UINT32_C(0x7FC00000)) : 0.0f);
        codec_put_f32(w, (bad == 3U) ? codec_float(UINT32_C(0x7F800000)) : 0.0f);
        codec_put_u32(w, UINT32_C(0xFFFFFFFE));
        codec_put_f32(w, (bad == 5U) ? 6.3f : 1.5f);
        if (bad == 4U) { /* every whole number of turns is a target */
            TEST_ASSERT_EQUAL_HEX16(LINK_setpoint + LINK_ANSWER, line_ask());
            TEST_ASSERT_EQUAL_INT32(-2, drive.command[drive.command_at & 1U].target_turns);
        } else {
            TEST_ASSERT_EQUAL_UINT16(LINK_NO_range, line_refusal(LINK_setpoint));
            TEST_ASSERT_EQUAL_UINT16(bad, codec_get_u16(&line.in));
        }
    }
}

/* ---- faults -------------------------------------------------------------------------------------------------------------- */

void test_session_fault_sends_an_event_disarms_and_freezes_what_was_before_it(void)
{
    run_at(10.0f);
    line_run(100U);
    bench.sample.vdc_v = 100.0f;
    line_run(1U);
    const uint32_t when = services.counter - 1U;
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state);
    bench.sample.vdc_v = 24.0f;
    line_run(50U);

    const line_frame_t *const event = line_last(LINK_event);
    TEST_ASSERT_NOT_NULL(event);
    TEST_ASSERT_EQUAL_UINT16(DRIVE_FAULT, event->octet[4]);
    TEST_ASSERT_EQUAL_UINT16(FAULT_over_voltage, event->octet[5]);
    (void)line_begin(LINK_fault);
    TEST_ASSERT_EQUAL_HEX16(LINK_fault + LINK_ANSWER, line_ask());
    TEST_ASSERT_EQUAL_UINT16(FAULT_over_voltage, codec_get_u16(&line.in));
    skip(3U);
    TEST_ASSERT_EQUAL_UINT32(when, codec_get_u32(&line.in));
    TEST_ASSERT_EQUAL_UINT16(RECORDER_COMPLETE, codec_get_u8(&line.in));
    const uint16_t rows = codec_get_u16(&line.in);
    TEST_ASSERT_EQUAL_UINT16(LINE_BOX_VALUES / 8U, rows);

    codec_put_u8(line_begin(LINK_capture_status), 1U);
    TEST_ASSERT_EQUAL_HEX16(LINK_capture_status + LINK_ANSWER, line_ask());
    skip(6U);
    const uint16_t        pre = codec_get_u16(&line.in);
    codec_writer_t *const w = line_begin(LINK_capture_read);
    codec_put_u8(w, 1U);
    codec_put_u32(w, (uint32_t)(pre - 1U) * 8U); /* the row before the fault and the one of it */
    codec_put_u8(w, 16U);
    TEST_ASSERT_EQUAL_HEX16(LINK_capture_read + LINK_ANSWER, line_ask());
    skip(7U);
    float row[16];
    for (uint16_t i = 0U; i < 16U; i++) {
        row[i] = codec_get_f32(&line.in);
    }
    TEST_ASSERT_EQUAL_FLOAT(24.0f, row[6]); /* vdc_v */
    TEST_ASSERT_EQUAL_FLOAT(100.0f, row[14]);

    codec_put_u16(line_begin(LINK_command), LINK_CMD_arm);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_state, line_refusal(LINK_command));
    line_command(LINK_CMD_clear_fault);
    line_run(2U);
    codec_put_u16(line_begin(LINK_command), LINK_CMD_start);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_not_armed, line_refusal(LINK_command));
    TEST_ASSERT_EQUAL_INT(RECORDER_COMPLETE, services.recorder[SERVICES_BLACK_BOX].status);
    line_command(LINK_CMD_arm);
    line_command(LINK_CMD_start);
    line_run(5U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    TEST_ASSERT_EQUAL_INT(RECORDER_FILLING, services.recorder[SERVICES_BLACK_BOX].status); /* for the next one */
}

/* ---- what was learned --------------------------------------------------------------------------------------------------------- */

void test_session_shows_what_the_angle_observer_has_learned(void)
{
    static float    amps[200];
    codec_writer_t *w = line_begin(LINK_learned);
    codec_put_u16(w, 0U);
    codec_put_u8(w, 60U);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_unsupported, line_refusal(LINK_learned));
    line_defaults.method = DRIVE_METHOD_ARO;
    line_restart();
    for (uint16_t i = 0U; i < 200U; i++) {
        amps[i] = 0.015625f * (float)i;
    }
    TEST_ASSERT_TRUE(drive_memory_write(&drive, amps, 200U));
    for (uint16_t first = 0U; first < 200U; first += 60U) {
        w = line_begin(LINK_learned);
        codec_put_u16(w, first);
        codec_put_u8(w, 60U);
        TEST_ASSERT_EQUAL_HEX16(LINK_learned + LINK_ANSWER, line_ask());
        TEST_ASSERT_EQUAL_UINT16(200U, codec_get_u16(&line.in));
        TEST_ASSERT_EQUAL_UINT16(first, codec_get_u16(&line.in));
        const uint16_t n = codec_get_u8(&line.in);
        TEST_ASSERT_EQUAL_UINT16((first == 180U) ? 20U : 60U, n);
        for (uint16_t i = 0U; i < n; i++) {
            TEST_ASSERT_FLOAT_WITHIN(1e-6f, amps[first + i], codec_get_f32(&line.in)); /* Q7.24 of 10 A: 6e-7 A */
        }
    }
    w = line_begin(LINK_learned);
    codec_put_u16(w, 200U);
    codec_put_u8(w, 1U);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_index, line_refusal(LINK_learned));
}

/* ---- storage --------------------------------------------------------------------------------------------------------------- */

void test_session_saved_parameters_come_back_after_a_power_cycle(void)
{
    master();
    line_set(PARAM_speed_kp_a_per_unit, 0.5f);
    line_command(LINK_CMD_save);
    line_restart();
    TEST_ASSERT_EQUAL_FLOAT(0.5f, drive.params->speed_kp_a_per_unit);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    master();
    line_command(LINK_CMD_defaults);
    line_run(2U);
    TEST_ASSERT_EQUAL_FLOAT(0.0368f, drive.params->speed_kp_a_per_unit);
    line_command(LINK_CMD_restore);
    line_run(2U);
    TEST_ASSERT_EQUAL_FLOAT(0.5f, drive.params->speed_kp_a_per_unit);
}

void test_session_save_takes_many_passes_and_others_are_served_meanwhile(void)
{
    uint16_t wire[FRAME_WIRE_MAX];
    master();
    codec_put_u16(line_begin(LINK_command), LINK_CMD_save);
    const uint16_t save_seq = line.seq;
    line_send(wire, frame_end(&line.request, wire));
    line_run(2U);
    TEST_ASSERT_EQUAL_UINT16(0U, line_count(LINK_command + LINK_ANSWER));
    (void)line_begin(LINK_alive);
    TEST_ASSERT_EQUAL_HEX16(LINK_alive + LINK_ANSWER, line_ask());
    skip(7U);
    TEST_ASSERT_EQUAL_HEX16(0x80U, codec_get_u16(&line.in) & 0x80U); /* under way */
    codec_writer_t *const w = line_begin(LINK_set);
    codec_put_u8(w, 3U);
    codec_put_u8(w, 0U);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_busy, line_refusal(LINK_set));
    codec_put_u16(line_begin(LINK_command), LINK_CMD_save);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_busy, line_refusal(LINK_command));
    line_run(60U); /* a set of 130 parameters takes some more than 40 */
    const line_frame_t *const done = line_last(LINK_command + LINK_ANSWER);
    TEST_ASSERT_NOT_NULL(done);
    TEST_ASSERT_EQUAL_UINT16(save_seq, done->seq);
}

void test_session_storage_that_fails_is_said_and_a_running_drive_does_not_save(void)
{
    master();
    codec_put_u16(line_begin(LINK_command), LINK_CMD_restore);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_nothing_stored, line_refusal(LINK_command));
    flash.until_error = 5;
    codec_put_u16(line_begin(LINK_command), LINK_CMD_save);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_storage, line_refusal(LINK_command));
    flash.until_error = -1;
    flash.pages = 0U;
    codec_put_u16(line_begin(LINK_command), LINK_CMD_save);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_unsupported, line_refusal(LINK_command));
    run_at(1.0f);
    for (uint16_t command = LINK_CMD_save; command <= LINK_CMD_learn_restore; command++) {
        codec_put_u16(line_begin(LINK_command), command);
        TEST_ASSERT_EQUAL_UINT16(LINK_NO_state, line_refusal(LINK_command));
        TEST_ASSERT_EQUAL_UINT16(DRIVE_RUN, codec_get_u16(&line.in));
    }
}

void test_session_stored_set_that_fits_no_drive_does_not_lock_the_bench_out(void)
{
    static drive_params_t bad;
    static store_t        store;
    bad = line_defaults;
    bad.position_min_turn = 5.0f;
    bad.position_max_turn = -5.0f;
    TEST_ASSERT_EQUAL_INT(HAL_OK, param_store_begin(&store, &bad, services.schema));
    while (param_store_step(&store) == HAL_BUSY) {
    }
    line_restart();
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_EQUAL_HEX16(0U, services.stored_taken ? 1U : 0U);
}
