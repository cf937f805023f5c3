/* Requests about rows: stream and recorders. Any client may. */
#include "firmware/app/telemetry.h"
#include "firmware/services/internal.h"

#define READ_MOST 60U
#define LEVEL_MAX 1.0e12f

/* The signals at the end of a request. */
static link_refusal_t get_signals(services_t *s, codec_reader_t *in, uint16_t *signal, uint16_t count)
{
    link_refusal_t no = services_length(s, in, (uint16_t)(in->at + (2U * count)));
    for (uint16_t i = 0U; (i < count) && (no == LINK_FINE); i++) {
        signal[i] = codec_get_u16(in);
        no = services_index(s, signal[i], SIGNAL_COUNT);
    }
    return no;
}

link_refusal_t request_stream_configure(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    uint16_t       signal[STREAM_SIGNALS];
    const uint16_t decimation = codec_get_u16(in);
    const uint16_t rows = codec_get_u8(in);
    const uint16_t count = codec_get_u8(in);
    if (count > STREAM_SIGNALS) {
        return services_refuse(s, LINK_NO_too_many, count, 0.0f, (float)STREAM_SIGNALS);
    }
    if ((decimation == 0U) && (count > 0U)) {
        return services_refuse(s, LINK_NO_range, 0U, 1.0f, 65535.0f);
    }
    const link_refusal_t no = get_signals(s, in, signal, count);
    if (no != LINK_FINE) {
        return no;
    }
    stream_configure(&s->stream, signal, count, decimation, rows);
    codec_put_u8(out, s->stream.config);
    codec_put_u8(out, s->stream.frame_rows);
    codec_put_u16(out, STREAM_VALUES);
    return LINK_FINE;
}

static bool looks_at_a_signal(recorder_trigger_t t)
{
    return (t == RECORDER_RISING) || (t == RECORDER_FALLING) || (t == RECORDER_EITHER);
}

static link_refusal_t judge(services_t *s, const recorder_config_t *c, uint16_t values)
{
    if (c->decimation == 0U) {
        return services_refuse(s, LINK_NO_range, 1U, 1.0f, 65535.0f);
    }
    if (c->post == 0U) {
        return services_refuse(s, LINK_NO_range, 3U, 1.0f, 65535.0f);
    }
    if ((uint16_t)c->trigger >= (uint16_t)RECORDER_TRIGGERS) {
        return services_refuse(s, LINK_NO_range, 4U, 0.0f, (float)RECORDER_TRIGGERS - 1.0f);
    }
    if (looks_at_a_signal(c->trigger)) {
        const link_refusal_t no = services_index(s, c->trigger_signal, SIGNAL_COUNT);
        if (no != LINK_FINE) {
            return no;
        }
        if (!((c->level <= LEVEL_MAX) && (c->level >= -LEVEL_MAX))) {
            return services_refuse(s, LINK_NO_range, 6U, -LEVEL_MAX, LEVEL_MAX);
        }
    }
    if ((c->count == 0U) || (c->count > RECORDER_SIGNALS)) {
        return services_refuse(s, LINK_NO_too_many, c->count, 1.0f, (float)RECORDER_SIGNALS);
    }
    const uint32_t rows = (uint32_t)c->pre + c->post;
    if ((rows * c->count) > values) {
        const uint32_t most_rows = values / c->count;
        return services_refuse(s, LINK_NO_too_many, (rows < 0xFFFFU) ? (uint16_t)rows : 0xFFFFU, 0.0f, (float)most_rows);
    }
    return LINK_FINE;
}

link_refusal_t request_capture_configure(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    recorder_config_t c;
    const uint16_t    which = codec_get_u8(in);
    c.decimation = codec_get_u16(in);
    c.pre = codec_get_u16(in);
    c.post = codec_get_u16(in);
    c.trigger = (recorder_trigger_t)codec_get_u8(in);
    c.trigger_signal = codec_get_u16(in);
    c.level = codec_get_f32(in);
    c.count = codec_get_u8(in);
    link_refusal_t no = services_index(s, which, SERVICES_RECORDERS);
    if (no == LINK_FINE) {
        no = judge(s, &c, s->recorder[which].values);
    }
    if (no == LINK_FINE) {
        no = get_signals(s, in, c.signal, c.count);
    }
    if (no != LINK_FINE) {
        return no;
    }
    recorder_start(&s->recorder[which], &c);
    codec_put_u8(out, which);
    codec_put_u8(out, s->recorder[which].number);
    codec_put_u16(out, (uint16_t)(c.pre + c.post));
    return LINK_FINE;
}

