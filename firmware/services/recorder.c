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

/* ---- reading --------------------------------------------------------------------------------------------------------- */

uint16_t recorder_rows(const recorder_t *r)
{
    if (r->status != RECORDER_COMPLETE) {
        return 0U;
    }
    hal_order(); /* what it recorded comes after its status */
    return (uint16_t)(r->before + r->config.post);
}

float recorder_value(const recorder_t *r, uint16_t offset)
{
    const uint16_t count = (uint16_t)((r->before + r->config.post) * r->config.count);
    const uint16_t back = (uint16_t)(count - offset); /* from the next value to write */
    const uint16_t at = (back <= r->at) ? (uint16_t)(r->at - back) : (uint16_t)((uint16_t)(r->at + r->end) - back);
    return r->value[at];
}
