/* firmware/services/requests_*.c: what is refused, why, and with which limits; rows asked for over the link. */
#include "firmware/app/telemetry.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_link.h"
#include "mock_hal_sample.h"
#include "mock_hal_storage.h"
#include "tests/firmware/support/line.h"

typedef struct {
    uint16_t which, decimation, pre, post, trigger, signal;
    float    level;
    uint16_t count, first_signal;
} capture_t;

static const capture_t GOOD = {0U, 1U, 2U, 3U, 1U, SIGNAL_vdc_v, 30.0f, 2U, SIGNAL_vdc_v};

void setUp(void) { line_start(); }
void tearDown(void) {}

static void put_capture(const capture_t *c)
{
    codec_writer_t *const w = line_begin(LINK_capture_configure);
    codec_put_u8(w, c->which);
    codec_put_u16(w, c->decimation);
    codec_put_u16(w, c->pre);
    codec_put_u16(w, c->post);
    codec_put_u8(w, c->trigger);
    codec_put_u16(w, c->signal);
    codec_put_f32(w, c->level);
    codec_put_u8(w, c->count);
    for (uint16_t i = 0U; i < ((c->count < 9U) ? c->count : 8U); i++) {
        codec_put_u16(w, (i == 0U) ? c->first_signal : SIGNAL_ia_a);
    }
}

static void expect_refusal(uint16_t type, uint16_t code, uint16_t field, float low, float high)
{
    TEST_ASSERT_EQUAL_UINT16(code, line_refusal(type));
    TEST_ASSERT_EQUAL_UINT16(field, codec_get_u16(&line.in));
    TEST_ASSERT_EQUAL_FLOAT(low, codec_get_f32(&line.in));
    TEST_ASSERT_EQUAL_FLOAT(high, codec_get_f32(&line.in));
}

static uint16_t status(uint16_t which)
{
    codec_put_u8(line_begin(LINK_capture_status), which);
    TEST_ASSERT_EQUAL_HEX16(LINK_capture_status + LINK_ANSWER, line_ask());
    return line.answer.octet[2];
}

static void control(uint16_t which, uint16_t action)
{
    codec_writer_t *const w = line_begin(LINK_capture_control);
    codec_put_u8(w, which);
    codec_put_u8(w, action);
}

static void put_read(uint16_t which, uint32_t offset, uint16_t count)
{
    codec_writer_t *const w = line_begin(LINK_capture_read);
    codec_put_u8(w, which);
    codec_put_u32(w, offset);
    codec_put_u8(w, count);
}

/* ---- capture --------------------------------------------------------------------------------------------------------------- */

void test_requests_capture_runs_as_configured_and_is_read_in_pieces(void)
{
    put_capture(&GOOD);
    TEST_ASSERT_EQUAL_HEX16(LINK_capture_configure + LINK_ANSWER, line_ask());
    TEST_ASSERT_EQUAL_UINT16(0U, codec_get_u8(&line.in));
    TEST_ASSERT_EQUAL_UINT16(1U, codec_get_u8(&line.in)); /* the first configuration */
    TEST_ASSERT_EQUAL_UINT16(5U, codec_get_u16(&line.in));
    line_run(5U);
    TEST_ASSERT_EQUAL_UINT16(RECORDER_WAITING, status(0U));
    put_read(0U, 0U, 1U);
    expect_refusal(LINK_capture_read, LINK_NO_state, RECORDER_WAITING, 0.0f, 0.0f);
    const uint32_t when = services.counter;
    bench.sample.vdc_v = 31.0f;
    line_run(5U);

    TEST_ASSERT_EQUAL_UINT16(RECORDER_COMPLETE, status(0U));
    static const uint16_t expected[] = {0U, 1U, 4U, 1U, 1U, 0U, 2U, 0U, 5U, 0U, 5U, 0U}; /* to done */
    TEST_ASSERT_EQUAL_HEX16_ARRAY(expected, line.answer.octet, 12);
    line.in.at = 12U;
    TEST_ASSERT_EQUAL_UINT32(when - 2U, codec_get_u32(&line.in));
    TEST_ASSERT_EQUAL_UINT32(when, codec_get_u32(&line.in));
    TEST_ASSERT_EQUAL_UINT16(2U, codec_get_u8(&line.in));
    TEST_ASSERT_EQUAL_UINT16(SIGNAL_vdc_v, codec_get_u16(&line.in));
    for (uint16_t again = 0U; again < 2U; again++) {
        put_read(0U, 2U, 3U); /* row 1 and half of row 2, the one of the trigger */
        TEST_ASSERT_EQUAL_HEX16(LINK_capture_read + LINK_ANSWER, line_ask());
        line.in.at = 2U;
        TEST_ASSERT_EQUAL_UINT32(2U, codec_get_u32(&line.in));
        TEST_ASSERT_EQUAL_UINT16(3U, codec_get_u8(&line.in));
        TEST_ASSERT_EQUAL_FLOAT(24.0f, codec_get_f32(&line.in));
        (void)codec_get_f32(&line.in);
        TEST_ASSERT_EQUAL_FLOAT(31.0f, codec_get_f32(&line.in));
    }
    put_read(0U, 9U, 60U); /* fewer are left */
    TEST_ASSERT_EQUAL_HEX16(LINK_capture_read + LINK_ANSWER, line_ask());
    TEST_ASSERT_EQUAL_UINT16(1U, line.answer.octet[6]);
    put_read(0U, 10U, 1U);
    expect_refusal(LINK_capture_read, LINK_NO_index, 10U, 0.0f, 9.0f);
    put_read(0U, UINT32_C(0x10000), 1U);
    expect_refusal(LINK_capture_read, LINK_NO_index, 0xFFFFU, 0.0f, 9.0f);
}

