/* The bench link of the simulated drive: what comes over it is what the simulator itself records. */
#include <math.h>
#include <string.h>

#include "firmware/link/frame.h"
#include "firmware/link/protocol.h"
#include "sim_host/capi/evenspin_capi.h"
#include "unity.h"

#define SIGNALS 8
#define ROWS_MAX 100000
#define LINE_OCTETS_PER_MS 62 /* 625000 baud, 10 bits an octet: 62.5 */

static es_sim_t       *sim;
static frame_decoder_t decoder;
static frame_t         request;
static uint16_t        seq;
static double          record[ROWS_MAX][SIGNALS];
static int64_t         rows;
static float           streamed[ROWS_MAX / 10][SIGNALS];
static uint32_t        stream_rows, stream_next, stream_gaps, frames_bad;
static uint16_t        chosen[SIGNALS];
static uint16_t        answer_type;
static codec_reader_t  answer;
static uint16_t        answer_octets[FRAME_PAYLOAD_MAX];

static const char *const NAMES[SIGNALS] = {
    "speed_ref_rad_s", "speed_rad_s", "theta_m_rad", "iq_ref_a", "iq_a", "ia_a", "vq_v", "vdc_v"};

static uint16_t number_of(const char *signal)
{
    es_field_t f;
    for (int i = 0; i < es_signal_count(); i++) {
        if (es_signal_info(i, &f) && (strcmp(f.name, signal) == 0)) {
            return (uint16_t)i;
        }
    }
    TEST_FAIL_MESSAGE(signal);
    return 0U;
}

static void keep_stream(codec_reader_t r)
{
    (void)codec_get_u8(&r);
    const uint16_t n = codec_get_u8(&r);
    (void)codec_get_u16(&r);
    uint32_t counter = codec_get_u32(&r);
    for (uint16_t k = 0U; k < n; k++, counter += 10U) {
        stream_gaps += ((stream_rows > 0U) && (counter != stream_next)) ? 1U : 0U;
        stream_next = counter + 10U;
        for (int i = 0; i < SIGNALS; i++) {
            const float x = codec_get_f32(&r);
            if (counter / 10U < ROWS_MAX / 10U) {
                streamed[counter / 10U][i] = x;
            }
        }
        stream_rows++;
    }
}

/* One millisecond of drive and line. */
static void millisecond(void)
{
    uint8_t       octets[2 * LINE_OCTETS_PER_MS];
    const int64_t room = (rows + 10 <= ROWS_MAX) ? 10 : 0;
    rows += es_sim_run(sim, 10, 1, (room > 0) ? &record[rows][0] : NULL, room);
    const int n = es_sim_link_read(sim, octets, LINE_OCTETS_PER_MS);
    for (int i = 0; i < n; i++) {
        const frame_event_t e = frame_decode(&decoder, octets[i]);
        frames_bad += (e == FRAME_DROPPED) ? 1U : 0U;
        if (e != FRAME_GOOD) {
            continue;
        }
        if (frame_type(&decoder) == LINK_stream) {
            keep_stream(frame_payload(&decoder));
        } else if (frame_type(&decoder) >= LINK_ANSWER) {
            codec_reader_t r = frame_payload(&decoder);
            answer_type = frame_type(&decoder);
            for (uint16_t k = 0U; k < r.count; k++) {
                answer_octets[k] = codec_get_u8(&r);
            }
            answer = codec_reader(answer_octets, r.count);
        }
    }
}

static void milliseconds(uint32_t n)
{
    for (uint32_t i = 0U; i < n; i++) {
        millisecond();
    }
}

static codec_writer_t *begin(uint16_t type)
{
    frame_begin(&request, type, seq++);
    return &request.payload;
}

static void ask(void)
{
    uint16_t       wire[FRAME_WIRE_MAX];
    uint8_t        octets[FRAME_WIRE_MAX];
    const uint16_t type = request.octets[0];
    const uint16_t n = frame_end(&request, wire);
    for (uint16_t i = 0U; i < n; i++) {
        octets[i] = (uint8_t)wire[i];
    }
    TEST_ASSERT_EQUAL_INT(n, es_sim_link_write(sim, octets, n));
    answer_type = 0U;
    for (int k = 0; (k < 100) && (answer_type == 0U); k++) {
        millisecond();
    }
    TEST_ASSERT_EQUAL_HEX16(type + LINK_ANSWER, answer_type);
}

static void command(uint16_t which)
{
    codec_put_u16(begin(LINK_command), which);
    ask();
}

static void reference(float speed)
{
    codec_writer_t *const w = begin(LINK_setpoint);
    codec_put_u8(w, 1U);
    codec_put_f32(w, speed);
    codec_put_f32(w, 0.0f);
    codec_put_f32(w, 0.0f);
    codec_put_u32(w, 0U);
    codec_put_f32(w, 0.0f);
    ask();
}

static uint16_t param_of(const char *name)
{
    es_field_t f;
    int        k = 0;
    while (es_param_info(k, &f) && (strcmp(f.name, name) != 0)) {
        k++;
    }
    return (uint16_t)k;
}

