#include "firmware/app/telemetry.h"

static const signal_info_t TABLE[SIGNAL_COUNT] = {
#define SIGNAL(name, unit, expression, doc) {#name, unit, DOC_TEXT(doc)},
#include "firmware/app/telemetry.def"
#undef SIGNAL
};

const signal_info_t *telemetry_info(uint16_t index) { return (index < (uint16_t)SIGNAL_COUNT) ? &TABLE[index] : NULL; }

static inline float read_one(const drive_t *d, uint16_t index)
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

void telemetry_read_row(const drive_t *d, const uint16_t *signals, uint16_t count, float *row)
{
    for (uint16_t i = 0U; i < count; i++) {
        row[i] = read_one(d, signals[i]);
    }
}

float telemetry_read(const drive_t *d, uint16_t index)
{
    float value = 0.0f;
    telemetry_read_row(d, &index, 1U, &value);
    return value;
}
