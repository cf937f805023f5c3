/* A trace grows in memory until somebody takes it. */
#include <stdlib.h>
#include <string.h>

#include "sim_host/trace/trace.h"

#define FIRST_ROOM ((size_t)1 << 16)

void trace_open(trace_t *t, uint32_t row_every)
{
    memset(t, 0, sizeof *t);
    t->row_every = row_every;
}

void trace_free(trace_t *t)
{
    if (t == NULL) {
        return;
    }
    for (int i = 0; i < (int)TRACE_STREAMS; i++) {
        free(t->stream[i].octet);
    }
    memset(t, 0, sizeof *t);
}

void trace_restart(trace_t *t)
{
    trace_taken(t);
    memset(t->last, 0, sizeof t->last);
    t->period = 0;
    t->depth = 0;
}

void trace_taken(trace_t *t)
{
    for (int i = 0; i < (int)TRACE_STREAMS; i++) {
        t->stream[i].count = 0;
    }
}

void trace_put(trace_t *t, int stream, uint8_t octet)
{
    trace_stream_t *const s = &t->stream[stream];
    if (s->count == s->room) {
        const size_t   room = (s->room == 0U) ? FIRST_ROOM : (2U * s->room);
        uint8_t *const more = realloc(s->octet, room);
        if (more == NULL) {
            t->failed = true;
            return;
        }
        s->octet = more;
        s->room = room;
    }
    s->octet[s->count++] = octet;
}

static void put_word(trace_t *t, uint32_t word)
{
    trace_put(t, TRACE_WORD_TOP, (uint8_t)(word >> 24U));
    trace_put(t, TRACE_WORD_HIGH, (uint8_t)(word >> 16U));
    trace_put(t, TRACE_WORD_LOW, (uint8_t)(word >> 8U));
    trace_put(t, TRACE_WORD_BOTTOM, (uint8_t)word);
}

void trace_put_count(trace_t *t, int channel, uint32_t word)
{
    put_word(t, word - t->last[channel]);
    t->last[channel] = word;
}

void trace_put_number(trace_t *t, int channel, float value)
{
    uint32_t bits = 0;
    memcpy(&bits, &value, sizeof bits);
    put_word(t, bits ^ t->last[channel]);
    t->last[channel] = bits;
}

void trace_put_words(trace_t *t, const uint16_t *words, uint16_t count)
{
    for (uint16_t i = 0; i < count; i++) {
        trace_put(t, TRACE_OCTETS, (uint8_t)(words[i] >> 8U));
        trace_put(t, TRACE_OCTETS, (uint8_t)words[i]);
    }
}

void trace_asked(trace_t *t, trace_event_t function)
{
    if (t != NULL) {
        trace_put(t, TRACE_ORDER, (uint8_t)function);
    }
}

void trace_enter(trace_t *t, trace_event_t entry)
{
    if (t == NULL) {
        return;
    }
    if (t->depth > 0U) {
        trace_put(t, TRACE_ORDER, (uint8_t)TRACE_preempts);
    }
    trace_put(t, TRACE_ORDER, (uint8_t)entry);
    t->depth++;
}

void trace_leave(trace_t *t)
{
    if (t != NULL) {
        t->depth--;
    }
}

void trace_period(trace_t *t, const float *row, uint16_t signals)
{
    if (t == NULL) {
        return;
    }
    uint32_t hash = (uint32_t)TRACE_HASH;
    for (uint16_t i = 0; i < signals; i++) {
        hash = trace_hash(hash, trace_bits(row[i]));
    }
    const bool whole = (t->period % t->row_every) == 0U;
    trace_put(t, TRACE_ORDER, (uint8_t)TRACE_period);
    trace_put_count(t, TRACE_CH_HASH, hash);
    trace_put(t, TRACE_ORDER, whole ? 1U : 0U);
    for (uint16_t i = 0; whole && (i < signals); i++) {
        trace_put_number(t, TRACE_CH_ROW + i, trace_number(trace_bits(row[i])));
    }
    t->period++;
}

/* ---- what the HAL gave ------------------------------------------------------------------------------------------------ */

void trace_status(trace_t *t, trace_event_t function, uint16_t status)
{
    if (t != NULL) {
        trace_asked(t, function);
        trace_put(t, TRACE_ORDER, (uint8_t)status);
    }
}

void trace_count(trace_t *t, trace_event_t function, uint32_t value)
{
    if (t != NULL) {
        trace_asked(t, function);
        trace_put_count(t, TRACE_CH_COUNT, value);
    }
}

