#include "firmware/app/telemetry.h"

#include "firmware/app/doc_text.h"

static const signal_info_t TABLE[SIGNAL_COUNT] = {
#define SIGNAL(name, unit, expression, doc) {#name, unit, DOC_TEXT(doc)},
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
