/**
 * @file  tests/scenario/support/shaft.h
 * @brief A drive on the virtual board with hands on its shaft: started, cleared, braked and loaded at any moment.
 */
#ifndef TESTS_SCENARIO_SUPPORT_SHAFT_H
#define TESTS_SCENARIO_SUPPORT_SHAFT_H

#include "firmware/app/drive.h"
#include "sim_host/board/board.h"

#define SHAFT_LOCKED_NM 1.0e5

typedef struct {
    sim_board_t    board;
    drive_t        drive;
    sim_model_t    model;
    drive_params_t params;
    double         effect[SIM_EFFECTS_MAX][SIM_EFFECT_PARAMS];
    double         backwards_rad_s, onwards_rad_s; /* largest speeds since shaft_watch, in the truth */
} shaft_t;

extern shaft_t shaft;

/** The default machine and parameters; no effect acts. Then change what is wanted and call shaft_power_up. */
void shaft_new(void);
void shaft_effect(const char *effect, const char *param, double value);
void shaft_power_up(void);
/** PWM periods, with a pass of the main loop every ten. */
void shaft_run(int64_t periods);
/** Until the drive is in RUN or in FAULT, at most so many periods. */
void shaft_settle(int64_t periods);
void shaft_speed(double rad_s);
void shaft_watch(void);
/** What the drive believes of the electrical angle less the truth, degrees, for an absolute encoder. */
double      shaft_zero_error_deg(void);
double      shaft_rad_s(void);
const char *shaft_fault(void);

#endif
