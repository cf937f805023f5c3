/* What the services keep over a reset: the rows of the black box and how the run ended, and nothing that power-up left in memory. */
#include "firmware/app/telemetry.h"
#include "tests/firmware/support/line.h"

#define ROWS (LINE_BOX_VALUES / 8U)
#define SPEED_REF 0U /* columns of the black box */
#define VDC 6U

typedef struct {
    uint16_t fault, status, rows, resets, past_fault, past_detail, past_state;
    uint32_t past_counter;
    bool     past_rows;
} report_t;

void setUp(void) { line_start(); }
void tearDown(void) {}

static report_t report(void)
{
    report_t r;
    (void)line_begin(LINK_fault);
    TEST_ASSERT_EQUAL_HEX16(LINK_fault + LINK_ANSWER, line_ask());
    r.fault = codec_get_u16(&line.in);
    (void)codec_get_u16(&line.in);
    (void)codec_get_u8(&line.in);
    (void)codec_get_u32(&line.in);
    r.status = codec_get_u8(&line.in);
    r.rows = codec_get_u16(&line.in);
    r.resets = codec_get_u8(&line.in);
    r.past_fault = codec_get_u16(&line.in);
    r.past_detail = codec_get_u16(&line.in);
    r.past_state = codec_get_u8(&line.in);
    r.past_counter = codec_get_u32(&line.in);
    r.past_rows = codec_get_u8(&line.in) != 0U;
    return r;
}

static float value(uint16_t row, uint16_t column)
{
    codec_writer_t *const w = line_begin(LINK_capture_read);
    codec_put_u8(w, SERVICES_BLACK_BOX);
    codec_put_u32(w, ((uint32_t)row * 8U) + column);
    codec_put_u8(w, 1U);
    TEST_ASSERT_EQUAL_HEX16(LINK_capture_read + LINK_ANSWER, line_ask());
    (void)codec_get_u8(&line.in);
    (void)codec_get_u8(&line.in);
    (void)codec_get_u32(&line.in);
    (void)codec_get_u8(&line.in);
    return codec_get_f32(&line.in);
}

