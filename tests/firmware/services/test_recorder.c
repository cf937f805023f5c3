/* firmware/services/recorder.c against a list of everything that was ever seen. */
#include "firmware/app/telemetry.h"
#include "firmware/services/recorder.h"
#include "unity.h"

#define ROOM 64U
#define HISTORY 400U

static recorder_t r;
static float      memory[ROOM + 1U];
static drive_t    drive;
static float      history[HISTORY]; /* signal ia_a of every period */
static uint32_t   period;

static const recorder_config_t PLAIN = {{SIGNAL_ia_a, SIGNAL_vdc_v}, 2U, 1U, 4U, 6U, RECORDER_RISING, SIGNAL_ia_a, 10.0f};

void setUp(void)
{
    recorder_init(&r, memory, ROOM);
    drive.fault = FAULT_none;
    period = 0U;
    memory[ROOM] = 1234.5f;
}

void tearDown(void) { TEST_ASSERT_EQUAL_FLOAT_MESSAGE(1234.5f, memory[ROOM], "written beyond the memory"); }

/* One period in which the current is x; the voltage tells which period it was. */
static void see(float x)
{
    drive.ia_a = x;
    drive.sample.vdc_v = (float)period;
    history[period] = x;
    recorder_sample(&r, &drive, period);
    period++;
}

static void see_many(float x, uint16_t count)
{
    for (uint16_t i = 0U; i < count; i++) {
        see(x);
    }
}

/* Rows of a complete record of PLAIN's signals, the first one of this period. */
static void expect_rows(uint32_t first, uint16_t rows, uint16_t decimation)
{
    TEST_ASSERT_EQUAL_INT(RECORDER_COMPLETE, r.status);
    TEST_ASSERT_EQUAL_UINT16(rows, recorder_rows(&r));
    TEST_ASSERT_EQUAL_UINT32(first, r.first);
    for (uint16_t k = 0U; k < rows; k++) {
        const uint32_t at = first + ((uint32_t)k * decimation);
        TEST_ASSERT_EQUAL_FLOAT(history[at], recorder_value(&r, (uint16_t)(2U * k)));
        TEST_ASSERT_EQUAL_FLOAT((float)at, recorder_value(&r, (uint16_t)((2U * k) + 1U)));
    }
}

void test_recorder_that_was_never_configured_records_nothing(void)
{
    see_many(1.0f, 20U);
    recorder_restart(&r);
    recorder_stop(&r);
    see_many(1.0f, 20U);
    TEST_ASSERT_EQUAL_INT(RECORDER_NEVER, r.status);
    TEST_ASSERT_EQUAL_UINT16(0U, recorder_rows(&r));
}

void test_recorder_keeps_what_was_before_the_edge_and_what_came_after(void)
{
    recorder_start(&r, &PLAIN);
    for (uint16_t i = 0U; i < 30U; i++) {
        see((float)i); /* passes 10 in period 10 */
    }
    expect_rows(6U, 10U, 1U);
    TEST_ASSERT_EQUAL_UINT32(10U, r.trigger_counter);
}

/* Wherever the edge comes and however the record is cut, against the list. */
void test_recorder_is_right_for_every_length_and_every_moment_of_the_trigger(void)
{
    for (uint16_t pre = 0U; pre < 9U; pre++) {
        for (uint16_t post = 1U; post < 7U; post++) {
            for (uint16_t decimation = 1U; decimation < 4U; decimation++) {
                for (uint16_t moment = (uint16_t)((pre * decimation) + 1U); moment < 60U; moment++) {
                    recorder_config_t c = PLAIN;
                    c.pre = pre;
                    c.post = post;
                    c.decimation = decimation;
                    recorder_start(&r, &c);
                    period = 0U;
                    see_many(1.0f, moment);
                    see_many(20.0f, 40U);
                    const uint32_t at =
                        (((uint32_t)moment + decimation - 1U) / decimation) * decimation; /* first row at or after it */
                    expect_rows(at - ((uint32_t)pre * decimation), (uint16_t)(pre + post), decimation);
                    TEST_ASSERT_EQUAL_UINT32(moment, r.trigger_counter);
                }
            }
        }
    }
}

void test_recorder_full_memory_is_used_to_the_last_value(void)
{
    recorder_config_t c = PLAIN;
    c.pre = 12U;
    c.post = 20U; /* 32 rows of 2: all of 64 */
    recorder_start(&r, &c);
    see_many(0.0f, 100U);
    see_many(11.0f, 20U);
    expect_rows(88U, 32U, 1U);
}

void test_recorder_edges_have_a_direction(void)
{
    static const struct {
        recorder_trigger_t trigger;
        bool               up, down;
    } CASES[] = {{RECORDER_RISING, true, false}, {RECORDER_FALLING, false, true}, {RECORDER_EITHER, true, true}};
    for (uint16_t i = 0U; i < 3U; i++) {
        for (uint16_t up = 0U; up < 2U; up++) {
            recorder_config_t c = PLAIN;
            c.trigger = CASES[i].trigger;
            recorder_start(&r, &c);
            period = 0U;
            see_many((up == 1U) ? 5.0f : 15.0f, 10U);
            see_many((up == 1U) ? 15.0f : 5.0f, 10U);
            TEST_ASSERT_EQUAL_INT(((up == 1U) ? CASES[i].up : CASES[i].down) ? RECORDER_COMPLETE : RECORDER_WAITING, r.status);
        }
    }
}

