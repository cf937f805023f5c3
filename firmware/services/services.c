/* The main loop's part: octets in, one request at a time, octets out; the timeout; events. */
#include "firmware/services/services.h"

#include "firmware/app/telemetry.h"
#include "firmware/services/internal.h"
#include "firmware/services/schema.h"
#include "hal/hal_clock.h"
#include "hal/hal_link.h"

#define PERIODS_PER_MS (DRIVE_PWM_HZ / 1000U)
#define BLACK_BOX_AFTER 16U /* rows from the fault on: the fault is the end of the story */

typedef struct {
    uint16_t type, shortest, longest;
    link_refusal_t (*answer)(services_t *s, codec_reader_t *in, codec_writer_t *out);
} request_t;

static const request_t REQUESTS[] = {
#define MESSAGE(name, type, shortest, longest) {(type), (shortest), (longest), request_##name},
#include "firmware/link/protocol.def"
};
#define REQUEST_COUNT (sizeof(REQUESTS) / sizeof(REQUESTS[0]))

/* ---- start ----------------------------------------------------------------------------------------------------------- */

static void start_black_box(recorder_t *r)
{
    const recorder_config_t config = {{SIGNAL_speed_ref_rad_s, SIGNAL_speed_rad_s, SIGNAL_iq_ref_a, SIGNAL_iq_a, SIGNAL_ia_a,
                                       SIGNAL_ib_a, SIGNAL_vdc_v, SIGNAL_theta_m_rad},
                                      RECORDER_SIGNALS,
                                      1U,
                                      (uint16_t)((r->values / RECORDER_SIGNALS) - BLACK_BOX_AFTER),
                                      BLACK_BOX_AFTER,
                                      RECORDER_AT_FAULT,
                                      0U,
                                      0.0f};
    if ((r->values / RECORDER_SIGNALS) > BLACK_BOX_AFTER) {
        recorder_start(r, &config);
    }
}

void services_start(services_t *s, const services_setup_t *setup)
{
    const session_t nobody = {.timeout_ms = SERVICES_TIMEOUT_MS};
    services_take_kept(s, setup);
    s->setup = *setup;
    s->session = nobody;
    s->counter = 0U;
    s->found.fault = FAULT_none;
    s->found.detail = 0U;
    s->found.since = 0U;
    s->last_fault = FAULT_none;
    s->sample_last_cyc = 0U;
    s->sample_max_cyc = 0U;
    s->pass_max_cyc = 0U;
    s->passed = false;
    s->frames_bad = 0U;
    s->wire_count = 0U;
    s->wire_at = 0U;
    frame_decoder_reset(&s->decoder);
    stream_init(&s->stream);
    recorder_init(&s->recorder[SERVICES_CAPTURE], setup->capture, setup->capture_values);

    drive_t *const d = setup->drive;
    s->staged = *setup->defaults;
    store_reset(drive_storage(d));
    s->stored_taken = param_store_load(drive_storage(d), &s->staged, s->schema) == HAL_OK;
    drive_init(d, s->stored_taken ? &s->staged : setup->defaults);
    if (s->stored_taken && (drive_fault(d) == FAULT_configuration)) { /* a set that fits no drive must not lock the bench out */
        s->stored_taken = false;
        drive_init(d, setup->defaults);
    }
    if (s->stored_taken && (drive_newest_params(d)->auto_run != 0U) && (setup->reset != HAL_RESET_WATCHDOG)) {
        drive_start(d);
        s->session.started = true; /* nobody may be there to stop it: the timeout counts from now on */
        s->session.by_itself = true;
    }
    s->seen_state = drive_state(d);
    s->seen_fault = drive_fault(d);
    if (!s->past.rows) { /* else it keeps them until the drive is armed */
        start_black_box(&s->recorder[SERVICES_BLACK_BOX]);
    }
    services_mark(s);
}

/* ---- what the requests share ------------------------------------------------------------------------------------------- */

link_refusal_t services_refuse(services_t *s, link_refusal_t why, uint16_t field, float low, float high)
{
    s->refusal.field = field;
    s->refusal.low = low;
    s->refusal.high = high;
    return why;
}

link_refusal_t services_length(services_t *s, const codec_reader_t *in, uint16_t expected)
{
    return (in->count == expected) ? LINK_FINE : services_refuse(s, LINK_NO_length, in->count, (float)expected, (float)expected);
}

