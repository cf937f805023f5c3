#include "tests/sim_host/support/machine.h"

sim_plant_t plant;
sim_model_t model;
double      effect_values[EFFECTS_AT_MOST][SIM_EFFECT_PARAMS];

void machine_defaults(void)
{
    sim_model_default(&model);
    TEST_ASSERT_TRUE(sim_effect_total <= EFFECTS_AT_MOST);
    for (int e = 0; e < sim_effect_total; e++) {
        for (int k = 0; k < sim_effects[e]->param_count; k++) {
            effect_values[e][k] = sim_effects[e]->param[k].off;
        }
    }
}

int machine_effect(const char *effect)
{
    for (int e = 0; e < sim_effect_total; e++) {
        if (strcmp(effect, sim_effects[e]->name) == 0) {
            return e;
        }
    }
    TEST_FAIL_MESSAGE(effect);
    return -1;
}

void machine_set(const char *effect, const char *param, double value)
{
    const int e = machine_effect(effect);
    for (int k = 0; k < sim_effects[e]->param_count; k++) {
        if (strcmp(param, sim_effects[e]->param[k].name) == 0) {
            effect_values[e][k] = value;
            return;
        }
    }
    TEST_FAIL_MESSAGE(param);
}

const char *machine_try_start(void)
{
    return sim_plant_start(&plant, &model, (const double (*)[SIM_EFFECT_PARAMS])effect_values, 4000.0, 1U);
}

void machine_start(void)
{
    const char *const refused = machine_try_start();
    TEST_ASSERT_NULL_MESSAGE(refused, refused);
}

void machine_duties(double alpha_v, double beta_v, double duty[3])
{
    const double v = sim_plant_dc_link_v(&plant);
    duty[0] = 0.5 + alpha_v / v;
    duty[1] = 0.5 + (-0.5 * alpha_v + 0.5 * SQRT3 * beta_v) / v;
    duty[2] = 0.5 + (-0.5 * alpha_v - 0.5 * SQRT3 * beta_v) / v;
}

void machine_voltage(double alpha_v, double beta_v, int periods)
{
    double duty[3];
    machine_duties(alpha_v, beta_v, duty);
    for (int k = 0; k < periods; k++) {
        sim_plant_period(&plant, duty, true);
    }
    sim_plant_find_edge(&plant);
}

void machine_dq_voltage(double d_v, double q_v, int periods)
{
    for (int k = 0; k < periods; k++) {
        const double e = model.pole_pairs * plant.x.theta_m_rad;
        machine_voltage(d_v * cos(e) - q_v * sin(e), d_v * sin(e) + q_v * cos(e), 1);
    }
}

void machine_coast(int periods)
{
    const double none[3] = {0.9, 0.1, 0.5}; /* duties do not matter then */
    for (int k = 0; k < periods; k++) {
        sim_plant_period(&plant, none, false);
    }
    sim_plant_find_edge(&plant);
}

const char *at(const char *format, ...)
{
    static char text[160];
    va_list     arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return text;
}