void test_requests_capture_that_cannot_be_is_refused_with_field_and_limits(void)
{
    capture_t c = GOOD;
    c.which = 2U;
    put_capture(&c);
    expect_refusal(LINK_capture_configure, LINK_NO_index, 2U, 0.0f, 1.0f);
    c = GOOD;
    c.decimation = 0U;
    put_capture(&c);
    expect_refusal(LINK_capture_configure, LINK_NO_range, 1U, 1.0f, 65535.0f);
    c = GOOD;
    c.post = 0U;
    put_capture(&c);
    expect_refusal(LINK_capture_configure, LINK_NO_range, 3U, 1.0f, 65535.0f);
    c = GOOD;
    c.trigger = 6U;
    put_capture(&c);
    expect_refusal(LINK_capture_configure, LINK_NO_range, 4U, 0.0f, 5.0f);
    c = GOOD;
    c.signal = SIGNAL_COUNT;
    put_capture(&c);
    expect_refusal(LINK_capture_configure, LINK_NO_index, SIGNAL_COUNT, 0.0f, (float)SIGNAL_COUNT - 1.0f);
    c.trigger = 4U; /* which looks at no signal */
    put_capture(&c);
    TEST_ASSERT_EQUAL_HEX16(LINK_capture_configure + LINK_ANSWER, line_ask());
    c = GOOD;
    c.level = codec_float(UINT32_C(0x7FC00000));
    put_capture(&c);
    expect_refusal(LINK_capture_configure, LINK_NO_range, 6U, -1.0e12f, 1.0e12f);
    c = GOOD;
    c.count = 0U;
    c.pre = 0U;
    put_capture(&c);
    codec_put_u16(&line.request.payload, 0U); /* long enough */
    expect_refusal(LINK_capture_configure, LINK_NO_too_many, 0U, 1.0f, 8.0f);
    c.count = 9U;
    put_capture(&c);
    expect_refusal(LINK_capture_configure, LINK_NO_too_many, 9U, 1.0f, 8.0f);
    c = GOOD;
    c.first_signal = 999U;
    put_capture(&c);
    expect_refusal(LINK_capture_configure, LINK_NO_index, 999U, 0.0f, (float)SIGNAL_COUNT - 1.0f);
    c = GOOD;
    put_capture(&c);
    codec_put_u16(&line.request.payload, 0U); /* three signals, two announced */
    expect_refusal(LINK_capture_configure, LINK_NO_length, 21U, 19.0f, 19.0f);
}

