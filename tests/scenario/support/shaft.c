#include "tests/scenario/support/shaft.h"

#include <math.h>
#include <string.h>

shaft_t shaft;

void shaft_new(void)
{
    (void)memset(&shaft, 0, sizeof shaft);
    sim_model_default(&shaft.model);
    params_default(&shaft.params);
    shaft.params.offset_calibration_periods = 1000U;
    for (int e = 0; e < sim_effect_total; e++) {
        for (int k = 0; k < sim_effects[e]->param_count; k++) {
            shaft.effect[e][k] = sim_effects[e]->param[k].off;
        }
    }
}

void shaft_effect(const char *effect, const char *param, double value)
{
    for (int e = 0; e < sim_effect_total; e++) {
        for (int k = 0; (strcmp(sim_effects[e]->name, effect) == 0) && (k < sim_effects[e]->param_count); k++) {
            if (strcmp(sim_effects[e]->param[k].name, param) == 0) {
                shaft.effect[e][k] = value;
            }
        }
    }
}

void shaft_power_up(void)
{
    sim_board_select(&shaft.board);
    (void)sim_plant_start(&shaft.board.plant, &shaft.model, (const double (*)[SIM_EFFECT_PARAMS])shaft.effect,
                          (shaft.model.counts_per_rev > 0.0) ? shaft.model.counts_per_rev : 4000.0, 1U);
    shaft.board.limits =
        (hal_limits_t){1000.0f, 1000.0f, 20000.0f, 100.0f, 0.0f, false}; /* the drive's own limits are the tighter ones */
    sim_board_start(&shaft.board);
    shaft.board.plant.outside.dc_link_v = shaft.model.dc_link_v;
    drive_init(&shaft.drive, &shaft.params);
    shaft_watch();
}

void shaft_watch(void) { shaft.backwards_rad_s = shaft.onwards_rad_s = 0.0; }

void shaft_run(int64_t periods)
{
    sim_board_select(&shaft.board);
    for (int64_t k = 0; k < periods; k++) {
        drive_current_isr(&shaft.drive);
        drive_watch_isr(&shaft.drive);
        if (sim_board_speed_due(&shaft.board)) {
            sim_board_speed_begin(&shaft.board);
            drive_speed_isr(&shaft.drive);
            sim_board_speed_end(&shaft.board);
        }
        if ((shaft.board.periods % 10U) == 0U) {
            drive_background(&shaft.drive);
        }
        sim_board_period(&shaft.board);
        const double w = shaft.board.plant.x.speed_rad_s;
        shaft.backwards_rad_s = fmin(shaft.backwards_rad_s, w);
        shaft.onwards_rad_s = fmax(shaft.onwards_rad_s, w);
    }
}

void shaft_settle(int64_t periods)
{
    for (int64_t k = 0; (k < periods) && (shaft.drive.state != DRIVE_RUN) && (shaft.drive.state != DRIVE_FAULT); k += 10) {
        shaft_run(10);
    }
}

void shaft_speed(double rad_s)
{
    const drive_command_t c = {.mode = DRIVE_MODE_SPEED, .speed_ref_rad_s = (float)rad_s};
    (void)drive_command(&shaft.drive, &c);
}

double      shaft_zero_error_deg(void) { return (double)(int32_t)shaft.drive.zero.e / 4294967296.0 * 360.0; }
double      shaft_rad_s(void) { return shaft.board.plant.x.speed_rad_s; }
const char *shaft_fault(void) { return faults_info((uint16_t)shaft.drive.fault)->name; }
