/**
 * @file  sim_host/capi/error.h
 * @brief Refusals as values. The functions return false, for `return capi_refuse(...)`; a NULL @p error is allowed.
 */
#ifndef SIM_HOST_CAPI_ERROR_H
#define SIM_HOST_CAPI_ERROR_H

#include "sim_host/capi/evenspin_capi.h"

/** Note that @p given was refused for @p name of @p list. */
bool capi_refuse(es_error_t *error, es_code_t code, const char *list, const char *name, double given);
/** Note a refusal that has a second name, @p other. */
bool capi_refuse_with(es_error_t *error, es_code_t code, const char *list, const char *name, double given, const char *other);
/** Note a refusal with what is allowed, from @p min to @p max, both included. */
bool capi_refuse_range(es_error_t *error, es_code_t code, const char *list, const char *name, double given, double min,
                       double max, const char *unit);
/** A field of a list: fills @p out, or says false when that is NULL. */
bool capi_fill(es_field_t *out, const char *name, const char *unit, const char *kind, const char *doc, const char *choices,
               double min, double max, double value);

#endif