void test_requests_capture_takes_all_the_room_and_not_a_row_more(void)
{
    capture_t c = GOOD;
    c.pre = 100U;
    c.post = (LINE_CAPTURE_VALUES / 2U) - 100U;
    put_capture(&c);
    TEST_ASSERT_EQUAL_HEX16(LINK_capture_configure + LINK_ANSWER, line_ask());
    c.post++;
    put_capture(&c);
    expect_refusal(LINK_capture_configure, LINK_NO_too_many, (LINE_CAPTURE_VALUES / 2U) + 1U, 0.0f,
                   (float)(LINE_CAPTURE_VALUES / 2U));
    c.pre = 65535U; /* whose sum is beyond 16 bits */
    c.post = 65535U;
    put_capture(&c);
    expect_refusal(LINK_capture_configure, LINK_NO_too_many, 0xFFFFU, 0.0f, (float)(LINE_CAPTURE_VALUES / 2U));
    TEST_ASSERT_EQUAL_UINT16(RECORDER_WAITING, (line_run(200U), status(0U))); /* the one that was taken goes on */
}

void test_requests_capture_obeys_stop_trigger_and_start_again(void)
{
    TEST_ASSERT_EQUAL_UINT16(RECORDER_NEVER, status(0U));
    TEST_ASSERT_EQUAL_UINT16(0U, line.answer.octet[20]); /* no signals */
    put_capture(&GOOD);
    (void)line_ask();
    line_run(5U);
    control(0U, 0U);
    TEST_ASSERT_EQUAL_HEX16(LINK_capture_control + LINK_ANSWER, line_ask());
    TEST_ASSERT_EQUAL_UINT16(RECORDER_STOPPED, line.answer.octet[1]);
    control(0U, 2U);
    (void)line_ask();
    TEST_ASSERT_EQUAL_UINT16(RECORDER_FILLING, line.answer.octet[1]);
    line_run(5U);
    control(0U, 1U);
    (void)line_ask();
    line_run(5U);
    TEST_ASSERT_EQUAL_UINT16(RECORDER_COMPLETE, status(0U));
    control(0U, 3U);
    expect_refusal(LINK_capture_control, LINK_NO_range, 1U, 0.0f, 2.0f);
    control(2U, 0U);
    expect_refusal(LINK_capture_control, LINK_NO_index, 2U, 0.0f, 1.0f);
    codec_put_u8(line_begin(LINK_capture_status), 2U);
    expect_refusal(LINK_capture_status, LINK_NO_index, 2U, 0.0f, 1.0f);
    put_read(2U, 0U, 1U);
    expect_refusal(LINK_capture_read, LINK_NO_index, 2U, 0.0f, 1.0f);
    put_read(0U, 0U, 61U);
    expect_refusal(LINK_capture_read, LINK_NO_too_many, 61U, 1.0f, 60.0f);
    put_read(0U, 0U, 0U);
    expect_refusal(LINK_capture_read, LINK_NO_too_many, 0U, 1.0f, 60.0f);
}

void test_requests_black_box_can_have_other_signals(void)
{
    capture_t c = GOOD;
    c.which = 1U;
    c.trigger = RECORDER_AT_FAULT;
    put_capture(&c);
    TEST_ASSERT_EQUAL_HEX16(LINK_capture_configure + LINK_ANSWER, line_ask());
    line_run(3U);
    bench.sample.vdc_v = 100.0f;
    line_run(5U);
    TEST_ASSERT_EQUAL_UINT16(RECORDER_COMPLETE, status(1U));
    TEST_ASSERT_EQUAL_UINT16(2U, line.answer.octet[20]);
}

/* ---- stream ---------------------------------------------------------------------------------------------------------------- */

