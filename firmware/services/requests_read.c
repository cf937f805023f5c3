/* Requests that only read: allowed for any client, whatever its schema. */
#include <stddef.h>

#include "firmware/app/telemetry.h"
#include "firmware/services/internal.h"
#include "firmware/services/schema.h"
#include "hal/hal_clock.h"
#include "hal/hal_link.h"

#ifndef EVENSPIN_VERSION
#define EVENSPIN_VERSION "0"
#endif
#ifdef EVENSPIN_FIXED
#define NUMERIC 1U
#else
#define NUMERIC 0U
#endif
#define GET_MOST 60U
#define READ_MOST 48U
#define TEXT_MOST 240U

link_refusal_t request_hello(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    session_t *const n = &s->session;
    const uint16_t   version = codec_get_u16(in);
    const uint32_t   schema = codec_get_u32(in);
    const bool       started = n->started;
    const session_t  fresh = {.greeted = true,
                              .may_write = (version == LINK_VERSION) && (schema == s->schema),
                              .started = started, /* a drive that runs goes on until its timeout */
                              .by_itself = n->by_itself,
                              .timed_out = n->timed_out,
                              .timeout_ms = SERVICES_TIMEOUT_MS,
                              .alive_at = n->alive_at,
                              .storing_seq = n->storing_seq,
                              .storing = n->storing,
                              .stored = n->stored,
                              .stored_status = n->stored_status};
    *n = fresh;
    stream_configure(&s->stream, s->stream.signal, 0U, 1U, 0U);

    codec_put_u16(out, LINK_VERSION);
    codec_put_u32(out, s->schema);
    codec_put_u8(out, n->may_write ? 1U : 0U);
    codec_put_u8(out, NUMERIC);
    codec_put_u32(out, DRIVE_PWM_HZ);
    codec_put_u32(out, hal_clock_hz());
    codec_put_u16(out, FRAME_PAYLOAD_MAX);
    for (uint16_t kind = 0U; kind < (uint16_t)SCHEMA_KINDS; kind++) {
        codec_put_u16(out, schema_count(kind));
    }
    codec_put_u8(out, STREAM_SIGNALS);
    codec_put_u8(out, RECORDER_SIGNALS);
    codec_put_u8(out, SERVICES_RECORDERS);
    for (uint16_t i = 0U; i < SERVICES_RECORDERS; i++) {
        codec_put_u32(out, s->recorder[i].values);
    }
    codec_put_u8(out, param_store_present() ? 1U : 0U);
    codec_put_u16(out, n->timeout_ms);
    codec_put_u32(out, s->counter);
    codec_put_str(out, s->setup.board);
    codec_put_str(out, EVENSPIN_VERSION);
    return LINK_FINE;
}

link_refusal_t request_list(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    const uint16_t kind = codec_get_u8(in);
    const uint16_t first = codec_get_u16(in);
    link_refusal_t no = services_index(s, kind, SCHEMA_KINDS);
    if (no == LINK_FINE) {
        no = services_index(s, first, schema_count(kind));
    }
    if (no != LINK_FINE) {
        return no;
    }
    codec_put_u8(out, kind);
    codec_put_u16(out, first);
    uint16_t *const count = &out->octets[out->at];
    codec_put_u8(out, 0U);
    for (uint16_t i = first; i < schema_count(kind); i++) {
        const uint16_t before = out->at;
        schema_record(kind, i, out);
        if (out->over) { /* it waits for the next answer */
            out->at = before;
            out->over = false;
            break;
        }
        (*count)++;
    }
    return LINK_FINE;
}

link_refusal_t request_text(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    const uint16_t kind = codec_get_u8(in);
    const uint16_t index = codec_get_u16(in);
    const uint16_t part = codec_get_u8(in);
    const uint16_t offset = codec_get_u16(in);
    link_refusal_t no = services_index(s, kind, SCHEMA_KINDS);
    if (no == LINK_FINE) {
        no = services_index(s, index, schema_count(kind));
    }
    if (no == LINK_FINE) {
        no = services_index(s, part, 2U);
    }
    if (no != LINK_FINE) {
        return no;
    }
    const char *const text = schema_text(kind, index, part);
    uint16_t          total = 0U;
    if (text == NULL) {
        return LINK_NO_unsupported; /* this firmware carries none: the client has them */
    }
    while (text[total] != '\0') {
        total++;
    }
    no = services_index(s, offset, (uint16_t)(total + 1U));
    if (no != LINK_FINE) {
        return no;
    }
    codec_put_u8(out, kind);
    codec_put_u16(out, index);
    codec_put_u8(out, part);
    codec_put_u16(out, offset);
    codec_put_u16(out, total);
    const uint16_t end = ((uint16_t)(total - offset) < TEXT_MOST) ? total : (uint16_t)(offset + TEXT_MOST);
    for (uint16_t i = offset; i < end; i++) {
        codec_put_u8(out, (uint16_t)text[i]);
    }
    return LINK_FINE;
}