void trace_clock(trace_t *t, uint32_t cyc)
{
    if (t != NULL) {
        trace_asked(t, TRACE_hal_clock_cyc);
        trace_put_count(t, TRACE_CH_CLOCK, cyc);
    }
}

void trace_sample(trace_t *t, hal_status_t status, const hal_sample_t *s)
{
    if (t == NULL) {
        return;
    }
    trace_status(t, TRACE_hal_sample_read, (uint16_t)status);
    trace_put_number(t, TRACE_CH_CURRENT, s->ia_a);
    trace_put_number(t, TRACE_CH_CURRENT + 1, s->ib_a);
    trace_put_number(t, TRACE_CH_CURRENT + 2, s->ic_a);
    trace_put_number(t, TRACE_CH_VDC, s->vdc_v);
    trace_put_count(t, TRACE_CH_ANGLE, s->theta_m);
    trace_put_count(t, TRACE_CH_CLOCK, s->at_cyc);
    trace_put_count(t, TRACE_CH_SEQ, s->seq);
}

void trace_edge(trace_t *t, hal_status_t status, const hal_encoder_edge_t *e)
{
    if (t == NULL) {
        return;
    }
    trace_status(t, TRACE_hal_encoder_edge, (uint16_t)status);
    trace_put_count(t, TRACE_CH_EDGE, (uint32_t)e->edge_count);
    trace_put_count(t, TRACE_CH_EDGE_CYC, e->edge_cyc);
    trace_put(t, TRACE_ORDER, e->index_passes);
    trace_put_number(t, TRACE_CH_INDEX, e->index_rad);
}

void trace_duty(trace_t *t, hal_status_t status, const hal_duty_t *duty)
{
    if (t == NULL) {
        return;
    }
    trace_status(t, TRACE_hal_inverter_set_duty, (uint16_t)status);
    trace_put_number(t, TRACE_CH_DUTY, duty->a);
    trace_put_number(t, TRACE_CH_DUTY + 1, duty->b);
    trace_put_number(t, TRACE_CH_DUTY + 2, duty->c);
}

void trace_limits(trace_t *t, const hal_limits_t *limits)
{
    if (t == NULL) {
        return;
    }
    trace_asked(t, TRACE_hal_limits);
    trace_put_number(t, TRACE_CH_VALUE, limits->current_a);
    trace_put_number(t, TRACE_CH_VALUE, limits->dc_link_v);
    trace_put_number(t, TRACE_CH_VALUE, limits->speed_rad_s);
    trace_put_number(t, TRACE_CH_VALUE, limits->offset_a);
    trace_put_number(t, TRACE_CH_VALUE, limits->encoder_counts);
    trace_put(t, TRACE_ORDER, limits->has_chopper ? 1U : 0U);
}

void trace_temperature(trace_t *t, hal_status_t status, float celsius)
{
    if (t != NULL) {
        trace_status(t, TRACE_hal_temperature, (uint16_t)status);
        trace_put_number(t, TRACE_CH_VALUE, celsius);
    }
}

void trace_brake(trace_t *t, float duty)
{
    if (t != NULL) {
        trace_asked(t, TRACE_hal_brake_duty);
        trace_put_number(t, TRACE_CH_VALUE, duty);
    }
}

void trace_link_read(trace_t *t, const uint16_t *octets, uint16_t count)
{
    if (t == NULL) {
        return;
    }
    trace_count(t, TRACE_hal_link_read, count);
    for (uint16_t i = 0; i < count; i++) {
        trace_put(t, TRACE_OCTETS, (uint8_t)octets[i]);
    }
}

void trace_link_write(trace_t *t, const uint16_t *octets, uint16_t offered, uint16_t taken)
{
    if (t == NULL) {
        return;
    }
    trace_count(t, TRACE_hal_link_write, taken);
    trace_put_count(t, TRACE_CH_HASH, trace_hash_words(octets, offered));
}

void trace_storage_read(trace_t *t, hal_status_t status, const uint16_t *words, uint16_t count)
{
    if (t == NULL) {
        return;
    }
    trace_status(t, TRACE_hal_storage_read, (uint16_t)status);
    if (status == HAL_OK) {
        trace_put_words(t, words, count);
    }
}

void trace_storage_write(trace_t *t, hal_status_t status, const uint16_t *words, uint16_t count)
{
    if (t == NULL) {
        return;
    }
    trace_status(t, TRACE_hal_storage_write, (uint16_t)status);
    trace_put_count(t, TRACE_CH_HASH, trace_hash_words(words, count));
}