void test_requests_stream_starts_stops_and_refuses(void)
{
    codec_writer_t *w = line_begin(LINK_stream_configure);
    codec_put_u16(w, 2U);
    codec_put_u8(w, 4U);
    codec_put_u8(w, 1U);
    codec_put_u16(w, SIGNAL_vdc_v);
    TEST_ASSERT_EQUAL_HEX16(LINK_stream_configure + LINK_ANSWER, line_ask());
    const uint16_t config = codec_get_u8(&line.in);
    TEST_ASSERT_EQUAL_UINT16(4U, codec_get_u8(&line.in));
    TEST_ASSERT_EQUAL_UINT16(STREAM_VALUES, codec_get_u16(&line.in));
    line_run(80U);
    TEST_ASSERT_UINT16_WITHIN(1U, 10U, line_count(LINK_stream)); /* 40 rows in fours */
    const line_frame_t *const f = line_last(LINK_stream);
    TEST_ASSERT_EQUAL_UINT16(8U + 16U, f->count);
    TEST_ASSERT_EQUAL_UINT16(config, f->octet[0]);
    TEST_ASSERT_EQUAL_UINT16(line_count(LINK_stream) - 1U, f->octet[2]);
    TEST_ASSERT_EQUAL_UINT16(line_count(LINK_stream) - 1U, f->seq);

    static const struct {
        uint16_t decimation, count, signal, code, field;
        float    low, high;
    } BAD[] = {{0U, 1U, 0U, LINK_NO_range, 0U, 1.0f, 65535.0f},
               {1U, 13U, 0U, LINK_NO_too_many, 13U, 0.0f, 12.0f},
               {1U, 1U, SIGNAL_COUNT, LINK_NO_index, SIGNAL_COUNT, 0.0f, (float)SIGNAL_COUNT - 1.0f},
               {1U, 2U, 0U, LINK_NO_length, 6U, 8.0f, 8.0f}};
    for (uint16_t i = 0U; i < 4U; i++) {
        w = line_begin(LINK_stream_configure);
        codec_put_u16(w, BAD[i].decimation);
        codec_put_u8(w, 0U);
        codec_put_u8(w, BAD[i].count);
        codec_put_u16(w, BAD[i].signal);
        expect_refusal(LINK_stream_configure, BAD[i].code, BAD[i].field, BAD[i].low, BAD[i].high);
    }
    w = line_begin(LINK_stream_configure);
    codec_put_u32(w, 0U); /* no signals, whatever the decimation: stop */
    TEST_ASSERT_EQUAL_HEX16(LINK_stream_configure + LINK_ANSWER, line_ask());
    line_run(5U);
    line.frames = 0U;
    line_run(300U);
    TEST_ASSERT_EQUAL_UINT16(0U, line_count(LINK_stream));
}

/* A request on a line that is full of stream is answered in the time of two frames. */
void test_requests_are_answered_while_the_line_is_full(void)
{
    codec_writer_t *w = line_begin(LINK_stream_configure);
    codec_put_u16(w, 1U);
    codec_put_u8(w, 0U);
    codec_put_u8(w, 12U);
    for (uint16_t i = 0U; i < 12U; i++) {
        codec_put_u16(w, SIGNAL_vdc_v);
    }
    TEST_ASSERT_EQUAL_HEX16(LINK_stream_configure + LINK_ANSWER, line_ask());
    line.room = 6U; /* octets a period, an eighth of what is streamed */
    line_run(2000U);
    TEST_ASSERT_TRUE(services.stream.lost > 1000U);
    const uint32_t before = services.counter;
    (void)line_begin(LINK_state);
    TEST_ASSERT_EQUAL_HEX16(LINK_state + LINK_ANSWER, line_ask());
    TEST_ASSERT_TRUE(services.counter - before < 100U);
    line.in.at = 16U;
    TEST_ASSERT_TRUE(codec_get_u32(&line.in) > 1000U);
    TEST_ASSERT_EQUAL_UINT16(0U, line.dropped);
}

/* ---- looking ----------------------------------------------------------------------------------------------------------------- */

void test_requests_read_gives_the_signals_of_now(void)
{
    codec_writer_t *w = line_begin(LINK_read);
    codec_put_u8(w, 2U);
    codec_put_u16(w, SIGNAL_vdc_v);
    codec_put_u16(w, SIGNAL_state);
    TEST_ASSERT_EQUAL_HEX16(LINK_read + LINK_ANSWER, line_ask());
    TEST_ASSERT_EQUAL_UINT32(services.counter, codec_get_u32(&line.in));
    TEST_ASSERT_EQUAL_UINT16(2U, codec_get_u8(&line.in));
    TEST_ASSERT_EQUAL_FLOAT(24.0f, codec_get_f32(&line.in));
    TEST_ASSERT_EQUAL_FLOAT(3.0f, codec_get_f32(&line.in));
    w = line_begin(LINK_read);
    codec_put_u8(w, 1U);
    codec_put_u16(w, SIGNAL_COUNT);
    expect_refusal(LINK_read, LINK_NO_index, SIGNAL_COUNT, 0.0f, (float)SIGNAL_COUNT - 1.0f);
    w = line_begin(LINK_read);
    codec_put_u8(w, 0U);
    codec_put_u16(w, 0U);
    expect_refusal(LINK_read, LINK_NO_too_many, 0U, 1.0f, 48.0f);
}

