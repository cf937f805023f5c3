#include "sim_host/capi/error.h"

#include <stdio.h>

bool capi_refuse(es_error_t *error, es_code_t code, const char *list, const char *name, double given)
{
    return capi_refuse_with(error, code, list, name, given, "");
}

bool capi_refuse_with(es_error_t *error, es_code_t code, const char *list, const char *name, double given, const char *other)
{
    if (error != NULL) {
        const es_error_t made = {.code = code, .list = list, .other = other, .given = given, .unit = "", .rule = ""};
        *error = made;
        (void)snprintf(error->name, sizeof error->name, "%s", (name != NULL) ? name : "");
    }
    return false;
}

bool capi_refuse_range(es_error_t *error, es_code_t code, const char *list, const char *name, double given, double min,
                       double max, const char *unit)
{
    (void)capi_refuse(error, code, list, name, given);
    if (error != NULL) {
        error->min = min;
        error->max = max;
        error->unit = unit;
    }
    return false;
}

bool capi_fill(es_field_t *out, const char *name, const char *unit, const char *kind, const char *doc, const char *choices,
               double min, double max, double value)
{
    if (out == NULL) {
        return false;
    }
    const es_field_t f = {.name = name,
                          .unit = unit,
                          .kind = kind,
                          .doc = doc,
                          .choices = choices,
                          .min = min,
                          .max = max,
                          .value = value,
                          .rule = ""};
    *out = f;
    return true;
}
