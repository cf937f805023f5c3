#include "tests/scenario/support/rig.h"

es_sim_t *rig;

void rig_free(void)
{
    es_sim_free(rig);
    rig = NULL;
}

void rig_new(void)
{
    rig_free();
    rig = es_sim_new();
    TEST_ASSERT_NOT_NULL(rig);
    rig_param("auto_run", 1.0);
    rig_param("offset_calibration_periods", 0.0);
    rig_param("align_periods", 0.0);
}

void rig_model(const char *name, double value)
{
    TEST_ASSERT_TRUE_MESSAGE(es_sim_set_model(rig, name, value), es_sim_error(rig)->name);
}
void rig_param(const char *name, double value)
{
    TEST_ASSERT_TRUE_MESSAGE(es_sim_set_param(rig, name, value), es_sim_error(rig)->name);
}
void rig_effect(const char *effect, const char *param, double value)
{
    TEST_ASSERT_TRUE_MESSAGE(es_sim_set_effect(rig, effect, param, value), es_sim_error(rig)->name);
}

void rig_input(const char *name, double value)
{
    const double t = 0.0;
    TEST_ASSERT_TRUE_MESSAGE(es_sim_set_input(rig, name, &t, &value, 1, false), es_sim_error(rig)->name);
}

void rig_step(const char *name, double before, double at_s, double after)
{
    const double t[2] = {0.0, at_s};
    const double v[2] = {before, after};
    TEST_ASSERT_TRUE_MESSAGE(es_sim_set_input(rig, name, t, v, 2, false), es_sim_error(rig)->name);
}

void rig_start(void) { TEST_ASSERT_TRUE_MESSAGE(es_sim_start(rig), es_sim_error(rig)->name); }
void rig_run(int64_t periods) { TEST_ASSERT_EQUAL_INT64(0, es_sim_run(rig, periods, 1, NULL, 0)); }

double rig_read(const char *signal)
{
    const double x = es_sim_read(rig, signal);
    TEST_ASSERT_FALSE_MESSAGE(isnan(x), signal);
    return x;
}

const char *rig_fault(void)
{
    es_fault_t f;
    TEST_ASSERT_TRUE(es_fault_info((int)rig_read("fault"), &f));
    return f.name;
}
