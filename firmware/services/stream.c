#include "firmware/services/stream.h"

#include "firmware/app/telemetry.h"
#include "hal/hal_order.h"

void stream_init(stream_t *s)
{
    s->config = 0U;
    stream_configure(s, s->signal, 0U, 1U, 0U);
}

/* The interrupt keeps away between the two writes of `on`. */
void stream_configure(stream_t *s, const uint16_t *signals, uint16_t count, uint16_t decimation, uint16_t rows)
{
    s->on = 0U;
    hal_order();
    for (uint16_t i = 0U; i < count; i++) {
        s->signal[i] = signals[i];
    }
    s->count = count;
    s->decimation = decimation;
    const uint16_t each = (count > 0U) ? count : (uint16_t)1U;
    const uint16_t fit = (uint16_t)((STREAM_FRAME_OCTETS / 4U) / each);
    s->frame_rows = ((rows > 0U) && (rows < fit)) ? rows : fit;
    const uint16_t room = (uint16_t)(STREAM_VALUES / each);
    s->rows = (room < STREAM_ROWS) ? room : (uint16_t)STREAM_ROWS;
    s->config = (s->config + 1U) & 0xFFU;
    s->frame = 0U;
    s->fresh = true;
    s->wait = 0U;
    s->written = 0U;
    s->taken = 0U;
    s->write_slot = 0U;
    s->read_slot = 0U;
    s->lost = 0U;
    hal_order();
    s->on = (count > 0U) ? 1U : 0U;
}

void stream_sample(stream_t *s, const drive_t *d, uint32_t counter)
{
    if (s->on == 0U) {
        return;
    }
    if (s->fresh) { /* rows lie on multiples of the decimation, whenever the configuration came */
        const uint16_t past = (uint16_t)(counter % s->decimation);
        s->wait = (past == 0U) ? 0U : (uint16_t)(s->decimation - past);
        s->fresh = false;
    }
    if (s->wait > 0U) {
        s->wait--;
        return;
    }
    s->wait = (uint16_t)(s->decimation - 1U);
    if ((uint16_t)(s->written - s->taken) >= s->rows) {
        if (s->lost < UINT32_MAX) {
            s->lost++;
        }
        return;
    }
    const uint16_t slot = s->write_slot;
    telemetry_read_row(d, s->signal, s->count, &s->value[(uint16_t)(slot * s->count)]); /* below STREAM_VALUES */
    s->counter[slot] = counter;
    s->write_slot = (uint16_t)((slot + 1U < s->rows) ? (slot + 1U) : 0U);
    s->written++;
}

static uint16_t next_slot(const stream_t *s, uint16_t slot) { return (uint16_t)((slot + 1U < s->rows) ? (slot + 1U) : 0U); }

/* Rows that follow each other without a gap, at most those of a frame. */
static uint16_t rows_in_line(const stream_t *s, uint16_t waiting)
{
    const uint16_t most = (waiting < s->frame_rows) ? waiting : s->frame_rows;
    uint16_t       n = 1U;
    uint16_t       slot = s->read_slot;
    while (n < most) {
        const uint16_t next = next_slot(s, slot);
        if ((s->counter[next] - s->counter[slot]) != s->decimation) {
            break;
        }
        slot = next;
        n++;
    }
    return n;
}

bool stream_take(stream_t *s, uint32_t counter, codec_writer_t *w)
{
    const uint16_t waiting = (uint16_t)(s->written - s->taken);
    if ((s->on == 0U) || (waiting == 0U)) {
        return false;
    }
    hal_order(); /* rows after their count */
    const uint16_t rows = rows_in_line(s, waiting);
    const bool     gap = rows < ((waiting < s->frame_rows) ? waiting : s->frame_rows);
    const bool     full = rows >= s->frame_rows;
    const bool     old = (counter - s->counter[s->read_slot]) >= STREAM_PATIENCE;
    if (!full && !old && !gap) {
        return false;
    }
    codec_put_u8(w, s->config);
    codec_put_u8(w, rows);
    codec_put_u16(w, s->frame);
    codec_put_u32(w, s->counter[s->read_slot]);
    for (uint16_t r = 0U; r < rows; r++) {
        const float *const row = &s->value[(uint16_t)(s->read_slot * s->count)];
        for (uint16_t i = 0U; i < s->count; i++) {
            codec_put_f32(w, row[i]);
        }
        s->read_slot = next_slot(s, s->read_slot);
    }
    s->frame++;
    hal_order(); /* from here on the interrupt may write over them */
    s->taken = (uint16_t)(s->taken + rows);
    return true;
}