void test_requests_list_and_text_beyond_their_end_are_refused(void)
{
    static const struct {
        uint16_t kind, index;
        uint16_t field;
        float    high;
    } BAD[] = {{4U, 0U, 4U, 3.0f},
               {0U, PARAM_COUNT, PARAM_COUNT, (float)PARAM_COUNT - 1.0f},
               {1U, 0xFFFFU, 0xFFFFU, (float)SIGNAL_COUNT - 1.0f}};
    for (uint16_t i = 0U; i < 3U; i++) {
        codec_writer_t *w = line_begin(LINK_list);
        codec_put_u8(w, BAD[i].kind);
        codec_put_u16(w, BAD[i].index);
        expect_refusal(LINK_list, LINK_NO_index, BAD[i].field, 0.0f, BAD[i].high);
        w = line_begin(LINK_text);
        codec_put_u8(w, BAD[i].kind);
        codec_put_u16(w, BAD[i].index);
        codec_put_u8(w, 0U);
        codec_put_u16(w, 0U);
        expect_refusal(LINK_text, LINK_NO_index, BAD[i].field, 0.0f, BAD[i].high);
    }
    codec_writer_t *w = line_begin(LINK_text);
    codec_put_u8(w, 3U);
    codec_put_u16(w, LINK_CMD_stop);
    codec_put_u8(w, 2U);
    codec_put_u16(w, 0U);
    expect_refusal(LINK_text, LINK_NO_index, 2U, 0.0f, 1.0f);
    for (uint16_t kind = 0U; kind < 4U; kind++) { /* at its very end a text has nothing more, behind it is an error */
        w = line_begin(LINK_text);
        codec_put_u8(w, kind);
        codec_put_u16(w, 1U);
        codec_put_u8(w, 0U);
        codec_put_u16(w, 0U);
        TEST_ASSERT_EQUAL_HEX16(LINK_text + LINK_ANSWER, line_ask());
        line.in.at = 6U;
        const uint16_t total = codec_get_u16(&line.in);
        TEST_ASSERT_TRUE(total > 0U);
        w = line_begin(LINK_text);
        codec_put_u8(w, kind);
        codec_put_u16(w, 1U);
        codec_put_u8(w, 0U);
        codec_put_u16(w, (uint16_t)(total + 1U));
        expect_refusal(LINK_text, LINK_NO_index, (uint16_t)(total + 1U), 0.0f, (float)total);
    }
}

void test_requests_get_beyond_the_parameters_is_refused(void)
{
    codec_writer_t *w = line_begin(LINK_get);
    codec_put_u16(w, PARAM_COUNT - 1U);
    codec_put_u8(w, 2U);
    expect_refusal(LINK_get, LINK_NO_index, PARAM_COUNT, 0.0f, (float)PARAM_COUNT - 1.0f);
    w = line_begin(LINK_get);
    codec_put_u16(w, 0xFFFFU);
    codec_put_u8(w, 60U);
    expect_refusal(LINK_get, LINK_NO_index, 0xFFFFU, 0.0f, (float)PARAM_COUNT - 1.0f);
    w = line_begin(LINK_get);
    codec_put_u16(w, 0U);
    codec_put_u8(w, 61U);
    expect_refusal(LINK_get, LINK_NO_too_many, 61U, 1.0f, 60.0f);
}

