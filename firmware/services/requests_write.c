/* Requests that change something: for a client that showed this drive's schema, but for what stops the drive. */
#include "firmware/services/internal.h"

#define SET_MOST 40U
#define SET_BEGIN 1U
#define SET_COMMIT 2U
#define TIMEOUT_MIN_MS 50U
#define TIMEOUT_MAX_MS 60000U
#define TWO_PI 6.2831855f

static link_refusal_t bad_state(services_t *s)
{
    return services_refuse(s, LINK_NO_state, (uint16_t)drive_state(s->setup.drive), 0.0f, 0.0f);
}

/* ---- parameters -------------------------------------------------------------------------------------------------------- */

/* The parameter that the drive refused, and its limit. */
static link_refusal_t refused(services_t *s, uint16_t culprit)
{
    const float value = params_get(&s->staged, culprit);
    float       low = 0.0f;
    float       high = drive_board_max(culprit);
    if (value > high) {
        return services_refuse(s, LINK_NO_board, culprit, value, high);
    }
    if (drive_needs_rest(s->setup.drive, culprit)) {
        if (drive_stop_waits(s->setup.drive)) {
            return LINK_NO_busy; /* the stop before it has not been carried out yet */
        }
        return services_refuse(s, LINK_NO_at_rest, culprit, value, params_get(services_params(s), culprit));
    }
    drive_relation(&s->staged, culprit, &low, &high);
    return services_refuse(s, LINK_NO_relation, culprit, low, high);
}

/* Hand `staged` to the drive, all of it or nothing. */
static link_refusal_t take(services_t *s)
{
    drive_t *const d = s->setup.drive;
    if (drive_fault(d) == FAULT_configuration) {
        return bad_state(s); /* its blocks were never built: only a start with other parameters helps */
    }
    uint16_t culprit = PARAM_COUNT;
    if (drive_tune(d, &s->staged, &culprit)) {
        return LINK_FINE;
    }
    return (culprit == (uint16_t)PARAM_COUNT) ? LINK_NO_busy : refused(s, culprit);
}

static link_refusal_t stage(services_t *s, codec_reader_t *in, codec_writer_t *out, uint16_t count)
{
    for (uint16_t i = 0U; i < count; i++) {
        const uint16_t       index = codec_get_u16(in);
        const float          value = codec_get_f32(in);
        const link_refusal_t no = services_index(s, index, PARAM_COUNT);
        if (no != LINK_FINE) {
            return no;
        }
        if (!params_set(&s->staged, index, value)) {
            return services_refuse(s, LINK_NO_range, index, params_info(index)->min, params_info(index)->max);
        }
        codec_put_f32(out, params_get(&s->staged, index));
    }
    return LINK_FINE;
}

link_refusal_t request_set(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    session_t *const n = &s->session;
    const uint16_t   flags = codec_get_u8(in);
    const uint16_t   count = codec_get_u8(in);
    if (!n->may_write) {
        return LINK_NO_schema;
    }
    if (count > SET_MOST) {
        return services_refuse(s, LINK_NO_too_many, count, 0.0f, (float)SET_MOST);
    }
    link_refusal_t no = services_length(s, in, (uint16_t)(2U + (6U * count)));
    if (no != LINK_FINE) {
        return no;
    }
    const bool commit = (flags & SET_COMMIT) != 0U;
    if (services_saving(s) || (commit && drive_change_waits(s->setup.drive))) {
        return LINK_NO_busy; /* nothing is lost: the same request may come again */
    }
    if (((flags & SET_BEGIN) != 0U) || !n->staging) {
        s->staged = *services_params(s);
        n->staging = true;
    }
    codec_put_u8(out, flags);
    codec_put_u8(out, count);
    no = stage(s, in, out, count);
    if ((no == LINK_FINE) && commit) {
        no = take(s);
    }
    n->staging = (no == LINK_FINE) && !commit;
    return no;
}

/* ---- commands ---------------------------------------------------------------------------------------------------------- */

