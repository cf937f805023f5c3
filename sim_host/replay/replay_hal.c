/* The HAL contract, from the trace. Once the order of calls no longer fits, every function gives what harms nobody. */
#include <string.h>

#include "hal/hal_clock.h"
#include "hal/hal_link.h"
#include "hal/hal_storage.h"
#include "sim_host/replay/replay.h"

#if defined(__arm__) /* a bare machine has one thread */
static replay_t *selected;
#else
static _Thread_local replay_t *selected;
#endif

void replay_select(replay_t *r) { selected = r; }

static uint16_t take_status(trace_event_t function, uint16_t without)
{
    return replay_take(selected, function) ? trace_get(&selected->in, TRACE_ORDER) : without;
}

static uint32_t take_count(trace_event_t function)
{
    return replay_take(selected, function) ? trace_get_count(&selected->in, TRACE_CH_COUNT) : 0U;
}

/* ---- measured ---------------------------------------------------------------------------------------------------------- */

hal_status_t hal_sample_read(hal_sample_t *out)
{
    trace_reader_t *const in = &selected->in;
    memset(out, 0, sizeof *out);
    if (!replay_take(selected, TRACE_hal_sample_read)) {
        return HAL_SENSOR_FAULT;
    }
    const hal_status_t status = (hal_status_t)trace_get(in, TRACE_ORDER);
    out->ia_a = trace_get_number(in, TRACE_CH_CURRENT);
    out->ib_a = trace_get_number(in, TRACE_CH_CURRENT + 1);
    out->ic_a = trace_get_number(in, TRACE_CH_CURRENT + 2);
    out->vdc_v = trace_get_number(in, TRACE_CH_VDC);
    out->theta_m = trace_get_count(in, TRACE_CH_ANGLE);
    out->at_cyc = trace_get_count(in, TRACE_CH_CLOCK);
    out->seq = trace_get_count(in, TRACE_CH_SEQ);
    return status;
}

hal_status_t hal_encoder_edge(hal_encoder_edge_t *out)
{
    trace_reader_t *const in = &selected->in;
    memset(out, 0, sizeof *out);
    if (!replay_take(selected, TRACE_hal_encoder_edge)) {
        return HAL_SENSOR_FAULT;
    }
    const hal_status_t status = (hal_status_t)trace_get(in, TRACE_ORDER);
    out->edge_count = (int32_t)trace_get_count(in, TRACE_CH_EDGE);
    out->edge_cyc = trace_get_count(in, TRACE_CH_EDGE_CYC);
    out->index_passes = (uint16_t)trace_get(in, TRACE_ORDER);
    out->index_rad = trace_get_number(in, TRACE_CH_INDEX);
    return status;
}

hal_status_t hal_temperature(hal_temperature_t which, float *celsius)
{
    (void)which;
    *celsius = 0.0f;
    if (!replay_take(selected, TRACE_hal_temperature)) {
        return HAL_SENSOR_FAULT;
    }
    const hal_status_t status = (hal_status_t)trace_get(&selected->in, TRACE_ORDER);
    *celsius = trace_get_number(&selected->in, TRACE_CH_VALUE);
    return status;
}

uint32_t hal_clock_cyc(void)
{
    return replay_take(selected, TRACE_hal_clock_cyc) ? trace_get_count(&selected->in, TRACE_CH_CLOCK) : 0U;
}
uint32_t hal_clock_hz(void) { return take_count(TRACE_hal_clock_hz); }
void     hal_clock_request_speed_isr(void) { (void)replay_take(selected, TRACE_hal_clock_request_speed_isr); }

hal_reset_t hal_reset_cause(void) { return (hal_reset_t)take_status(TRACE_hal_reset_cause, HAL_RESET_UNKNOWN); }

void hal_limits(hal_limits_t *out)
{
    trace_reader_t *const in = &selected->in;
    memset(out, 0, sizeof *out);
    if (replay_take(selected, TRACE_hal_limits)) {
        out->current_a = trace_get_number(in, TRACE_CH_VALUE);
        out->dc_link_v = trace_get_number(in, TRACE_CH_VALUE);
        out->speed_rad_s = trace_get_number(in, TRACE_CH_VALUE);
        out->offset_a = trace_get_number(in, TRACE_CH_VALUE);
        out->encoder_counts = trace_get_number(in, TRACE_CH_VALUE);
        out->has_chopper = trace_get(in, TRACE_ORDER) != 0U;
    }
}

/* ---- bridge ------------------------------------------------------------------------------------------------------------- */

