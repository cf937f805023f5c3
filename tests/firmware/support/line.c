#include "tests/firmware/support/line.h"

#include "mock_hal_link.h"

line_t         line;
services_t     services;
drive_params_t line_defaults;
hal_reset_t    line_reset = HAL_RESET_POWER_UP;

static frame_decoder_t decoder;
static float           capture[LINE_CAPTURE_VALUES], black_box[LINE_BOX_VALUES];

static uint16_t link_read(uint16_t *octets, uint16_t limit, int calls)
{
    (void)calls;
    uint16_t n = 0U;
    while ((n < limit) && (line.read < line.sent)) {
        octets[n] = line.to_drive[line.read % LINE_OCTETS];
        line.read++;
        n++;
    }
    line.reads_per_pass = (uint16_t)(line.reads_per_pass + n);
    return n;
}

static void keep_frame(void)
{
    if (line.frames >= LINE_FRAMES) { /* the newest ones */
        (void)memmove(&line.frame[0], &line.frame[1], (LINE_FRAMES - 1U) * sizeof line.frame[0]);
        line.frames--;
    }
    line_frame_t *const f = &line.frame[line.frames++];
    codec_reader_t      r = frame_payload(&decoder);
    f->type = frame_type(&decoder);
    f->seq = frame_seq(&decoder);
    f->count = r.count;
    for (uint16_t i = 0U; i < r.count; i++) {
        f->octet[i] = codec_get_u8(&r);
    }
}

static uint16_t link_write(const uint16_t *octets, uint16_t count, int calls)
{
    (void)calls;
    const uint16_t n = (count < line.room) ? count : line.room;
    for (uint16_t i = 0U; i < n; i++) {
        TEST_ASSERT_TRUE_MESSAGE(octets[i] <= 0xFFU, "more than an octet");
        const frame_event_t e = frame_decode(&decoder, octets[i]);
        line.dropped = (uint16_t)(line.dropped + ((e == FRAME_DROPPED) ? 1U : 0U));
        if (e == FRAME_GOOD) {
            keep_frame();
        }
    }
    return n;
}

static uint32_t link_lost(int calls)
{
    (void)calls;
    return 0U;
}

static void start(void)
{
    static const line_t    nothing;
    const services_setup_t setup = {&drive,    &line_defaults,      "test board",    capture,
                                    black_box, LINE_CAPTURE_VALUES, LINE_BOX_VALUES, line_reset};
    line = nothing;
    line.room = FRAME_WIRE_MAX;
    frame_decoder_reset(&decoder);
    hal_link_read_Stub(link_read);
    hal_link_write_Stub(link_write);
    hal_link_lost_Stub(link_lost);
    services_start(&services, &setup);
    line_run(2U);
}

void line_restart(void)
{
    (void)memset(&services, 0x5A, sizeof services); /* nothing may depend on what memory holds at power-up */
    start();
}

void line_reset_by(hal_reset_t cause)
{
    line_reset = cause;
    start();
}

void line_start(void)
{
    bench_start();
    flash_start();
    line_defaults = bench_params();
    line_defaults.auto_run = 0U;
    line_reset = HAL_RESET_POWER_UP;
    line_restart();
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
}

void line_run(uint32_t periods)
{
    for (uint32_t k = 0U; k < periods; k++) {
        bench_period();
        services_sample(&services);
        drive_background(&drive);
        line.reads_per_pass = 0U;
        services_pass(&services);
        if (line.reads_per_pass > line.most_reads_per_pass) {
            line.most_reads_per_pass = line.reads_per_pass;
        }
    }
}

codec_writer_t *line_begin(uint16_t type)
{
    line.seq = (line.seq + 1U) & 0xFFU;
    frame_begin(&line.request, type, line.seq);
    return &line.request.payload;
}

void line_send(const uint16_t *octets, uint16_t count)
{
    for (uint16_t i = 0U; i < count; i++) {
        line.to_drive[line.sent % LINE_OCTETS] = octets[i];
        line.sent++;
    }
}

uint16_t line_ask(void)
{
    uint16_t       wire[FRAME_WIRE_MAX];
    const uint16_t asked = line.request.octets[0];
    line_send(wire, frame_end(&line.request, wire));
    for (int k = 0; k < 100; k++) {
        line_run(1U);
        for (uint16_t i = 0U; i < line.frames; i++) {
            const line_frame_t *const f = &line.frame[i];
            if ((f->seq == line.seq) && ((f->type == asked + LINK_ANSWER) || (f->type == LINK_refused))) {
                line.answer = *f;
                line.in = codec_reader(line.answer.octet, line.answer.count);
                line.frames = (uint16_t)(line.frames - 1U);
                (void)memmove(&line.frame[i], &line.frame[i + 1U], (line.frames - i) * sizeof line.frame[0]);
                return line.answer.type;
            }
        }
    }
    return 0U;
}

void line_hello(uint32_t schema)
{
    codec_writer_t *const w = line_begin(LINK_hello);
    codec_put_u16(w, LINK_VERSION);
    codec_put_u32(w, schema);
    TEST_ASSERT_EQUAL_HEX16(LINK_hello + LINK_ANSWER, line_ask());
}

void line_command(uint16_t command)
{
    codec_put_u16(line_begin(LINK_command), command);
    TEST_ASSERT_EQUAL_HEX16(LINK_command + LINK_ANSWER, line_ask());
    TEST_ASSERT_EQUAL_UINT16(command, codec_get_u16(&line.in));
}

void line_set(uint16_t param, float value)
{
    codec_writer_t *const w = line_begin(LINK_set);
    codec_put_u8(w, 3U);
    codec_put_u8(w, 1U);
    codec_put_u16(w, param);
    codec_put_f32(w, value);
    TEST_ASSERT_EQUAL_HEX16(LINK_set + LINK_ANSWER, line_ask());
}

const line_frame_t *line_last(uint16_t type)
{
    for (uint16_t i = line.frames; i > 0U; i--) {
        if (line.frame[i - 1U].type == type) {
            return &line.frame[i - 1U];
        }
    }
    return NULL;
}

uint16_t line_count(uint16_t type)
{
    uint16_t n = 0U;
    for (uint16_t i = 0U; i < line.frames; i++) {
        n = (uint16_t)(n + ((line.frame[i].type == type) ? 1U : 0U));
    }
    return n;
}

uint16_t line_refusal(uint16_t type)
{
    TEST_ASSERT_EQUAL_HEX16_MESSAGE(LINK_refused, line_ask(), "not refused");
    TEST_ASSERT_EQUAL_UINT16(12U, line.answer.count);
    TEST_ASSERT_EQUAL_HEX16(type, codec_get_u8(&line.in));
    return codec_get_u8(&line.in);
}