static link_refusal_t save(services_t *s)
{
    s->session.staging = false;
    s->staged = *services_params(s); /* what is saved must not change meanwhile */
    switch (param_store_begin(drive_storage(s->setup.drive), &s->staged, s->schema)) {
    case HAL_OK:
        s->session.storing = LINK_CMD_save;
        return LINK_LATER;
    case HAL_UNSUPPORTED:
        return LINK_NO_unsupported;
    default:
        return LINK_NO_busy;
    }
}

link_refusal_t services_stored(services_t *s, hal_status_t status)
{
    (void)services_refuse(s, LINK_FINE, SERVICES_NO_FIELD, 0.0f, 0.0f);
    return (status == HAL_OK) ? LINK_FINE : LINK_NO_storage;
}

static link_refusal_t from_storage(services_t *s, hal_status_t status)
{
    switch (status) {
    case HAL_OK:
        return LINK_FINE;
    case HAL_STALE:
        return LINK_NO_nothing_stored;
    case HAL_UNSUPPORTED:
        return LINK_NO_unsupported;
    case HAL_BUSY:
        return bad_state(s);
    default:
        return LINK_NO_storage;
    }
}

static link_refusal_t learn_save(services_t *s)
{
    const hal_status_t status = drive_memory_save_begin(s->setup.drive);
    if (status != HAL_OK) {
        return from_storage(s, status);
    }
    s->session.storing = LINK_CMD_learn_save;
    return LINK_LATER;
}

static link_refusal_t restore(services_t *s)
{
    s->session.staging = false;
    s->staged = *services_params(s);
    const link_refusal_t no = from_storage(s, param_store_load(drive_storage(s->setup.drive), &s->staged, s->schema));
    return (no == LINK_FINE) ? take(s) : no;
}

static link_refusal_t defaults(services_t *s)
{
    s->session.staging = false;
    s->staged = *s->setup.defaults;
    return take(s);
}

static link_refusal_t arm(services_t *s)
{
    if (drive_fault(s->setup.drive) != FAULT_none) {
        return bad_state(s);
    }
    s->session.armed = true;
    return LINK_FINE;
}

static link_refusal_t start(services_t *s)
{
    if (!s->session.armed) {
        return LINK_NO_not_armed;
    }
    if (services_saving(s)) {
        return LINK_NO_busy;
    }
    drive_start(s->setup.drive);
    s->session.started = true;
    s->session.by_itself = false;
    s->session.timed_out = false;
    return LINK_FINE;
}

static link_refusal_t home(services_t *s)
{
    if (!s->session.armed) {
        return LINK_NO_not_armed;
    }
    drive_home(s->setup.drive);
    return LINK_FINE;
}

static link_refusal_t when_idle(services_t *s, uint16_t command)
{
    drive_t *const d = s->setup.drive;
    if (services_saving(s) || s->session.stored) { /* one save, one answer */
        return LINK_NO_busy;
    }
    if (!drive_is_idle(s->setup.drive)) {
        return bad_state(s);
    }
    switch (command) {
    case LINK_CMD_save:
        return save(s);
    case LINK_CMD_restore:
        return restore(s);
    case LINK_CMD_defaults:
        return defaults(s);
    case LINK_CMD_learn_clear:
        return drive_memory_clear(d) ? LINK_FINE : bad_state(s);
    case LINK_CMD_learn_save:
        return learn_save(s);
    default:
        return from_storage(s, drive_memory_restore(d));
    }
}

static link_refusal_t obey(services_t *s, uint16_t command)
{
    switch (command) {
    case LINK_CMD_stop:
        drive_stop(s->setup.drive);
        s->session.started = false;
        s->session.by_itself = false;
        return LINK_FINE;
    case LINK_CMD_disarm:
        services_disarm(s);
        return LINK_FINE;
    case LINK_CMD_clear_fault:
        drive_clear_fault(s->setup.drive);
        return LINK_FINE;
    default:
        break;
    }
    if (!s->session.may_write) {
        return LINK_NO_schema;
    }
    switch (command) {
    case LINK_CMD_arm:
        return arm(s);
    case LINK_CMD_start:
        return start(s);
    case LINK_CMD_home:
        return home(s);
    default:
        return when_idle(s, command);
    }
}

