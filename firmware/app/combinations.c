/* What does not go together, from combinations.def. Main loop. */
#include "firmware/app/combinations.h"

#include <stddef.h>

#include "firmware/app/internal.h"

enum {
#define COMBINATION(name, param, other, when, why) COMBINATION_##name,
#include "firmware/app/combinations.def"
#undef COMBINATION
    COMBINATION_COUNT
};

static const combination_info_t TABLE[COMBINATION_COUNT] = {
#define COMBINATION(name, param, other, when, why) {DOC_TEXT(#name) DOC_TEXT(why) PARAM_##param, PARAM_##other},
#include "firmware/app/combinations.def"
#undef COMBINATION
};

const combination_info_t *combinations_info(uint16_t index)
{
    return (index < (uint16_t)COMBINATION_COUNT) ? &TABLE[index] : NULL;
}

static bool breaks(const drive_params_t *p, uint16_t rule)
{
    switch (rule) {
#define COMBINATION(name, param, other, when, why)                                                                               \
    case COMBINATION_##name:                                                                                                     \
        return when;
#include "firmware/app/combinations.def"
#undef COMBINATION
    default:
        return true;
    }
}

uint16_t combinations_broken(const drive_params_t *p)
{
    uint16_t rule = 0U;
    while ((rule < (uint16_t)COMBINATION_COUNT) && !breaks(p, rule)) {
        rule++;
    }
    return rule;
}

uint16_t drive_combination_refuses(const drive_params_t *p)
{
    const combination_info_t *const broken = combinations_info(combinations_broken(p));
    return (broken != NULL) ? broken->param : (uint16_t)PARAM_COUNT;
}