link_refusal_t request_state(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    (void)in;
    const drive_t *const d = s->setup.drive;
    codec_put_u32(out, s->counter);
    codec_put_u8(out, (uint16_t)drive_state(d));
    codec_put_u8(out, (uint16_t)drive_newest_command(d)->mode);
    codec_put_u16(out, (uint16_t)drive_fault(d));
    codec_put_u16(out, drive_fault_detail(d));
    codec_put_u16(out, services_flags(s));
    codec_put_u32(out, drive_rejected(d));
    codec_put_u32(out, s->stream.lost);
    codec_put_u32(out, s->frames_bad);
    codec_put_u32(out, hal_link_lost());
    return LINK_FINE;
}

link_refusal_t request_alive(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    (void)in;
    codec_put_u32(out, s->counter);
    codec_put_u8(out, (uint16_t)drive_state(s->setup.drive));
    codec_put_u16(out, (uint16_t)drive_fault(s->setup.drive));
    codec_put_u16(out, services_flags(s));
    return LINK_FINE;
}

link_refusal_t request_read(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    const uint16_t count = codec_get_u8(in);
    if ((count == 0U) || (count > READ_MOST)) {
        return services_refuse(s, LINK_NO_too_many, count, 1.0f, (float)READ_MOST);
    }
    link_refusal_t no = services_length(s, in, (uint16_t)(1U + (2U * count)));
    if (no != LINK_FINE) {
        return no;
    }
    codec_put_u32(out, s->counter);
    codec_put_u8(out, count);
    for (uint16_t i = 0U; i < count; i++) {
        const uint16_t signal = codec_get_u16(in);
        no = services_index(s, signal, SIGNAL_COUNT);
        if (no != LINK_FINE) {
            return no;
        }
        codec_put_f32(out, telemetry_read(s->setup.drive, signal));
    }
    return LINK_FINE;
}

link_refusal_t request_get(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    const uint16_t first = codec_get_u16(in);
    const uint16_t count = codec_get_u8(in);
    if ((count == 0U) || (count > GET_MOST)) {
        return services_refuse(s, LINK_NO_too_many, count, 1.0f, (float)GET_MOST);
    }
    const uint32_t       last = (uint32_t)first + count - 1U;
    const link_refusal_t no = services_index(s, (last < 0xFFFFU) ? (uint16_t)last : 0xFFFFU, PARAM_COUNT);
    if (no != LINK_FINE) {
        return no;
    }
    const drive_params_t *const p = services_params(s);
    codec_put_u16(out, first);
    codec_put_u8(out, count);
    for (uint16_t i = 0U; i < count; i++) {
        codec_put_f32(out, params_get(p, (uint16_t)(first + i)));
    }
    return LINK_FINE;
}

link_refusal_t request_fault(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    (void)in;
    const recorder_t *const box = &s->recorder[SERVICES_BLACK_BOX];
    codec_put_u16(out, (uint16_t)s->found.fault);
    codec_put_u16(out, s->found.detail);
    codec_put_u8(out, (uint16_t)drive_state(s->setup.drive));
    codec_put_u32(out, s->found.since);
    codec_put_u8(out, box->status);
    codec_put_u16(out, recorder_rows(box));
    codec_put_u8(out, s->past.resets);
    codec_put_u16(out, (uint16_t)s->past.fault);
    codec_put_u16(out, s->past.detail);
    codec_put_u8(out, (uint16_t)s->past.state);
    codec_put_u32(out, s->past.counter);
    codec_put_u8(out, s->past.rows ? 1U : 0U);
    return LINK_FINE;
}

link_refusal_t request_learned(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    const drive_t *const d = s->setup.drive;
    const uint16_t       cells = drive_memory_cells(d);
    const uint16_t       first = codec_get_u16(in);
    const uint16_t       count = codec_get_u8(in);
    if ((count == 0U) || (count > GET_MOST)) {
        return services_refuse(s, LINK_NO_too_many, count, 1.0f, (float)GET_MOST);
    }
    if (cells == 0U) {
        return LINK_NO_unsupported;
    }
    const link_refusal_t no = services_index(s, first, cells);
    if (no != LINK_FINE) {
        return no;
    }
    const uint16_t left = (uint16_t)(cells - first);
    const uint16_t n = (left < count) ? left : count;
    codec_put_u16(out, cells);
    codec_put_u16(out, first);
    codec_put_u8(out, n);
    for (uint16_t i = 0U; i < n; i++) {
        codec_put_f32(out, drive_memory_cell(d, (uint16_t)(first + i)));
    }
    return LINK_FINE;
}

link_refusal_t request_timing(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    const bool     reset = codec_get_u8(in) != 0U;
    drive_t *const d = s->setup.drive;
    codec_put_u32(out, hal_clock_hz());
    codec_put_u32(out, drive_period_cyc(d));
    codec_put_u32(out, drive_current_timing(d)->last_cyc);
    codec_put_u32(out, drive_current_timing(d)->max_cyc);
    codec_put_u32(out, s->sample_last_cyc);
    codec_put_u32(out, s->sample_max_cyc);
    codec_put_u32(out, s->pass_max_cyc);
    if (reset) { /* the interrupt may write one of them in between: then that one is not forgotten */
        drive_restart_timing(d);
        s->sample_max_cyc = 0U;
        s->pass_max_cyc = 0U;
    }
    return LINK_FINE;
}
