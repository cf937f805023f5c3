/**
 * @file  sim_host/capi/block.h
 * @brief A control block for Python: its parameters, its actions, and how it is started. Each file of blocks/ has one.
 *
 * Parameters are checked against their list first; `start` turns them into those of the block, which has the last word. A
 * step here is the step that the interrupt runs, without checks of its own where that has none. The check stands in front, in
 * `capi_usable`: an input that is not usable goes to the checked entry of the block, which counts and replaces it.
 */
#ifndef SIM_HOST_CAPI_BLOCK_H
#define SIM_HOST_CAPI_BLOCK_H

#include <stddef.h>

#include "control/numeric/angle.h"
#include "control/numeric/diag.h"
#include "sim_host/capi/error.h"

#define CAPI_PI 3.14159265358979323846
#define CAPI_PARAMS_MAX 20
#define CAPI_ACTIONS_MAX 8
#define CAPI_PORTS_MAX 8 /* inputs, outputs of an action */
#define CAPI_STARTED (-1)

/** What the ends of a range are. */
typedef enum { CAPI_CLOSED = 0, CAPI_ABOVE = 1, CAPI_BELOW = 2 } capi_ends_t;

typedef enum { CAPI_REAL = 0, CAPI_WHOLE, CAPI_FLAG, CAPI_CHOICE } capi_kind_t;

typedef struct {
    const char *name, *unit;
    capi_kind_t kind;
    double      value, min, max; /**< Default and range. */
    const char *doc;
    unsigned    ends;    /**< CAPI_ABOVE | CAPI_BELOW: without that end. */
    const char *choices; /**< "a|b|c" of a choice; else NULL. */
    const char *rule;    /**< "such that ...": what `start` may refuse it for; NULL nothing. */
} capi_param_t;

typedef struct {
    const char *name, *doc;
    const char *inputs, *outputs; /**< "a|b|c", at most CAPI_PORTS_MAX; NULL none. */
    void (*run)(void *self, const double *in, double *out);
} capi_action_t;

typedef struct {
    const char   *name, *doc;
    capi_param_t  param[CAPI_PARAMS_MAX];
    capi_action_t action[CAPI_ACTIONS_MAX];
    size_t        size;                                                  /**< Of the object that start and run get. */
    int (*cells)(const double *p);                                       /**< Numbers of memory that it needs; NULL none. */
    int (*start)(void *self, const double *p, num_t *memory, int cells); /**< CAPI_STARTED, or the refused parameter. */
    int (*table)(const void *self, double *out, int room);               /**< See es_block_table; NULL none. */
} capi_block_t;

extern const capi_block_t *const capi_blocks[];
extern const int                 capi_block_total;

/* ---- numbers: conversion, nothing else ------------------------------------------------------------------------------ */

static inline num_t  capi_in(double x) { return num_from_float((float)x); }
static inline double capi_out(num_t x) { return (double)num_to_float(x); }
/** A signal keeps its NaN or infinity, so that the guard of the block is what answers. */
num_t capi_signal_in(double x);
/** Angle in turns modulo one; 0 for what is not finite. */
angle_t capi_angle_in(double rad);
/** Finite, and of a size that no product of a block can overflow. */
bool capi_usable(const double *x, int count);
/** The parameter that the block means, of a table from the field of its diagnosis. */
int capi_refused(ctl_diag_t diag, const int *param_of_field, size_t fields, int fallback);

#endif
