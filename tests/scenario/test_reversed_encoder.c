/* An encoder that counts down when the motor turns forward, on a board of this test's own. */
#include "firmware/app/telemetry.h"
#include "hal/hal_clock.h"
#include "hal/hal_inverter.h"
#include "hal/hal_limits.h"
#include "hal/hal_storage.h"
#include "sim_host/plant/plant.h"
#include "tests/support/numeric.h"

static sim_plant_t plant;
static drive_t     drive;
static double      duty_now[3], duty_next[3];
static bool        armed, gates_on, speed_wanted;
static uint32_t    seq;

/* ---- the board ------------------------------------------------------------------------------------------------------ */

hal_status_t hal_sample_read(hal_sample_t *out)
{
    sim_reading_t r;
    sim_plant_read(&plant, &r);
    out->ia_a = (float)r.ia_a;
    out->ib_a = (float)r.ib_a;
    out->ic_a = -out->ia_a - out->ib_a;
    out->vdc_v = (float)r.vdc_v;
    out->theta_m = 0U - (uint32_t)(uint64_t)(r.theta_m_rad / TWO_PI * 4294967296.0); /* reversed */
    out->at_cyc = hal_clock_cyc();
    out->seq = ++seq;
    return HAL_OK;
}

static uint32_t cycles(double t) { return (uint32_t)(int64_t)(t * 2e8 + 0.5); }

hal_status_t hal_encoder_edge(hal_encoder_edge_t *out)
{
    (void)memset(out, 0, sizeof *out);
    sim_plant_find_edge(&plant);
    out->edge_count = (int32_t)-plant.edge_count; /* reversed */
    out->edge_cyc = cycles(plant.edge_time_s);
    return HAL_OK;
}

hal_status_t hal_inverter_set_duty(const hal_duty_t *duty)
{
    duty_next[0] = (double)duty->a;
    duty_next[1] = (double)duty->b;
    duty_next[2] = (double)duty->c;
    return HAL_OK;
}
hal_status_t hal_inverter_arm(void)
{
    armed = true;
    return HAL_OK;
}
void hal_inverter_disarm(void)
{
    armed = false;
    gates_on = false;
}
hal_inverter_fault_t hal_inverter_fault(void) { return HAL_INVERTER_FINE; }
void                 hal_inverter_clear_fault(void) {}
uint32_t             hal_clock_cyc(void) { return cycles(plant.time_s); }
uint32_t             hal_clock_hz(void) { return 200000000U; }
void                 hal_clock_request_speed_isr(void) { speed_wanted = true; }
hal_status_t         hal_temperature(hal_temperature_t which, float *celsius)
{
    (void)which;
    *celsius = 0.0f;
    return HAL_UNSUPPORTED;
}
uint16_t     hal_sto(void) { return 0U; }
void         hal_brake_duty(float duty) { (void)duty; }
void         hal_limits(hal_limits_t *out) { *out = (hal_limits_t){1000.0f, 1000.0f, 20000.0f, 100.0f, 0.0f, false}; }
uint16_t     hal_storage_pages(void) { return 0U; }
uint16_t     hal_storage_page_words(void) { return 0U; }
hal_status_t hal_storage_read(uint16_t page, uint16_t offset, uint16_t *words, uint16_t count)
{
    (void)page, (void)offset, (void)words, (void)count;
    return HAL_UNSUPPORTED;
}
hal_status_t hal_storage_write(uint16_t page, uint16_t offset, const uint16_t *words, uint16_t count)
{
    (void)page, (void)offset, (void)words, (void)count;
    return HAL_UNSUPPORTED;
}
hal_status_t hal_storage_erase(uint16_t page)
{
    (void)page;
    return HAL_UNSUPPORTED;
}

/* ---- the drive on it ------------------------------------------------------------------------------------------------ */

static drive_params_t params;

void setUp(void)
{
    params_default(&params);
    params.offset_calibration_periods = 0U;
    params.encoder_reversed = 1U;
}
void tearDown(void) {}

static void run(double theta_m, float speed_ref, int periods)
{
    static double values[SIM_EFFECTS_MAX][SIM_EFFECT_PARAMS];
    sim_model_t   model;
    sim_model_default(&model);
    model.initial_angle_rad = theta_m;
    for (int e = 0; e < sim_effect_total; e++) {
        for (int k = 0; k < sim_effects[e]->param_count; k++) {
            values[e][k] = sim_effects[e]->param[k].off;
        }
    }
    TEST_ASSERT_NULL(sim_plant_start(&plant, &model, (const double (*)[SIM_EFFECT_PARAMS])values, 4000.0, 1U));
    armed = gates_on = speed_wanted = false;
    seq = 0U;
    for (int k = 0; k < 3; k++) {
        duty_now[k] = duty_next[k] = 0.5;
    }
    drive_init(&drive, &params);
    drive_start(&drive);
    const drive_command_t c = {.mode = DRIVE_MODE_SPEED, .speed_ref_rad_s = speed_ref};
    TEST_ASSERT_TRUE(drive_command(&drive, &c));
    for (int k = 0; k < periods; k++) {
        drive_current_isr(&drive);
        drive_watch_isr(&drive);
        if (speed_wanted) {
            speed_wanted = false;
            drive_speed_isr(&drive);
        }
        if (k % 10 == 0) {
            drive_background(&drive);
        }
        sim_plant_period(&plant, duty_now, gates_on);
        (void)memcpy(duty_now, duty_next, sizeof duty_now);
        gates_on = armed;
    }
}

static void assert_turns_at(double speed, const char *text)
{
    TEST_ASSERT_EQUAL_STRING_MESSAGE("none", faults_info((uint16_t)drive.fault)->name, text);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.01 * fabs(speed), speed, plant.x.speed_rad_s, text);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.02 * fabs(speed), speed, (double)telemetry_read(&drive, SIGNAL_speed_rad_s), text);
}

void test_reversed_encoder_is_set_right_by_its_parameter_with_both_speed_measurements(void)
{
    for (int source = 0; source < 2; source++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            params.speed_source = (uint16_t)source;
            params.align_periods = 0U; /* the angle is absolute: theta_e = -p theta */
            run(0.9, 15.708f * (float)sign, 6000);
            assert_turns_at(15.708 * sign, at("source %d, sign %d", source, sign));
        }
    }
}

void test_reversed_encoder_is_aligned_from_any_angle(void)
{
    for (int k = 0; k < 8; k++) {
        run(TWO_PI / 4.0 / 8.0 * k, 15.708f, 42000);
        assert_turns_at(15.708, at("angle %d", k));
    }
}

/* Without the parameter the motor must not turn as if nothing were wrong. */
void test_reversed_encoder_without_its_parameter_is_no_drive(void)
{
    params.encoder_reversed = 0U;
    params.align_periods = 0U;
    run(0.9, 15.708f, 6000);

    TEST_ASSERT_TRUE((drive.fault != FAULT_none) || (fabs(plant.x.speed_rad_s - 15.708) > 1.0));
}
