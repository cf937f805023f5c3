#include "sim_host/replay/replay.h"

#include <string.h>

void replay_start(replay_t *r) { memset(r, 0, sizeof *r); }

void replay_feed(replay_t *r, const uint8_t *const octets[TRACE_STREAMS], const size_t counts[TRACE_STREAMS])
{
    trace_feed(&r->in, octets, counts);
}

void replay_note(replay_t *r, const replay_difference_t *found)
{
    replay_difference_t d = *found;
    d.period = r->periods;
    if (r->first.kind == REPLAY_SAME) {
        r->first = d;
    }
    if (((d.kind == REPLAY_ORDER) || (d.kind == REPLAY_BROKEN)) && !r->ended) {
        r->last = d;
        r->ended = true;
    }
}

static void note_order(replay_t *r, trace_event_t recorded, trace_event_t replayed)
{
    const replay_difference_t d = {.kind = REPLAY_ORDER, .recorded_event = recorded, .replayed_event = replayed};
    replay_note(r, &d);
}

static void note_broken(replay_t *r)
{
    const replay_difference_t d = {.kind = REPLAY_BROKEN, .recorded_event = TRACE_EVENTS, .replayed_event = TRACE_EVENTS};
    replay_note(r, &d);
}

bool replay_take(replay_t *r, trace_event_t event)
{
    replay_preempt(r);
    if (r->ended) {
        return false;
    }
    if (trace_next(&r->in) != event) {
        note_order(r, trace_next(&r->in), event);
        return false;
    }
    (void)trace_get(&r->in, TRACE_ORDER);
    return true;
}

/* ---- the calls of the firmware ----------------------------------------------------------------------------------------- */

static void take_params(replay_t *r)
{
    params_default(&r->params);
    for (uint16_t i = 0; i < (uint16_t)PARAM_COUNT; i++) {
        (void)params_set(&r->params, i, trace_get_number(&r->in, TRACE_CH_VALUE));
    }
}

static void start_services(replay_t *r)
{
    take_params(r);
    const hal_reset_t cause = (hal_reset_t)trace_get(&r->in, TRACE_ORDER);
    const uint32_t    capture = trace_get_count(&r->in, TRACE_CH_COUNT);
    const uint32_t    black_box = trace_get_count(&r->in, TRACE_CH_COUNT);
    for (int i = 0; i < (REPLAY_NAME - 1); i++) {
        r->board[i] = (char)trace_get(&r->in, TRACE_OCTETS);
        if (r->board[i] == '\0') {
            break;
        }
    }
    if ((capture > REPLAY_CAPTURE_VALUES) || (black_box > REPLAY_BLACK_BOX_VALUES)) {
        note_broken(r);
        return;
    }
    const services_setup_t setup = {&r->drive,         &r->params,          r->board, r->capture, r->black_box,
                                    (uint16_t)capture, (uint16_t)black_box, cause};
    services_start(&r->services, &setup);
}

static void command(replay_t *r)
{
    drive_command_t c;
    c.mode = (drive_mode_t)trace_get(&r->in, TRACE_ORDER);
    c.speed_ref_rad_s = trace_get_number(&r->in, TRACE_CH_VALUE);
    c.id_ref_a = trace_get_number(&r->in, TRACE_CH_VALUE);
    c.iq_ref_a = trace_get_number(&r->in, TRACE_CH_VALUE);
    c.target_turns = (int32_t)trace_get_count(&r->in, TRACE_CH_COUNT);
    c.target_rad = trace_get_number(&r->in, TRACE_CH_VALUE);
    (void)drive_command(&r->drive, &c);
}

static void tune(replay_t *r)
{
    drive_params_t p = *r->drive.params;
    const uint16_t param = (uint16_t)trace_get_count(&r->in, TRACE_CH_COUNT);
    uint16_t       culprit = PARAM_COUNT;
    (void)params_set(&p, param, trace_get_number(&r->in, TRACE_CH_VALUE));
    (void)drive_tune(&r->drive, &p, &culprit);
}

static void write_memory(replay_t *r)
{
    const uint32_t cells = trace_get_count(&r->in, TRACE_CH_COUNT);
    if (cells > (uint32_t)DRIVE_OBSERVER_CAPACITY) {
        note_broken(r);
        return;
    }
    for (uint32_t i = 0; i < cells; i++) {
        r->amps[i] = trace_get_number(&r->in, TRACE_CH_VALUE);
    }
    (void)drive_memory_write(&r->drive, r->amps, (uint16_t)cells);
}