void test_recorder_level_itself_belongs_to_the_far_side(void)
{
    recorder_start(&r, &PLAIN);
    see_many(9.0f, 8U);
    see(10.0f); /* reaches the level: that is through */
    TEST_ASSERT_EQUAL_UINT32(8U, r.trigger_counter);
    recorder_restart(&r);
    period = 0U;
    see_many(10.0f, 8U); /* stands on it: no edge */
    see_many(11.0f, 8U);
    TEST_ASSERT_EQUAL_INT(RECORDER_WAITING, r.status);
}

void test_recorder_edge_before_the_rows_are_there_does_not_count(void)
{
    recorder_start(&r, &PLAIN);
    see(0.0f);
    see(20.0f); /* fewer than 4 rows yet */
    see_many(20.0f, 30U);
    TEST_ASSERT_EQUAL_INT(RECORDER_WAITING, r.status);
}

void test_recorder_value_that_is_no_number_is_no_edge(void)
{
    recorder_start(&r, &PLAIN);
    see_many(0.0f, 10U);
    see(0.0f / 0.0f);
    see(20.0f);
    see_many(20.0f, 10U);
    TEST_ASSERT_EQUAL_INT(RECORDER_WAITING, r.status);
}

void test_recorder_at_once_fills_its_rows_and_ends(void)
{
    recorder_config_t c = PLAIN;
    c.trigger = RECORDER_AT_ONCE;
    c.pre = 0U;
    recorder_start(&r, &c);
    see_many(3.0f, 6U);
    expect_rows(0U, 6U, 1U);
    see_many(4.0f, 6U); /* over: nothing changes any more */
    expect_rows(0U, 6U, 1U);
}

void test_recorder_fault_is_caught_also_before_the_rows_are_there(void)
{
    recorder_config_t c = PLAIN;
    c.trigger = RECORDER_AT_FAULT;
    recorder_start(&r, &c);
    see_many(1.0f, 2U);
    drive.fault = FAULT_over_current;
    see_many(2.0f, 10U);
    TEST_ASSERT_EQUAL_UINT16(2U, r.before);
    expect_rows(0U, 8U, 1U);
    TEST_ASSERT_EQUAL_UINT32(2U, r.trigger_counter);
}

void test_recorder_fault_that_stands_is_none_that_appears(void)
{
    recorder_config_t c = PLAIN;
    c.trigger = RECORDER_AT_FAULT;
    drive.fault = FAULT_over_current;
    recorder_start(&r, &c);
    see_many(1.0f, 20U);
    TEST_ASSERT_EQUAL_INT(RECORDER_WAITING, r.status);
    drive.fault = FAULT_none;
    see(1.0f);
    drive.fault = FAULT_over_voltage;
    see_many(1.0f, 6U);
    expect_rows(17U, 10U, 1U);
}

void test_recorder_by_hand_triggers_now_and_only_then(void)
{
    recorder_config_t c = PLAIN;
    c.trigger = RECORDER_MANUAL;
    recorder_start(&r, &c);
    see_many(1.0f, 50U);
    TEST_ASSERT_EQUAL_INT(RECORDER_WAITING, r.status);
    recorder_trigger(&r);
    see_many(2.0f, 6U);
    expect_rows(46U, 10U, 1U);
    recorder_restart(&r); /* the old request is forgotten */
    period = 0U;
    see_many(1.0f, 50U);
    TEST_ASSERT_EQUAL_INT(RECORDER_WAITING, r.status);
}

void test_recorder_stopped_stays_stopped_and_has_no_rows(void)
{
    recorder_start(&r, &PLAIN);
    see_many(0.0f, 10U);
    recorder_stop(&r);
    see_many(20.0f, 20U);
    TEST_ASSERT_EQUAL_INT(RECORDER_STOPPED, r.status);
    TEST_ASSERT_EQUAL_UINT16(0U, recorder_rows(&r));
}

void test_recorder_complete_record_survives_a_stop_and_reading(void)
{
    recorder_start(&r, &PLAIN);
    see_many(0.0f, 10U);
    see_many(20.0f, 20U);
    recorder_stop(&r);
    expect_rows(6U, 10U, 1U);
    expect_rows(6U, 10U, 1U);
}

void test_recorder_numbers_its_configurations(void)
{
    recorder_start(&r, &PLAIN);
    TEST_ASSERT_EQUAL_UINT16(1U, r.number);
    for (uint16_t i = 0U; i < 256U; i++) {
        recorder_restart(&r);
    }
    TEST_ASSERT_EQUAL_UINT16(1U, r.number); /* 8 bits on the wire */
}
