/**
 * @file  firmware/app/telemetry.h
 * @brief The signals that the drive can show, made from telemetry.def.
 */
#ifndef FIRMWARE_APP_TELEMETRY_H
#define FIRMWARE_APP_TELEMETRY_H

#include "firmware/app/doc_text.h"
#include "firmware/app/drive.h"

typedef struct {
    const char *name, *unit;
    DOC_MEMBER(const char *doc;)
} signal_info_t;

enum {
#define SIGNAL(name, unit, expression, doc) SIGNAL_##name,
#include "firmware/app/telemetry.def"
#undef SIGNAL
    SIGNAL_COUNT
};

/** Row of the list; NULL beyond its end. */
const signal_info_t *telemetry_info(uint16_t index);
/** Value of a signal now; 0 beyond the list. */
float telemetry_read(const drive_t *d, uint16_t index);
/** Values of @p count signals, in one call: 27 cycles less for each. */
void telemetry_read_row(const drive_t *d, const uint16_t *signals, uint16_t count, float *row);

#endif
