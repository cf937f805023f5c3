#include "firmware/services/recorder.h"

#include "firmware/app/telemetry.h"
#include "hal/hal_order.h"

void recorder_init(recorder_t *r, float *memory, uint16_t values)
{
    r->status = RECORDER_NEVER;
    r->value = memory;
    r->values = values;
    r->config.count = 0U;
    r->number = 0U;
    r->held = 0U;
}

static void begin(recorder_t *r)
{
    r->manual = 0U;
    r->end = (uint16_t)((r->config.pre + r->config.post) * r->config.count); /* within `values` */
    r->at = 0U;
    r->held = 0U;
    r->wait = 0U;
    r->left = r->config.post;
    r->before = 0U;
    r->after = r->config.post;
    r->primed = false;
    r->faulty = true; /* a fault that stands is none that appears */
    hal_order();
    r->status = (r->config.pre > 0U) ? RECORDER_FILLING : RECORDER_WAITING;
}

void recorder_start(recorder_t *r, const recorder_config_t *config)
{
    r->status = RECORDER_STOPPED; /* from here on the interrupt leaves it alone */
    hal_order();
    r->config = *config;
    r->number = (r->number + 1U) & 0xFFU;
    begin(r);
}

void recorder_stop(recorder_t *r)
{
    if ((r->status != RECORDER_NEVER) && (r->status != RECORDER_COMPLETE)) {
        r->status = RECORDER_STOPPED;
    }
}

void recorder_trigger(recorder_t *r) { r->manual = 1U; }

void recorder_restart(recorder_t *r)
{
    if (r->config.count > 0U) {
        const recorder_config_t same = r->config;
        recorder_start(r, &same);
    }
}

/* ---- current interrupt ----------------------------------------------------------------------------------------------- */

/* Both must be evaluated in every period: an edge is a difference to the last one. */
static bool edge(recorder_t *r, const drive_t *d)
{
    const float now = telemetry_read(d, r->config.trigger_signal);
    const float level = r->config.level;
    const bool  rises = r->primed && (r->last < level) && (now >= level);
    const bool  falls = r->primed && (r->last > level) && (now <= level);
    r->last = now;
    r->primed = true;
    return ((r->config.trigger != RECORDER_FALLING) && rises) || ((r->config.trigger != RECORDER_RISING) && falls);
}

static bool fault_appears(recorder_t *r, const drive_t *d)
{
    const bool now = drive_fault(d) != FAULT_none;
    const bool appears = now && !r->faulty;
    r->faulty = now;
    return appears;
}

static bool fires(recorder_t *r, const drive_t *d, bool ready)
{
    bool hit = false;
    switch (r->config.trigger) {
    case RECORDER_AT_ONCE:
        hit = ready;
        break;
    case RECORDER_RISING:
    case RECORDER_FALLING:
    case RECORDER_EITHER:
        hit = edge(r, d) && ready;
        break;
    case RECORDER_AT_FAULT:
        hit = fault_appears(r, d);
        break;
    case RECORDER_MANUAL:
    case RECORDER_TRIGGERS:
    default:
        break;
    }
    return hit || (r->manual != 0U);
}

static inline void store(recorder_t *r, const drive_t *d)
{
    const uint16_t count = r->config.count;
    const uint16_t at = r->at;
    const uint16_t next = (uint16_t)(at + count);
    telemetry_read_row(d, r->config.signal, count, &r->value[at]);
    r->at = (next < r->end) ? next : 0U;
}

void recorder_sample(recorder_t *r, const drive_t *d, uint32_t counter)
{
    uint16_t status = r->status;
    if ((status < RECORDER_FILLING) || (status > RECORDER_AFTER)) {
        return;
    }
    if ((status != RECORDER_AFTER) && fires(r, d, status == RECORDER_WAITING)) {
        r->before = (r->held < r->config.pre) ? r->held : r->config.pre;
        r->trigger_counter = counter;
        status = RECORDER_AFTER;
        r->status = status;
    }
    if (r->wait > 0U) {
        r->wait--;
        return;
    }
    r->wait = (uint16_t)(r->config.decimation - 1U);
    store(r, d);
    if (status == RECORDER_AFTER) {
        if (r->left == r->config.post) {
            r->first = counter - ((uint32_t)r->before * r->config.decimation);
            r->held = r->before;
        }
        r->held++;
        r->left--;
        if (r->left == 0U) {
            r->status = RECORDER_COMPLETE;
        }
    } else if (r->held < r->config.pre) {
        r->held++;
        if (r->held == r->config.pre) {
            r->status = RECORDER_WAITING;
        }
    } else {
        /* the ring turns */
    }
}

/* ---- after a reset ---------------------------------------------------------------------------------------------------- */

/* Whether the ring can be read at all: everything that an index is made of. */
static bool is_sound(const recorder_t *r, const float *memory, uint16_t values)
{
    const recorder_config_t *const c = &r->config;
    const uint32_t                 rows = (uint32_t)c->pre + c->post;
    bool sound = (r->value == memory) && (r->values == values) && (r->status >= RECORDER_FILLING) &&
                 (r->status <= RECORDER_COMPLETE) && (c->count > 0U) && (c->count <= RECORDER_SIGNALS) && (c->decimation > 0U) &&
                 (rows <= values) && ((rows * c->count) <= values) && (r->end == (uint16_t)(rows * c->count)) &&
                 (r->at < r->end) && ((r->at % c->count) == 0U) && (r->before <= c->pre) && (r->left <= c->post) &&
                 (r->after <= c->post);
    for (uint16_t i = 0U; i < RECORDER_SIGNALS; i++) {
        sound = sound && ((i >= c->count) || (c->signal[i] < (uint16_t)SIGNAL_COUNT));
    }
    return sound;
}

bool recorder_revive(recorder_t *r, float *memory, uint16_t values, uint32_t counter)
{
    if (!is_sound(r, memory, values)) {
        return false;
    }
    if (r->status != RECORDER_COMPLETE) {
        if (r->status == RECORDER_AFTER) {
            r->after = (uint16_t)(r->config.post - r->left);
        } else { /* the trigger never came: all that is there was before the end */
            r->before = (r->held < r->config.pre) ? r->held : r->config.pre;
            r->after = 0U;
            r->trigger_counter = counter;
        }
        if (r->after == 0U) {
            r->first = counter - ((uint32_t)r->before * r->config.decimation);
        }
        r->held = (uint16_t)(r->before + r->after);
        r->left = 0U;
        r->status = RECORDER_COMPLETE;
    }
    return recorder_rows(r) > 0U;
}

/* ---- reading --------------------------------------------------------------------------------------------------------- */

uint16_t recorder_rows(const recorder_t *r)
{
    if (r->status != RECORDER_COMPLETE) {
        return 0U;
    }
    hal_order(); /* what it recorded comes after its status */
    return (uint16_t)(r->before + r->after);
}

float recorder_value(const recorder_t *r, uint16_t offset)
{
    const uint16_t count = (uint16_t)((r->before + r->after) * r->config.count);
    const uint16_t back = (uint16_t)(count - offset); /* from the next value to write */
    const uint16_t at = (back <= r->at) ? (uint16_t)(r->at - back) : (uint16_t)((uint16_t)(r->at + r->end) - back);
    return r->value[at];
}