hal_status_t hal_inverter_set_duty(const hal_duty_t *duty)
{
    if (!replay_take(selected, TRACE_hal_inverter_set_duty)) {
        return HAL_SENSOR_FAULT;
    }
    const hal_status_t status = (hal_status_t)trace_get(&selected->in, TRACE_ORDER);
    const float        replayed[3] = {duty->a, duty->b, duty->c};
    for (uint16_t i = 0; i < 3U; i++) {
        const float recorded = trace_get_number(&selected->in, TRACE_CH_DUTY + i);
        if (trace_bits(recorded) != trace_bits(replayed[i])) {
            const replay_difference_t d = {.kind = REPLAY_DUTY, .index = i, .recorded = recorded, .replayed = replayed[i]};
            replay_note(selected, &d);
        }
    }
    return status;
}

uint16_t hal_sto(void) { return take_status(TRACE_hal_sto, 0U); }

void hal_brake_duty(float duty)
{
    if (replay_take(selected, TRACE_hal_brake_duty) &&
        (trace_bits(trace_get_number(&selected->in, TRACE_CH_VALUE)) != trace_bits(duty))) {
        const replay_difference_t d = {
            .kind = REPLAY_SENT, .recorded_event = TRACE_hal_brake_duty, .replayed_event = TRACE_hal_brake_duty};
        replay_note(selected, &d);
    }
}

hal_status_t hal_inverter_arm(void) { return (hal_status_t)take_status(TRACE_hal_inverter_arm, HAL_SENSOR_FAULT); }
void         hal_inverter_disarm(void) { (void)replay_take(selected, TRACE_hal_inverter_disarm); }
void         hal_inverter_clear_fault(void) { (void)replay_take(selected, TRACE_hal_inverter_clear_fault); }

hal_inverter_fault_t hal_inverter_fault(void)
{
    return (hal_inverter_fault_t)take_status(TRACE_hal_inverter_fault, HAL_INVERTER_FINE);
}

/* ---- link and storage --------------------------------------------------------------------------------------------------- */

static void hold_against_hash(trace_event_t function, const uint16_t *words, uint16_t count)
{
    if (trace_get_count(&selected->in, TRACE_CH_HASH) != trace_hash_words(words, count)) {
        const replay_difference_t d = {.kind = REPLAY_SENT, .recorded_event = function, .replayed_event = function};
        replay_note(selected, &d);
    }
}

uint16_t hal_link_read(uint16_t *octets, uint16_t limit)
{
    const uint32_t count = take_count(TRACE_hal_link_read);
    uint16_t       n = 0;
    while ((n < count) && (n < limit)) {
        octets[n++] = trace_get(&selected->in, TRACE_OCTETS);
    }
    return n;
}

uint32_t hal_link_lost(void) { return take_count(TRACE_hal_link_lost); }

uint16_t hal_link_write(const uint16_t *octets, uint16_t count)
{
    if (!replay_take(selected, TRACE_hal_link_write)) {
        return 0U;
    }
    const uint32_t taken = trace_get_count(&selected->in, TRACE_CH_COUNT);
    hold_against_hash(TRACE_hal_link_write, octets, count);
    return (taken < count) ? (uint16_t)taken : count;
}

uint16_t hal_storage_pages(void) { return (uint16_t)take_count(TRACE_hal_storage_pages); }
uint16_t hal_storage_page_words(void) { return (uint16_t)take_count(TRACE_hal_storage_page_words); }

hal_status_t hal_storage_read(uint16_t page, uint16_t offset, uint16_t *words, uint16_t count)
{
    (void)page;
    (void)offset;
    const hal_status_t status = (hal_status_t)take_status(TRACE_hal_storage_read, HAL_SENSOR_FAULT);
    if (status == HAL_OK) {
        trace_get_words(&selected->in, words, count);
    }
    return status;
}

hal_status_t hal_storage_write(uint16_t page, uint16_t offset, const uint16_t *words, uint16_t count)
{
    (void)page;
    (void)offset;
    if (!replay_take(selected, TRACE_hal_storage_write)) {
        return HAL_SENSOR_FAULT;
    }
    const hal_status_t status = (hal_status_t)trace_get(&selected->in, TRACE_ORDER);
    hold_against_hash(TRACE_hal_storage_write, words, count);
    return status;
}

hal_status_t hal_storage_erase(uint16_t page)
{
    (void)page;
    return (hal_status_t)take_status(TRACE_hal_storage_erase, HAL_SENSOR_FAULT);
}
