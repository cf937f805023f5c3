#include "sim_host/plant/model.h"

#include <math.h>
#include <stddef.h>

static const sim_field_t TABLE[] = {
#define MODEL_F(name, unit, def, lo, hi, doc) {#name, unit, doc, lo, hi, def, SIM_REAL},
#define MODEL_I(name, unit, def, lo, hi, doc) {#name, unit, doc, lo, hi, def, SIM_WHOLE},
#define MODEL_B(name, def, doc) {#name, "", doc, 0, 1, def, SIM_SWITCH},
#include "sim_host/plant/model.def"
#undef MODEL_F
#undef MODEL_I
#undef MODEL_B
};

int sim_model_count(void) { return (int)(sizeof TABLE / sizeof TABLE[0]); }

const sim_field_t *sim_model_info(int index) { return ((index >= 0) && (index < sim_model_count())) ? &TABLE[index] : NULL; }

/* The struct is nothing but doubles in the order of the table. */
double *sim_model_at(sim_model_t *m, int index) { return (double *)m + index; }

void sim_model_default(sim_model_t *m)
{
    for (int i = 0; i < sim_model_count(); i++) {
        *sim_model_at(m, i) = TABLE[i].def;
    }
}

bool sim_field_accepts(const sim_field_t *field, double value)
{
    return (value >= field->min) && (value <= field->max) && ((field->kind == SIM_REAL) || (floor(value) == value));
}
