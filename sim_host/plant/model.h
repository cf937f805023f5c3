/**
 * @file  sim_host/plant/model.h
 * @brief The numbers of the simulated machine, made from model.def. SI units, double: the physics is not the firmware.
 */
#ifndef SIM_HOST_PLANT_MODEL_H
#define SIM_HOST_PLANT_MODEL_H

#include <stdbool.h>

typedef struct {
#define MODEL_F(name, unit, def, lo, hi, doc) double name;
#define MODEL_I(name, unit, def, lo, hi, doc) double name;
#define MODEL_B(name, def, doc) double name;
#include "sim_host/plant/model.def"
#undef MODEL_F
#undef MODEL_I
#undef MODEL_B
} sim_model_t;

typedef enum { SIM_REAL = 0, SIM_WHOLE, SIM_SWITCH } sim_kind_t;

typedef struct {
    const char *name, *unit, *doc;
    double      min, max, def;
    sim_kind_t  kind;
} sim_field_t;

int                sim_model_count(void);
const sim_field_t *sim_model_info(int index); /* NULL beyond the end */
void               sim_model_default(sim_model_t *m);
double            *sim_model_at(sim_model_t *m, int index);
/** True when @p value may be given to @p field: finite, in range, whole where it must be. */
bool sim_field_accepts(const sim_field_t *field, double value);

#endif
