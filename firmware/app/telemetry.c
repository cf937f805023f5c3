#include "firmware/app/telemetry.h"

static const signal_info_t TABLE[SIGNAL_COUNT] = {
#define SIGNAL(name, unit, expression, doc) {#name, unit, doc},
#include "firmware/app/telemetry.def"
#undef SIGNAL
};

const signal_info_t *telemetry_info(uint16_t index) { return (index < (uint16_t)SIGNAL_COUNT) ? &TABLE[index] : NULL; }

float telemetry_read(const drive_t *d, uint16_t index)
{
    switch (index) {
#define SIGNAL(name, unit, expression, doc)                                                                                      \
    case SIGNAL_##name:                                                                                                          \
        return (expression);
#include "firmware/app/telemetry.def"
#undef SIGNAL
    default:
        return 0.0f;
    }
}

static uint32_t rejected_current(const drive_current_t *c)
{
    return c->d.state.rejected + c->q.state.rejected + c->deadbeat.state.rejected;
}

static uint32_t rejected_speed(const drive_speed_t *v, const drive_speed_setup_t *s)
{
    return v->pi.state.rejected + (s->rc_used ? v->rc.state.rejected : 0U);
}

static uint32_t rejected_observer(const drive_observer_t *o, const drive_observer_setup_t *s)
{
    return (s->meter_used ? o->meter.state.rejected : 0U) +
           (s->used ? (o->observer.state.rejected + o->observer.state.memory.state.rejected) : 0U);
}

static uint32_t rejected_position(const drive_position_t *o)
{
    return o->pi.state.rejected + o->ilc.state.rejected + o->learn.state.rejected + o->src.state.rejected + o->rdc.state.rejected;
}

uint32_t drive_rejected(const drive_t *d)
{
    return d->rejected + rejected_current(&d->current) + rejected_speed(&d->speed, &d->setup->speed) +
           rejected_observer(&d->observer, &d->setup->observer) + rejected_position(&d->position);
}