link_refusal_t services_index(services_t *s, uint16_t index, uint16_t count)
{
    return (index < count) ? LINK_FINE : services_refuse(s, LINK_NO_index, index, 0.0f, (float)count - 1.0f);
}

bool services_saving(const services_t *s) { return drive_is_saving(s->setup.drive); }

uint16_t services_flags(const services_t *s)
{
    const drive_t *const d = s->setup.drive;
    const bool           flag[] = {s->session.armed,      drive_has_started_up(d) && drive_zero_is_known(d),
                                   s->session.started,    s->session.timed_out,
                                   drive_change_waits(d), drive_is_homed(d),
                                   s->stream.on != 0U,    services_saving(s),
                                   s->stored_taken};
    uint16_t             bits = 0U;
    for (uint16_t i = 0U; i < (uint16_t)(sizeof(flag) / sizeof(flag[0])); i++) {
        bits = (uint16_t)(bits | (flag[i] ? (uint16_t)(1U << i) : 0U));
    }
    return (uint16_t)(bits | ((uint16_t)s->setup.reset << 9U));
}

const drive_params_t *services_params(const services_t *s)
{
    const drive_t *const d = s->setup.drive;
    return drive_newest_params(d);
}

static void forget(services_t *s)
{
    s->session.armed = false;
    s->session.started = false;
    s->session.by_itself = false;
}

void services_disarm(services_t *s)
{
    drive_stop_by(s->setup.drive, DRIVE_STOP_COAST);
    forget(s);
}

/* ---- watching the drive ------------------------------------------------------------------------------------------------ */

/* A client that let go: off as timeout_action says, and no reference that the next start would run to. */
static void check_timeout(services_t *s)
{
    session_t *const n = &s->session;
    if (!n->started || (n->timeout_ms == 0U)) {
        return;
    }
    if ((s->counter - n->alive_at) < ((uint32_t)n->timeout_ms * PERIODS_PER_MS)) {
        return;
    }
    drive_t *const  d = s->setup.drive;
    drive_command_t stop = *drive_newest_command(d);
    stop.speed_ref_rad_s = 0.0f;
    stop.id_ref_a = 0.0f;
    stop.iq_ref_a = 0.0f;
    const drive_stop_word_t how = (drive_stop_word_t)services_params(s)->timeout_action;
    if (how == DRIVE_STOP_COAST) {
        (void)drive_command(d, &stop);
    }
    drive_stop_by(d, how);
    if (how != DRIVE_STOP_COAST) {
        (void)drive_command(d, &stop); /* after it, so that the ramp does not begin with a step */
    }
    forget(s);
    n->timed_out = true;
    n->event_wanted = true;
}

static void watch(services_t *s)
{
    const drive_state_t state = drive_state(s->setup.drive);
    const drive_fault_t fault = drive_fault(s->setup.drive);
    if (fault != FAULT_none) {
        forget(s);
    }
    if ((state != s->seen_state) || (fault != s->seen_fault)) {
        s->session.event_wanted = true;
        recorder_t *const box = &s->recorder[SERVICES_BLACK_BOX];
        if (drive_state_is_armed(state) && !drive_state_is_armed(s->seen_state) && (box->status == RECORDER_COMPLETE)) {
            recorder_restart(box);
        }
    }
    s->seen_state = state;
    s->seen_fault = fault;
    check_timeout(s);
}

static void time_the_pass(services_t *s)
{
    const uint32_t now = hal_clock_cyc();
    if (s->passed && ((now - s->pass_cyc) > s->pass_max_cyc)) {
        s->pass_max_cyc = now - s->pass_cyc;
    }
    s->pass_cyc = now;
    s->passed = true;
}

/* ---- out --------------------------------------------------------------------------------------------------------------- */

static bool is_sending(const services_t *s) { return s->wire_at < s->wire_count; }

static void send(services_t *s)
{
    if (is_sending(s)) {
        s->wire_at = (uint16_t)(s->wire_at + hal_link_write(&s->wire[s->wire_at], (uint16_t)(s->wire_count - s->wire_at)));
    }
}

static void post(services_t *s)
{
    s->wire_count = frame_end(&s->frame, s->wire);
    s->wire_at = 0U;
}