void setUp(void)
{
    sim = es_sim_new();
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "offset_calibration_periods", 0.0));
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "align_periods", 0.0));
    TEST_ASSERT_TRUE(es_sim_record(sim, NAMES, SIGNALS));
    for (int i = 0; i < SIGNALS; i++) {
        chosen[i] = number_of(NAMES[i]);
    }
    frame_decoder_reset(&decoder);
    rows = 0;
    stream_rows = 0U;
    stream_gaps = 0U;
    frames_bad = 0U;
    seq = 0U;
}

void tearDown(void) { es_sim_free(sim); }

static void connect_and_run(float speed)
{
    TEST_ASSERT_TRUE(es_sim_link_open(sim));
    TEST_ASSERT_TRUE_MESSAGE(es_sim_start(sim), es_sim_error(sim)->name);
    codec_writer_t *const w = begin(LINK_hello);
    codec_put_u16(w, LINK_VERSION);
    codec_put_u32(w, es_schema_hash());
    ask();
    command(LINK_CMD_arm);
    reference(speed);
    codec_put_u16(begin(LINK_timeout), 0U);
    ask();
    command(LINK_CMD_start);
}

static void stream_eight(void)
{
    codec_writer_t *const w = begin(LINK_stream_configure);
    codec_put_u16(w, 10U);
    codec_put_u8(w, 0U);
    codec_put_u8(w, SIGNALS);
    for (int i = 0; i < SIGNALS; i++) {
        codec_put_u16(w, chosen[i]);
    }
    ask();
}