static bool starts(trace_event_t entry) { return (entry == TRACE_drive_init) || (entry == TRACE_services_start); }

static bool serves(trace_event_t entry) { return (entry == TRACE_services_sample) || (entry == TRACE_services_pass); }

static void call(replay_t *r, trace_event_t entry)
{
    (void)trace_get(&r->in, TRACE_ORDER);
    const bool ready = starts(entry) || (r->started && (!serves(entry) || (r->services.setup.drive != NULL)));
    if (!ready || (r->depth >= REPLAY_PREEMPTED)) {
        note_broken(r);
        return;
    }
    r->started = true;
    r->depth++;
    switch (entry) {
    case TRACE_drive_init:
        take_params(r);
        drive_init(&r->drive, &r->params);
        break;
    case TRACE_services_start:
        start_services(r);
        break;
    case TRACE_current_isr:
        drive_current_isr(&r->drive);
        break;
    case TRACE_watch_isr:
        drive_watch_isr(&r->drive);
        break;
    case TRACE_speed_isr:
        drive_speed_isr(&r->drive);
        break;
    case TRACE_services_sample:
        services_sample(&r->services);
        break;
    case TRACE_background:
        drive_background(&r->drive);
        break;
    case TRACE_services_pass:
        services_pass(&r->services);
        break;
    case TRACE_drive_start:
        drive_start(&r->drive);
        break;
    case TRACE_drive_home:
        drive_home(&r->drive);
        break;
    case TRACE_drive_command:
        command(r);
        break;
    case TRACE_drive_tune:
        tune(r);
        break;
    case TRACE_memory_write:
        write_memory(r);
        break;
    default:
        (void)drive_memory_clear(&r->drive);
        break;
    }
    r->depth--;
}

void replay_preempt(replay_t *r)
{
    while (!r->ended && (trace_next(&r->in) == TRACE_preempts)) {
        (void)trace_get(&r->in, TRACE_ORDER);
        if (!trace_is_entry(trace_next(&r->in))) {
            note_broken(r);
            return;
        }
        call(r, trace_next(&r->in));
    }
}

/* ---- periods -------------------------------------------------------------------------------------------------------------- */

static void hold_against_row(replay_t *r)
{
    const bool wanted = (r->first.kind != REPLAY_SAME) && !r->row_known;
    bool       differs = false; /* a difference may have gone again before the next stored row */
    for (uint16_t i = 0; i < (uint16_t)SIGNAL_COUNT; i++) {
        const float value = trace_get_number(&r->in, TRACE_CH_ROW + i);
        if (wanted) {
            r->recorded[i] = value;
            r->replayed[i] = r->row[i];
            differs = differs || (trace_bits(value) != trace_bits(r->row[i]));
        }
    }
    if (wanted && differs) {
        r->row_known = true;
        r->row_period = r->periods;
    }
}

static void end_period(replay_t *r)
{
    uint16_t every[SIGNAL_COUNT];
    uint32_t hash = (uint32_t)TRACE_HASH;
    for (uint16_t i = 0; i < (uint16_t)SIGNAL_COUNT; i++) {
        every[i] = i;
    }
    telemetry_read_row(&r->drive, every, (uint16_t)SIGNAL_COUNT, r->row);
    for (uint16_t i = 0; i < (uint16_t)SIGNAL_COUNT; i++) {
        hash = trace_hash(hash, trace_bits(r->row[i]));
    }
    (void)trace_get(&r->in, TRACE_ORDER);
    if (trace_get_count(&r->in, TRACE_CH_HASH) != hash) {
        const replay_difference_t d = {.kind = REPLAY_SIGNALS};
        replay_note(r, &d);
    }
    if (trace_get(&r->in, TRACE_ORDER) != 0U) {
        hold_against_row(r);
    }
    r->periods++;
    if (r->row_known) {
        r->ended = true; /* what there is to say about the first difference is known */
    }
}

bool replay_period(replay_t *r)
{
    replay_select(r);
    while (!r->ended && !trace_at_end(&r->in)) {
        const trace_event_t next = trace_next(&r->in);
        if ((next == TRACE_period) && r->started) {
            end_period(r);
            return true;
        }
        if (trace_is_entry(next)) {
            call(r, next);
        } else if ((next < TRACE_EVENTS) && (next > TRACE_preempts)) {
            note_order(r, next, TRACE_EVENTS); /* the call above came back without having asked for this */
        } else {
            note_broken(r);
        }
        if (r->in.short_of) {
            note_broken(r);
        }
    }
    return false;
}