static void post_refusal(services_t *s, uint16_t type, uint16_t seq, link_refusal_t why)
{
    frame_begin(&s->frame, LINK_refused, seq);
    codec_writer_t *const w = &s->frame.payload;
    codec_put_u8(w, type);
    codec_put_u8(w, (uint16_t)why);
    codec_put_u16(w, s->refusal.field);
    codec_put_f32(w, s->refusal.low);
    codec_put_f32(w, s->refusal.high);
    post(s);
}

static void answer(services_t *s, uint16_t type, uint16_t seq, codec_reader_t in)
{
    link_refusal_t why = LINK_NO_unknown;
    (void)services_refuse(s, why, type, 0.0f, 0.0f);
    frame_begin(&s->frame, type + LINK_ANSWER, seq);
    for (uint16_t i = 0U; i < (uint16_t)REQUEST_COUNT; i++) {
        const request_t *const r = &REQUESTS[i];
        if (r->type != type) {
            continue;
        }
        if ((in.count < r->shortest) || (in.count > r->longest)) {
            why = services_refuse(s, LINK_NO_length, in.count, (float)r->shortest, (float)r->longest);
        } else {
            (void)services_refuse(s, LINK_FINE, SERVICES_NO_FIELD, 0.0f, 0.0f);
            why = r->answer(s, &in, &s->frame.payload);
        }
    }
    if (why == LINK_FINE) {
        post(s);
    } else if (why == LINK_LATER) {
        s->session.storing_seq = seq;
    } else {
        post_refusal(s, type, seq, why);
    }
}

static void post_event(services_t *s)
{
    const drive_t *const d = s->setup.drive;
    frame_begin(&s->frame, LINK_event, s->session.event_seq);
    codec_writer_t *const w = &s->frame.payload;
    codec_put_u32(w, s->counter);
    codec_put_u8(w, (uint16_t)drive_state(d));
    codec_put_u16(w, (uint16_t)drive_fault(d));
    codec_put_u16(w, drive_fault_detail(d));
    codec_put_u16(w, services_flags(s));
    post(s);
    s->session.event_seq++;
    s->session.event_wanted = false;
}

static void post_stream(services_t *s)
{
    frame_begin(&s->frame, LINK_stream, s->session.stream_seq);
    if (stream_take(&s->stream, s->counter, &s->frame.payload)) {
        post(s);
        s->session.stream_seq++;
    }
}

/* One step of a save. */
static void go_on_storing(services_t *s)
{
    drive_t *const d = s->setup.drive;
    if (!services_saving(s)) {
        return;
    }
    const hal_status_t status = drive_memory_save_step(d);
    if (!services_saving(s)) {
        s->session.stored = true;
        s->session.stored_status = status;
    }
}

static void post_stored(services_t *s)
{
    const link_refusal_t why = services_stored(s, s->session.stored_status);
    s->session.stored = false;
    if (why == LINK_FINE) {
        frame_begin(&s->frame, LINK_command + LINK_ANSWER, s->session.storing_seq);
        codec_put_u16(&s->frame.payload, s->session.storing);
        codec_put_u8(&s->frame.payload, (uint16_t)drive_state(s->setup.drive));
        post(s);
    } else {
        post_refusal(s, LINK_command, s->session.storing_seq, why);
    }
}

/* ---- in ---------------------------------------------------------------------------------------------------------------- */

/* Octets one by one: what stands behind a request waits in the board until the request has been answered. */
static void receive(services_t *s)
{
    uint16_t octet = 0U;
    for (uint16_t i = 0U; (i < SERVICES_OCTETS_PER_PASS) && (hal_link_read(&octet, 1U) == 1U); i++) {
        const frame_event_t event = frame_decode(&s->decoder, octet);
        if (event == FRAME_GOOD) {
            s->session.alive_at = s->counter;
            answer(s, frame_type(&s->decoder), frame_seq(&s->decoder), frame_payload(&s->decoder));
            return;
        }
        if ((event == FRAME_DROPPED) && (s->frames_bad < UINT32_MAX)) {
            s->frames_bad++;
        }
    }
}

void services_pass(services_t *s)
{
    time_the_pass(s);
    watch(s);
    services_attend_mark(s);
    go_on_storing(s);
    send(s);
    if (!is_sending(s)) {
        receive(s);
    }
    if (!is_sending(s) && s->session.stored) {
        post_stored(s);
    }
    if (!is_sending(s) && s->session.event_wanted && s->session.greeted) {
        post_event(s);
    }
    if (!is_sending(s)) {
        post_stream(s);
    }
    send(s);
}