link_refusal_t request_capture_status(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    const uint16_t       which = codec_get_u8(in);
    const link_refusal_t no = services_index(s, which, SERVICES_RECORDERS);
    if (no != LINK_FINE) {
        return no;
    }
    const recorder_t *const        r = &s->recorder[which];
    const recorder_config_t *const c = &r->config;
    const uint16_t                 status = r->status;
    const bool                     complete = status == (uint16_t)RECORDER_COMPLETE;
    const bool                     configured = status != (uint16_t)RECORDER_NEVER;
    const uint16_t                 pre = complete ? r->before : c->pre;
    codec_put_u8(out, which);
    codec_put_u8(out, r->number);
    codec_put_u8(out, status);
    codec_put_u8(out, configured ? (uint16_t)c->trigger : 0U);
    codec_put_u16(out, configured ? c->decimation : 0U);
    codec_put_u16(out, configured ? pre : 0U);
    codec_put_u16(out, configured ? (uint16_t)(pre + (complete ? r->after : c->post)) : 0U);
    codec_put_u16(out, r->held);
    codec_put_u32(out, complete ? r->first : 0U);
    codec_put_u32(out, complete ? r->trigger_counter : 0U);
    codec_put_u8(out, c->count);
    for (uint16_t i = 0U; i < c->count; i++) {
        codec_put_u16(out, c->signal[i]);
    }
    return LINK_FINE;
}

link_refusal_t request_capture_read(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    const uint16_t which = codec_get_u8(in);
    const uint32_t offset = codec_get_u32(in);
    const uint16_t count = codec_get_u8(in);
    link_refusal_t no = services_index(s, which, SERVICES_RECORDERS);
    if (no != LINK_FINE) {
        return no;
    }
    const recorder_t *const r = &s->recorder[which];
    if ((count == 0U) || (count > READ_MOST)) {
        return services_refuse(s, LINK_NO_too_many, count, 1.0f, (float)READ_MOST);
    }
    if (r->status != (uint16_t)RECORDER_COMPLETE) {
        return services_refuse(s, LINK_NO_state, r->status, 0.0f, 0.0f);
    }
    const uint16_t total = (uint16_t)(recorder_rows(r) * r->config.count);
    no = services_index(s, (offset < 0xFFFFU) ? (uint16_t)offset : 0xFFFFU, total);
    if (no != LINK_FINE) {
        return no;
    }
    const uint16_t from = (uint16_t)offset;
    const uint16_t n = ((total - from) < count) ? (uint16_t)(total - from) : count;
    codec_put_u8(out, which);
    codec_put_u8(out, r->number);
    codec_put_u32(out, offset);
    codec_put_u8(out, n);
    for (uint16_t i = 0U; i < n; i++) {
        codec_put_f32(out, recorder_value(r, (uint16_t)(from + i)));
    }
    return LINK_FINE;
}

link_refusal_t request_capture_control(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    const uint16_t which = codec_get_u8(in);
    const uint16_t action = codec_get_u8(in);
    link_refusal_t no = services_index(s, which, SERVICES_RECORDERS);
    if (no != LINK_FINE) {
        return no;
    }
    recorder_t *const r = &s->recorder[which];
    switch (action) {
    case 0U:
        recorder_stop(r);
        break;
    case 1U:
        recorder_trigger(r);
        break;
    case 2U:
        recorder_restart(r);
        break;
    default:
        no = services_refuse(s, LINK_NO_range, 1U, 0.0f, 2.0f);
        break;
    }
    codec_put_u8(out, which);
    codec_put_u8(out, r->status);
    return no;
}
