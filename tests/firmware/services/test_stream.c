/* firmware/services/stream.c: every row once, in order, with its counter; what found no room is counted and leaves a gap. */
#include "firmware/app/telemetry.h"
#include "firmware/services/stream.h"
#include "unity.h"

static stream_t       s;
static drive_t        drive;
static uint16_t       octets[248];
static codec_writer_t w;
static uint32_t       now; /* the next period */

static const uint16_t EIGHT[8] = {SIGNAL_ia_a, SIGNAL_vdc_v, SIGNAL_ib_a, SIGNAL_ia_a,
                                  SIGNAL_ia_a, SIGNAL_ia_a,  SIGNAL_ia_a, SIGNAL_ib_a};

typedef struct {
    uint16_t       config, rows, frame;
    uint32_t       counter;
    codec_reader_t values;
} got_t;

void setUp(void)
{
    stream_init(&s);
    now = 0U;
}

void tearDown(void) {}

static void run(uint32_t periods)
{
    for (uint32_t i = 0U; i < periods; i++) {
        drive.ia_a = (float)now;
        drive.ib_a = -(float)now;
        drive.sample.vdc_v = 24.0f;
        stream_sample(&s, &drive, now);
        now++;
    }
}

static bool take(got_t *got)
{
    w = codec_writer(octets, 248U);
    if (!stream_take(&s, now, &w)) {
        TEST_ASSERT_EQUAL_UINT16(0U, w.at);
        return false;
    }
    TEST_ASSERT_FALSE_MESSAGE(w.over, "longer than a frame");
    got->values = codec_reader(octets, w.at);
    got->config = codec_get_u8(&got->values);
    got->rows = codec_get_u8(&got->values);
    got->frame = codec_get_u16(&got->values);
    got->counter = codec_get_u32(&got->values);
    return true;
}

void test_stream_sends_nothing_before_it_is_asked(void)
{
    got_t got;
    run(1000U);
    TEST_ASSERT_FALSE(take(&got));
}

void test_stream_of_eight_signals_loses_no_row_and_keeps_their_order(void)
{
    got_t    got;
    uint32_t expected = 0U;
    uint16_t frame = 0U;
    stream_configure(&s, EIGHT, 8U, 10U, 0U);
    for (uint32_t pass = 0U; pass < 20000U; pass++) { /* 2 s, across many turns of the ring */
        run(1U);
        if (take(&got)) {
            TEST_ASSERT_EQUAL_UINT32(expected, got.counter);
            TEST_ASSERT_EQUAL_UINT16(frame, got.frame);
            TEST_ASSERT_EQUAL_UINT16(7U, got.rows); /* 224 of 240 octets */
            for (uint16_t row = 0U; row < got.rows; row++) {
                for (uint16_t i = 0U; i < 8U; i++) {
                    const float value =
                        (EIGHT[i] == SIGNAL_vdc_v) ? 24.0f : ((EIGHT[i] == SIGNAL_ib_a) ? -(float)expected : (float)expected);
                    TEST_ASSERT_EQUAL_FLOAT(value, codec_get_f32(&got.values));
                }
                expected += 10U;
            }
            TEST_ASSERT_EQUAL_UINT16(got.values.count, got.values.at);
            frame++;
        }
    }
    TEST_ASSERT_EQUAL_UINT32(19950U, expected); /* 285 frames of 7; 5 rows wait */
    TEST_ASSERT_EQUAL_UINT32(0U, s.lost);
}

void test_stream_rows_lie_on_multiples_of_the_decimation(void)
{
    got_t got;
    run(1237U);
    stream_configure(&s, EIGHT, 1U, 100U, 1U);
    run(200U);
    TEST_ASSERT_TRUE(take(&got));
    TEST_ASSERT_EQUAL_UINT32(1300U, got.counter);
    TEST_ASSERT_TRUE(take(&got));
    TEST_ASSERT_EQUAL_UINT32(1400U, got.counter);
    TEST_ASSERT_FALSE(take(&got));
}

void test_stream_row_waits_at_most_20_ms_for_company(void)
{
    got_t got;
    stream_configure(&s, EIGHT, 2U, 60U, 0U);
    run(199U);
    TEST_ASSERT_FALSE(take(&got));
    run(1U);
    TEST_ASSERT_TRUE(take(&got));
    TEST_ASSERT_EQUAL_UINT16(4U, got.rows);
    TEST_ASSERT_FALSE(take(&got));
}

void test_stream_that_nobody_takes_drops_the_newest_counts_them_and_shows_the_gap(void)
{
    got_t    got;
    uint32_t rows = 0U;
    stream_configure(&s, EIGHT, 8U, 1U, 0U);
    run(200U); /* room for 128 */
    TEST_ASSERT_EQUAL_UINT32(72U, s.lost);
    TEST_ASSERT_TRUE(take(&got)); /* makes room for 7 */
    rows += got.rows;
    run(10U);
    TEST_ASSERT_EQUAL_UINT32(75U, s.lost);
    bool     gap = false;
    uint32_t next = 7U;
    while (take(&got)) {
        if (got.counter != next) {
            TEST_ASSERT_EQUAL_UINT32(128U, next);        /* where the ring was full... */
            TEST_ASSERT_EQUAL_UINT32(200U, got.counter); /* ...to where there was room again: in a frame of its own */
            gap = true;
        }
        next = got.counter + got.rows;
        rows += got.rows;
    }
    TEST_ASSERT_TRUE(gap);
    TEST_ASSERT_EQUAL_UINT32(128U + 7U, rows + (uint32_t)(uint16_t)(s.written - s.taken));
}

void test_stream_frame_has_as_many_rows_as_were_asked_and_fit(void)
{
    static const struct {
        uint16_t count, rows, expected;
    } CASES[] = {{8U, 0U, 7U}, {8U, 3U, 3U}, {8U, 200U, 7U}, {12U, 0U, 5U}, {1U, 0U, 60U}, {1U, 255U, 60U}};
    uint16_t twelve[12] = {0U};
    for (uint16_t i = 0U; i < 6U; i++) {
        stream_configure(&s, twelve, CASES[i].count, 1U, CASES[i].rows);
        TEST_ASSERT_EQUAL_UINT16(CASES[i].expected, s.frame_rows);
        TEST_ASSERT_TRUE((uint32_t)s.rows * CASES[i].count <= STREAM_VALUES);
        got_t got;
        run(100U);
        TEST_ASSERT_TRUE(take(&got));
        TEST_ASSERT_EQUAL_UINT16(CASES[i].expected, got.rows);
    }
}

void test_stream_of_another_configuration_has_another_number_and_none_of_the_old_rows(void)
{
    got_t got;
    stream_configure(&s, EIGHT, 1U, 1U, 1U);
    run(10U);
    const uint16_t before = s.config;
    stream_configure(&s, EIGHT, 2U, 1U, 1U);
    run(1U);
    TEST_ASSERT_TRUE(take(&got));
    TEST_ASSERT_EQUAL_UINT16(before + 1U, got.config);
    TEST_ASSERT_EQUAL_UINT32(10U, got.counter);
    TEST_ASSERT_EQUAL_UINT16(0U, got.frame);
}

void test_stream_goes_on_over_the_wrap_of_the_counter(void)
{
    got_t got;
    now = UINT32_C(0xFFFFFFFC);
    stream_configure(&s, EIGHT, 1U, 1U, 8U);
    run(8U);
    TEST_ASSERT_TRUE(take(&got));
    TEST_ASSERT_EQUAL_UINT16(8U, got.rows);
    TEST_ASSERT_EQUAL_UINT32(UINT32_C(0xFFFFFFFC), got.counter);
}
