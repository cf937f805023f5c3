/**
 * @file  firmware/app/parameters.h
 * @brief The drive parameters: one struct and one table, both made from parameters.def.
 */
#ifndef FIRMWARE_APP_PARAMETERS_H
#define FIRMWARE_APP_PARAMETERS_H

#include <stdbool.h>
#include <stdint.h>

#include "firmware/app/doc_text.h"

typedef struct {
#define PARAM_F(name, unit, def, lo, hi, doc) float name;
#define PARAM_U(name, unit, def, lo, hi, doc) uint16_t name;
#define PARAM_B(name, def, doc) uint16_t name;
#define PARAM_E(name, def, choices, count, doc) uint16_t name;
#include "firmware/app/parameters.def"
#undef PARAM_F
#undef PARAM_U
#undef PARAM_B
#undef PARAM_E
} drive_params_t;

typedef enum { PARAM_KIND_FLOAT = 0, PARAM_KIND_INTEGER, PARAM_KIND_FLAG, PARAM_KIND_CHOICE } param_kind_t;

typedef struct {
    const char *name, *text; /**< Unit, or of a choice its words: "a|b|c". */
    DOC_MEMBER(const char *doc;)
    float    min, max, def;
    uint16_t kind;   /**< param_kind_t. */
    uint16_t offset; /**< In drive_params_t. */
} param_info_t;

static inline const char *params_unit(const param_info_t *p) { return (p->kind == (uint16_t)PARAM_KIND_CHOICE) ? "" : p->text; }
static inline const char *params_choices(const param_info_t *p)
{
    return (p->kind == (uint16_t)PARAM_KIND_CHOICE) ? p->text : "";
}

/** Position of each parameter in the table. */
enum {
#define PARAM_F(name, unit, def, lo, hi, doc) PARAM_##name,
#define PARAM_U(name, unit, def, lo, hi, doc) PARAM_##name,
#define PARAM_B(name, def, doc) PARAM_##name,
#define PARAM_E(name, def, choices, count, doc) PARAM_##name,
#include "firmware/app/parameters.def"
#undef PARAM_F
#undef PARAM_U
#undef PARAM_B
#undef PARAM_E
    PARAM_COUNT
};

/** Row of the table; NULL beyond its end. */
const param_info_t *params_info(uint16_t index);
/** All parameters to their defaults. */
void params_default(drive_params_t *p);
/** Value of a parameter; 0 beyond the table. */
float params_get(const drive_params_t *p, uint16_t index);
/** Set one parameter. Refuses NaN, what is out of range, and a fraction for a whole number; @p p then stays as it was. */
bool params_set(drive_params_t *p, uint16_t index, float value);
/** Whether it may only change while the bridge is off: AT_REST in parameters.def. */
bool params_only_at_rest(uint16_t index);
/** First parameter outside its range, or PARAM_COUNT when all are inside. */
uint16_t params_check(const drive_params_t *p);

#endif
