#include "firmware/app/parameters.h"

#include <stddef.h>

static const param_info_t TABLE[PARAM_COUNT] = {
#define PARAM_F(name, unit, def, lo, hi, doc)                                                                                    \
    {#name, unit, DOC_TEXT(doc) lo, hi, def, PARAM_KIND_FLOAT, offsetof(drive_params_t, name)},
#define PARAM_U(name, unit, def, lo, hi, doc)                                                                                    \
    {#name, unit, DOC_TEXT(doc)(float)(lo), (float)(hi), (float)(def), PARAM_KIND_INTEGER, offsetof(drive_params_t, name)},
#define PARAM_B(name, def, doc)                                                                                                  \
    {#name, "", DOC_TEXT(doc) 0.0f, 1.0f, (float)(def), PARAM_KIND_FLAG, offsetof(drive_params_t, name)},
#define PARAM_E(name, def, choices, count, doc)                                                                                  \
    {#name, choices, DOC_TEXT(doc) 0.0f, (float)((count) - 1), (float)(def), PARAM_KIND_CHOICE, offsetof(drive_params_t, name)},
#include "firmware/app/parameters.def"
#undef PARAM_F
#undef PARAM_U
#undef PARAM_B
#undef PARAM_E
};

const param_info_t *params_info(uint16_t index) { return (index < (uint16_t)PARAM_COUNT) ? &TABLE[index] : NULL; }

/* offsetof counts char cells on every machine, 16-bit ones on the chip, and so does this pointer. */
static const void *field(const drive_params_t *p, uint16_t index) { return (const char *)p + TABLE[index].offset; }

static void put(drive_params_t *p, uint16_t index, float value)
{
    char *const cell = (char *)p + TABLE[index].offset;
    if (TABLE[index].kind == (uint16_t)PARAM_KIND_FLOAT) {
        *(float *)(void *)cell = value;
    } else {
        *(uint16_t *)(void *)cell = (uint16_t)value;
    }
}

void params_default(drive_params_t *p)
{
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        put(p, i, TABLE[i].def);
    }
}

float params_get(const drive_params_t *p, uint16_t index)
{
    if (index >= (uint16_t)PARAM_COUNT) {
        return 0.0f;
    }
    if (TABLE[index].kind == (uint16_t)PARAM_KIND_FLOAT) {
        return *(const float *)field(p, index);
    }
    return (float)*(const uint16_t *)field(p, index);
}

static bool inside(const param_info_t *info, float value)
{
    return (value >= info->min) && (value <= info->max); /* false for NaN */
}

bool params_set(drive_params_t *p, uint16_t index, float value)
{
    if ((index >= (uint16_t)PARAM_COUNT) || !inside(&TABLE[index], value)) {
        return false;
    }
    const bool fraction = (TABLE[index].kind != (uint16_t)PARAM_KIND_FLOAT) && ((float)(uint16_t)value != value);
    if (!fraction) {
        put(p, index, value);
    }
    return !fraction;
}

bool params_only_at_rest(uint16_t index)
{
    static const uint16_t MARK[PARAM_COUNT] = {
#define AT_REST 1U |
#define PARAM_F(name, unit, def, lo, hi, doc) 0U,
#define PARAM_U(name, unit, def, lo, hi, doc) 0U,
#define PARAM_B(name, def, doc) 0U,
#define PARAM_E(name, def, choices, count, doc) 0U,
#include "firmware/app/parameters.def"
#undef PARAM_F
#undef PARAM_U
#undef PARAM_B
#undef PARAM_E
    };
    return (index < (uint16_t)PARAM_COUNT) && (MARK[index] != 0U);
}

uint16_t params_check(const drive_params_t *p)
{
    uint16_t i = 0U;
    while ((i < (uint16_t)PARAM_COUNT) && inside(&TABLE[i], params_get(p, i))) {
        i++;
    }
    return i;
}