static void run_at(float speed)
{
    line_hello(services.schema);
    line_command(LINK_CMD_arm);
    codec_writer_t *const w = line_begin(LINK_setpoint);
    codec_put_u8(w, 1U);
    codec_put_f32(w, speed);
    for (uint16_t i = 0U; i < 4U; i++) {
        codec_put_u32(w, 0U);
    }
    TEST_ASSERT_EQUAL_HEX16(LINK_setpoint + LINK_ANSWER, line_ask());
    line_command(LINK_CMD_start);
    line_run(5U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

void test_kept_a_reset_by_the_watchdog_leaves_the_last_rows_and_how_the_run_ended(void)
{
    run_at(10.0f);
    for (uint16_t k = 0U; k < 40U; k++) { /* each row is another one */
        bench.sample.vdc_v = 24.0f + (0.125f * (float)k);
        line_run(1U);
    }
    const uint32_t counter = services.counter;

    line_reset_by(HAL_RESET_WATCHDOG);

    const report_t r = report();
    TEST_ASSERT_EQUAL_UINT16(FAULT_none, r.fault);
    TEST_ASSERT_EQUAL_UINT16(RECORDER_COMPLETE, r.status);
    TEST_ASSERT_EQUAL_UINT16(ROWS - 16U, r.rows); /* those before a trigger; the 16 behind it never came */
    TEST_ASSERT_EQUAL_UINT16(1U, r.resets);
    TEST_ASSERT_TRUE(r.past_rows);
    TEST_ASSERT_EQUAL_UINT16(FAULT_none, r.past_fault);
    TEST_ASSERT_EQUAL_UINT16(DRIVE_RUN, r.past_state);
    TEST_ASSERT_EQUAL_UINT32(counter, r.past_counter);
    for (uint16_t row = 0U; row < (ROWS - 16U); row++) {
        TEST_ASSERT_EQUAL_FLOAT(24.0f + (0.125f * (float)(40U - (ROWS - 16U) + row)), value(row, VDC));
        TEST_ASSERT_EQUAL_FLOAT(10.0f, value(row, SPEED_REF));
    }
    codec_put_u8(line_begin(LINK_capture_status), SERVICES_BLACK_BOX);
    TEST_ASSERT_EQUAL_HEX16(LINK_capture_status + LINK_ANSWER, line_ask());
    for (uint16_t i = 0U; i < 6U; i++) {
        (void)codec_get_u8(&line.in);
    }
    TEST_ASSERT_EQUAL_UINT16(ROWS - 16U, codec_get_u16(&line.in)); /* before the end */
    TEST_ASSERT_EQUAL_UINT16(ROWS - 16U, codec_get_u16(&line.in)); /* in all */
    (void)codec_get_u16(&line.in);
    TEST_ASSERT_EQUAL_UINT32(counter - (ROWS - 16U), codec_get_u32(&line.in)); /* period of the first */
}

void test_kept_a_fault_before_the_reset_is_named_and_its_rows_are_the_same(void)
{
    run_at(10.0f);
    line_run(100U);
    bench.sample.vdc_v = 100.0f;
    line_run(1U);
    bench.sample.vdc_v = 24.0f;
    line_run(50U);
    const report_t before = report();
    float          kept[ROWS];
    for (uint16_t row = 0U; row < ROWS; row++) {
        kept[row] = value(row, VDC);
    }
    TEST_ASSERT_EQUAL_UINT16(ROWS, before.rows);
    TEST_ASSERT_EQUAL_UINT16(0U, before.resets);

    line_reset_by(HAL_RESET_PIN);

    const report_t r = report();
    TEST_ASSERT_EQUAL_UINT16(FAULT_over_voltage, r.past_fault);
    TEST_ASSERT_EQUAL_UINT16(DRIVE_FAULT, r.past_state);
    TEST_ASSERT_EQUAL_UINT16(ROWS, r.rows);
    for (uint16_t row = 0U; row < ROWS; row++) {
        TEST_ASSERT_EQUAL_FLOAT(kept[row], value(row, VDC));
    }
    TEST_ASSERT_EQUAL_FLOAT(100.0f, kept[ROWS - 16U]);
}

/* So many rows of the 16 behind the fault had come. */
void test_kept_a_reset_right_after_a_fault_ends_the_record_there(void)
{
    for (uint16_t after = 1U; after <= 16U; after++) {
        line_start();
        run_at(10.0f);
        line_run(100U);
        bench.sample.vdc_v = 100.0f;
        line_run(1U);
        bench.sample.vdc_v = 24.0f;
        for (uint16_t k = 1U; k < after; k++) {
            line_run(1U);
        }
        line_reset_by(HAL_RESET_WATCHDOG);
        TEST_ASSERT_EQUAL_UINT16(ROWS - 16U + after, report().rows);
        TEST_ASSERT_EQUAL_FLOAT(100.0f, value(ROWS - 16U, VDC));
        TEST_ASSERT_EQUAL_FLOAT((after > 1U) ? 24.0f : 100.0f, value((uint16_t)(ROWS - 17U + after), VDC));
    }
}

void test_kept_rows_outlive_further_resets_until_the_drive_is_started(void)
{
    run_at(10.0f);
    line_run(100U);
    for (uint16_t k = 1U; k <= 300U; k++) {
        line_reset_by(HAL_RESET_WATCHDOG);
        TEST_ASSERT_EQUAL_UINT16((k < 255U) ? k : 255U, services.past.resets);
    }
    TEST_ASSERT_EQUAL_UINT16(DRIVE_RUN, report().past_state);
    TEST_ASSERT_EQUAL_FLOAT(10.0f, value(3U, SPEED_REF));

    run_at(20.0f);

    report_t r = report();
    TEST_ASSERT_FALSE(r.past_rows);
    TEST_ASSERT_EQUAL_UINT16(DRIVE_RUN, r.past_state); /* how it ended is still known */
    TEST_ASSERT_NOT_EQUAL_UINT16(RECORDER_COMPLETE, r.status);
    line_run(100U);
    line_reset_by(HAL_RESET_WATCHDOG); /* and now of this run */
    r = report();
    TEST_ASSERT_EQUAL_UINT16(1U, r.resets);
    TEST_ASSERT_EQUAL_UINT16(ROWS - 16U, r.rows);
    TEST_ASSERT_EQUAL_FLOAT(20.0f, value(3U, SPEED_REF));
}

void test_kept_nothing_is_shown_after_power_up_though_memory_has_outlived_it(void)
{
    run_at(10.0f);
    line_run(100U);

    line_reset_by(HAL_RESET_POWER_UP);

    const report_t r = report();
    TEST_ASSERT_EQUAL_UINT16(0U, r.resets);
    TEST_ASSERT_FALSE(r.past_rows);
    TEST_ASSERT_EQUAL_UINT16(0U, r.rows);
}

void test_kept_garbage_is_never_shown_whatever_the_board_says_of_its_start(void)
{
    static const unsigned char PATTERN[] = {0x00U, 0xFFU, 0xA5U, 0x01U};
    uint32_t                   seed = 1U;
    for (int k = 0; k < 200; k++) {
        unsigned char *const octet = (unsigned char *)&services;
        for (size_t i = 0U; i < sizeof services; i++) {
            seed = (seed * 1664525U) + 1013904223U;
            octet[i] = (k < 4) ? PATTERN[k] : (unsigned char)(seed >> 24U);
        }
        line_reset_by((hal_reset_t)(k % 5));
        TEST_ASSERT_EQUAL_UINT16(0U, services.past.resets);
        TEST_ASSERT_EQUAL_UINT16(0U, report().rows);
    }
}

/* What says how the rows are to be read is under the mark: a bit of it that has changed, and they are not shown; where the ring stands is
 * not, and whatever it says no read leaves the ring. */
void test_kept_memory_with_a_changed_bit_is_refused_or_read_within_its_ring(void)
{
    static services_t good;
    run_at(10.0f);
    line_run(100U);
    good = services;
    recorder_t *const    box = &services.recorder[SERVICES_BLACK_BOX];
    unsigned char *const octet = (unsigned char *)box;
    uint32_t             refused = 0U;
    for (size_t bit = 0U; bit < (8U * sizeof *box); bit++) {
        services = good;
        octet[bit / 8U] ^= (unsigned char)(1U << (bit % 8U));
        line_reset_by(HAL_RESET_WATCHDOG);
        refused += (services.past.resets == 0U) ? 1U : 0U;
        TEST_ASSERT_TRUE(recorder_rows(box) <= ROWS);
        for (uint16_t i = 0U; i < (uint16_t)(recorder_rows(box) * 8U); i++) {
            (void)recorder_value(box, i); /* the sanitizer sees one outside */
        }
    }
    TEST_ASSERT_TRUE(refused >= (8U * sizeof box->config.signal));
    for (size_t bit = 0U; bit < 32U; bit++) {
        services = good;
        services.mark.sum ^= (uint32_t)1U << bit;
        line_reset_by(HAL_RESET_WATCHDOG);
        TEST_ASSERT_EQUAL_UINT16(0U, services.past.resets);
        services = good;
        services.mark.magic ^= (uint32_t)1U << bit;
        line_reset_by(HAL_RESET_WATCHDOG);
        TEST_ASSERT_EQUAL_UINT16(0U, services.past.resets);
    }
}

/* A black box that a client has given other signals is read with these. */
void test_kept_rows_of_another_configuration_are_read_with_it(void)
{
    line_hello(services.schema);
    codec_writer_t *const w = line_begin(LINK_capture_configure);
    codec_put_u8(w, SERVICES_BLACK_BOX);
    codec_put_u16(w, 1U);  /* every period */
    codec_put_u16(w, 20U); /* before */
    codec_put_u16(w, 4U);  /* after */
    codec_put_u8(w, RECORDER_AT_FAULT);
    codec_put_u16(w, 0U);
    codec_put_f32(w, 0.0f);
    codec_put_u8(w, 1U);
    codec_put_u16(w, SIGNAL_vdc_v);
    TEST_ASSERT_EQUAL_HEX16(LINK_capture_configure + LINK_ANSWER, line_ask());
    bench.sample.vdc_v = 25.0f;
    line_run(50U);

    line_reset_by(HAL_RESET_WATCHDOG);

    TEST_ASSERT_EQUAL_UINT16(20U, report().rows);
    TEST_ASSERT_EQUAL_UINT16(1U, services.recorder[SERVICES_BLACK_BOX].config.count);
    TEST_ASSERT_EQUAL_FLOAT(25.0f, recorder_value(&services.recorder[SERVICES_BLACK_BOX], 19U));
}