link_refusal_t request_command(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    const uint16_t command = codec_get_u16(in);
    link_refusal_t no = services_index(s, command, LINK_COMMANDS);
    if (no == LINK_FINE) {
        no = obey(s, command);
    }
    if (no == LINK_FINE) {
        codec_put_u16(out, command);
        codec_put_u8(out, (uint16_t)drive_state(s->setup.drive));
    }
    return no;
}

/* ---- references, timeout ------------------------------------------------------------------------------------------------- */

static bool inside(float x, float limit) { return (x <= limit) && (x >= -limit); } /* false for NaN */

link_refusal_t request_setpoint(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    if (!s->session.may_write) {
        return LINK_NO_schema;
    }
    const uint16_t  mode = codec_get_u8(in);
    drive_command_t c = {DRIVE_MODE_CURRENT, 0.0f, 0.0f, 0.0f, 0, 0.0f};
    c.speed_ref_rad_s = codec_get_f32(in);
    c.id_ref_a = codec_get_f32(in);
    c.iq_ref_a = codec_get_f32(in);
    c.target_turns = codec_get_i32(in);
    c.target_rad = codec_get_f32(in);
    if (mode > (uint16_t)DRIVE_MODE_TORQUE) {
        return services_refuse(s, LINK_NO_range, 0U, 0.0f, (float)DRIVE_MODE_TORQUE);
    }
    c.mode = (drive_mode_t)mode;
    float          limit = TWO_PI;
    const uint16_t field =
        inside(c.target_rad, limit) ? drive_command_refuses(s->setup.drive, &c, &limit) : (uint16_t)DRIVE_COMMAND_ANGLE;
    if (field == (uint16_t)DRIVE_COMMAND_MODE) {
        return services_refuse(s, LINK_NO_range, 0U, 0.0f, limit);
    }
    if (field != (uint16_t)DRIVE_COMMAND_FINE) {
        return services_refuse(s, LINK_NO_range, field, -limit, limit);
    }
    (void)drive_command(s->setup.drive, &c);
    codec_put_u32(out, s->counter);
    return LINK_FINE;
}

link_refusal_t request_excite(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    if (!s->session.may_write) {
        return LINK_NO_schema;
    }
    if (services_saving(s)) {
        return LINK_NO_busy;
    }
    const uint16_t     where = codec_get_u8(in);
    drive_excitation_t e = {DRIVE_EXCITE_NONE, codec_get_f32(in), 0.0f};
    float              low = 0.0f;
    float              high = (float)DRIVE_EXCITES - 1.0f;
    float              hz = 0.0f;
    e.hz = codec_get_f32(in);
    if (where >= (uint16_t)DRIVE_EXCITES) {
        return services_refuse(s, LINK_NO_range, 0U, low, high);
    }
    e.where = (drive_excite_t)where;
    const uint16_t field = drive_excite(s->setup.drive, &e, &low, &high, &hz);
    if (field == (uint16_t)DRIVE_EXCITE_STATE) {
        return bad_state(s);
    }
    if (field != (uint16_t)DRIVE_EXCITE_FINE) {
        return services_refuse(s, LINK_NO_range, field, low, high);
    }
    codec_put_u32(out, s->counter);
    codec_put_f32(out, hz);
    return LINK_FINE;
}

link_refusal_t request_timeout(services_t *s, codec_reader_t *in, codec_writer_t *out)
{
    const uint16_t ms = codec_get_u16(in);
    if (!s->session.may_write) {
        return LINK_NO_schema;
    }
    if (((ms != 0U) || s->session.by_itself) && ((ms < TIMEOUT_MIN_MS) || (ms > TIMEOUT_MAX_MS))) {
        return services_refuse(s, LINK_NO_range, 0U, (float)TIMEOUT_MIN_MS, (float)TIMEOUT_MAX_MS);
    }
    s->session.timeout_ms = ms;
    codec_put_u16(out, ms);
    return LINK_FINE;
}