void test_link_captures_exactly_what_the_simulator_records(void)
{
    connect_and_run(10.0f);
    codec_writer_t *w = begin(LINK_capture_configure);
    codec_put_u8(w, 0U);
    codec_put_u16(w, 1U);
    codec_put_u16(w, 200U);
    codec_put_u16(w, 567U); /* together 767: all there is */
    codec_put_u8(w, 1U);    /* rising */
    codec_put_u16(w, number_of("speed_rad_s"));
    codec_put_f32(w, 20.0f);
    codec_put_u8(w, SIGNALS);
    for (int i = 0; i < SIGNALS; i++) {
        codec_put_u16(w, chosen[i]);
    }
    ask();
    milliseconds(200U);
    reference(40.0f);
    milliseconds(400U);

    codec_put_u8(begin(LINK_capture_status), 0U);
    ask();
    answer.at = 2U;
    TEST_ASSERT_EQUAL_UINT16(4U, codec_get_u8(&answer)); /* complete */
    answer.at = 12U;
    const uint32_t first = codec_get_u32(&answer);
    const uint32_t trigger = codec_get_u32(&answer);
    TEST_ASSERT_EQUAL_UINT32(first + 200U, trigger);
    TEST_ASSERT_TRUE(record[trigger - 1U][1] < 20.0);
    TEST_ASSERT_TRUE(record[trigger][1] >= 20.0);
    for (uint32_t offset = 0U; offset < 767U * SIGNALS; offset += 60U) {
        w = begin(LINK_capture_read);
        codec_put_u8(w, 0U);
        codec_put_u32(w, offset);
        codec_put_u8(w, 60U);
        ask();
        answer.at = 2U;
        TEST_ASSERT_EQUAL_UINT32(offset, codec_get_u32(&answer));
        const uint16_t n = codec_get_u8(&answer);
        TEST_ASSERT_EQUAL_UINT16((767U * SIGNALS - offset < 60U) ? 767U * SIGNALS - offset : 60U, n);
        for (uint16_t i = 0U; i < n; i++) {
            const uint32_t at = offset + i;
            TEST_ASSERT_TRUE((double)codec_get_f32(&answer) == record[first + (at / SIGNALS)][at % SIGNALS]); /* to the bit */
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0U, frames_bad);
}

/* Ten minutes; one with sanitizers, which have seen every line by then and take ten times as long. */
#ifdef __SANITIZE_ADDRESS__
#define STREAM_MS 60000U
#else
#define STREAM_MS 600000U
#endif

void test_link_streams_eight_signals_at_1_khz_over_625000_baud_for_ten_minutes_without_losing_a_row(void)
{
    connect_and_run(30.0f);
    stream_eight();
    milliseconds(STREAM_MS);
    TEST_ASSERT_EQUAL_UINT32(0U, stream_gaps);
    TEST_ASSERT_EQUAL_UINT32(0U, frames_bad);
    TEST_ASSERT_UINT32_WITHIN(20U, STREAM_MS, stream_rows); /* up to two frames are on their way */
    TEST_ASSERT_EQUAL_INT64(ROWS_MAX, rows);
    for (uint32_t k = stream_next / 10U - stream_rows; k < ROWS_MAX / 10U; k++) { /* of the first ten seconds every value */
        for (int i = 0; i < SIGNALS; i++) {
            TEST_ASSERT_TRUE((double)streamed[k][i] == record[10U * k][i]);
        }
    }
    (void)begin(LINK_state); /* and others are answered meanwhile */
    ask();
    answer.at = 16U;
    TEST_ASSERT_EQUAL_UINT32(0U, codec_get_u32(&answer)); /* stream_lost */
}

void test_link_that_is_silent_stops_the_drive(void)
{
    connect_and_run(30.0f);
    codec_put_u16(begin(LINK_timeout), 200U);
    ask();
    milliseconds(190U);
    TEST_ASSERT_EQUAL_DOUBLE(4.0, es_sim_read(sim, "state"));
    milliseconds(15U);
    TEST_ASSERT_EQUAL_DOUBLE(3.0, es_sim_read(sim, "state"));
}

/* auto_run as a board has it: stored, by a drive of before. */
static void store_auto_run(void)
{
    static uint16_t words[100000];
    connect_and_run(0.0f);
    command(LINK_CMD_stop);
    milliseconds(2U);
    codec_writer_t *const w = begin(LINK_set);
    codec_put_u8(w, 3U);
    codec_put_u8(w, 1U);
    uint16_t   auto_run = 0U;
    es_field_t f;
    while (es_param_info((int)auto_run, &f) && (strcmp(f.name, "auto_run") != 0)) {
        auto_run++;
    }
    codec_put_u16(w, auto_run);
    codec_put_f32(w, 1.0f);
    ask();
    milliseconds(5U);
    command(LINK_CMD_save);
    milliseconds(100U);
    const int count = es_sim_storage_read(sim, words, 100000);
    tearDown();
    setUp();
    TEST_ASSERT_TRUE(es_sim_storage_write(sim, words, count));
}

/* 0.2 s: the timeout of the link is longer */
void test_link_changes_nothing_about_the_drive(void)
{
    static double without[2000][SIGNALS];
    store_auto_run();
    es_sim_t *const other = es_sim_new();
    TEST_ASSERT_TRUE(es_sim_set_param(other, "offset_calibration_periods", 0.0));
    TEST_ASSERT_TRUE(es_sim_set_param(other, "align_periods", 0.0));
    for (int k = 0; k < 2; k++) {
        es_sim_t *const s = (k == 0) ? other : sim;
        const double    t = 0.05;
        const double    speed = 25.0;
        TEST_ASSERT_TRUE(es_sim_set_param(s, "auto_run", (k == 0) ? 1.0 : 0.0));
        TEST_ASSERT_TRUE(es_sim_set_input(s, "speed_ref_rad_s", &t, &speed, 1, false));
        TEST_ASSERT_TRUE(es_sim_record(s, NAMES, SIGNALS));
        TEST_ASSERT_TRUE((k == 0) || es_sim_link_open(s));
        TEST_ASSERT_TRUE(es_sim_start(s));
        TEST_ASSERT_EQUAL_INT64(2000, es_sim_run(s, 2000, 1, (k == 0) ? &without[0][0] : &record[0][0], 2000));
    }
    es_sim_free(other);
    TEST_ASSERT_EQUAL_MEMORY(without, record, sizeof without);
}

void test_link_keeps_the_storage_that_was_given_and_erases_it_otherwise(void)
{
    static uint16_t words[100000];
    connect_and_run(0.0f);
    command(LINK_CMD_stop);
    milliseconds(2U);
    codec_writer_t *const w = begin(LINK_set);
    codec_put_u8(w, 3U);
    codec_put_u8(w, 1U);
    codec_put_u16(w, param_of("current_kp_v_per_a"));
    codec_put_f32(w, 0.5f);
    ask();
    command(LINK_CMD_save);
    const int n = es_sim_storage_read(sim, words, 100000);
    for (int kept = 1; kept >= 0; kept--) {
        es_sim_t *const next = es_sim_new();
        TEST_ASSERT_TRUE(es_sim_link_open(next));
        TEST_ASSERT_FALSE(es_sim_storage_write(next, words, n - 1));
        TEST_ASSERT_TRUE((kept == 0) || es_sim_storage_write(next, words, n));
        TEST_ASSERT_TRUE(es_sim_start(next));
        static uint16_t now[100000];
        (void)es_sim_storage_read(next, now, n);
        TEST_ASSERT_EQUAL_INT((kept == 1) ? 0 : 1, memcmp(now, words, (size_t)n * sizeof now[0]) != 0);
        es_sim_free(next);
    }
}

void test_link_without_being_opened_takes_and_gives_nothing(void)
{
    uint8_t octet = 0U;
    TEST_ASSERT_EQUAL_INT(0, es_sim_link_write(sim, &octet, 1));
    TEST_ASSERT_TRUE(es_sim_start(sim));
    TEST_ASSERT_EQUAL_INT(0, es_sim_link_write(sim, &octet, 1));
    TEST_ASSERT_EQUAL_INT(0, es_sim_link_read(sim, &octet, 1));
    TEST_ASSERT_FALSE(es_sim_link_open(sim)); /* too late */
    TEST_ASSERT_FALSE(es_sim_link_open(NULL));
    TEST_ASSERT_EQUAL_INT(0, es_sim_link_write(NULL, &octet, 1));
    TEST_ASSERT_EQUAL_INT(0, es_sim_link_read(NULL, &octet, 1));
}