void test_requests_timing_shows_and_forgets_the_longest(void)
{
    bench.isr_cyc = 300U; /* between two looks at the clock */
    line_run(3U);
    codec_put_u8(line_begin(LINK_timing), 1U);
    TEST_ASSERT_EQUAL_HEX16(LINK_timing + LINK_ANSWER, line_ask());
    TEST_ASSERT_EQUAL_UINT32(BENCH_CPU_HZ, codec_get_u32(&line.in));
    TEST_ASSERT_EQUAL_UINT32(BENCH_PERIOD_CYC, codec_get_u32(&line.in));
    TEST_ASSERT_TRUE(codec_get_u32(&line.in) >= 300U);
    TEST_ASSERT_TRUE(codec_get_u32(&line.in) >= 300U);
    TEST_ASSERT_EQUAL_UINT32(300U, codec_get_u32(&line.in));
    TEST_ASSERT_EQUAL_UINT32(300U, codec_get_u32(&line.in));
    TEST_ASSERT_TRUE(codec_get_u32(&line.in) >= 1200U); /* the looks of two interrupts' measurements */
    bench.isr_cyc = 10U;
    line_run(1U);
    codec_put_u8(line_begin(LINK_timing), 0U);
    (void)line_ask();
    line.in.at = 16U;
    TEST_ASSERT_EQUAL_UINT32(10U, codec_get_u32(&line.in));
    TEST_ASSERT_EQUAL_UINT32(10U, codec_get_u32(&line.in));
    TEST_ASSERT_TRUE(codec_get_u32(&line.in) < 600U); /* the look in which it was forgotten still took 300 */
}

/* ---- commands ---------------------------------------------------------------------------------------------------------------- */

void test_requests_command_that_is_none_is_refused(void)
{
    line_hello(services.schema);
    codec_put_u16(line_begin(LINK_command), LINK_COMMANDS);
    expect_refusal(LINK_command, LINK_NO_index, LINK_COMMANDS, 0.0f, (float)LINK_COMMANDS - 1.0f);
}

void test_requests_home_reaches_the_drive(void)
{
    line_hello(services.schema);
    line_command(LINK_CMD_arm);
    drive.home_wanted = false;
    line_command(LINK_CMD_home);
    TEST_ASSERT_TRUE(drive.home_wanted);
}

void test_requests_learned_table_is_saved_forgotten_and_restored(void)
{
    static float amps[20];
    line_defaults.method = DRIVE_METHOD_ARO;
    line_defaults.aro_cells = 20U;
    line_restart();
    line_hello(services.schema);
    codec_put_u16(line_begin(LINK_command), LINK_CMD_learn_restore);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_nothing_stored, line_refusal(LINK_command));
    amps[7] = 2.0f;
    TEST_ASSERT_TRUE(drive_memory_write(&drive, amps, 20U));
    line_command(LINK_CMD_learn_save);
    line_command(LINK_CMD_learn_clear);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, drive_memory_cell(&drive, 7U));
    line_command(LINK_CMD_learn_restore);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 2.0f, drive_memory_cell(&drive, 7U)); /* kept as 1/65536 A */
    TEST_ASSERT_EQUAL_FLOAT(0.0f, drive_memory_cell(&drive, 20U));
}

void test_requests_set_in_a_drive_that_was_never_built_is_refused(void)
{
    line_defaults.position_min_turn = 5.0f;
    line_defaults.position_max_turn = -5.0f;
    line_restart();
    TEST_ASSERT_EQUAL_INT(FAULT_configuration, drive.fault);
    line_hello(services.schema);
    codec_writer_t *const w = line_begin(LINK_set);
    codec_put_u8(w, 3U);
    codec_put_u8(w, 0U);
    expect_refusal(LINK_set, LINK_NO_state, DRIVE_FAULT, 0.0f, 0.0f);
    (void)line_begin(LINK_fault);
    TEST_ASSERT_EQUAL_HEX16(LINK_fault + LINK_ANSWER, line_ask());
    TEST_ASSERT_EQUAL_UINT16(FAULT_configuration, codec_get_u16(&line.in));
    TEST_ASSERT_EQUAL_UINT16(drive.fault_detail, codec_get_u16(&line.in)); /* which parameter */
}

void test_requests_set_of_too_many_is_refused(void)
{
    line_hello(services.schema);
    codec_writer_t *const w = line_begin(LINK_set);
    codec_put_u8(w, 3U);
    codec_put_u8(w, 41U);
    expect_refusal(LINK_set, LINK_NO_too_many, 41U, 0.0f, 40.0f);
}
