/**
 * @file  sim_host/board/board.h
 * @brief The virtual board: the HAL contract on the simulated machine.
 *
 * HAL functions have no handle, as on the chip; sim_board_select says which board they mean, per thread. The clock counts
 * PWM periods of CPU cycles at 200 MHz. It stands still while an interrupt runs, unless the board is given how long one
 * takes (sim_isr_load_t); then the current interrupt takes it when it sets its duties, the speed interrupt after it first
 * reads the clock.
 */
#ifndef SIM_HOST_BOARD_BOARD_H
#define SIM_HOST_BOARD_BOARD_H

#include "hal/hal_encoder.h"
#include "hal/hal_inverter.h"
#include "hal/hal_limits.h"
#include "hal/hal_reset.h"
#include "hal/hal_sample.h"
#include "sim_host/plant/plant.h"
#include "sim_host/trace/trace.h"

#define SIM_CLOCK_HZ 200000000.0
#define SIM_LINK_OCTETS 4096
#define SIM_BRAKE_PERIODS 200 /* 20 ms without a word, then the brake resistor is off */
#define SIM_STORAGE_PAGES 3   /* sectors of 8 k words, as on the chip */
#define SIM_STORAGE_WORDS 8192

/** What the sensor of a phase current makes of the current. */
typedef struct {
    bool   faulty; /**< Else it reads what there is. */
    bool   stands; /**< At the last value. */
    double gain, offset_a;
} sim_sensor_t;

/** Disturbances of the electronics, for tests and scenarios. */
typedef struct {
    bool                 sample_lost;      /**< The converter gives nothing new. */
    bool                 current_nan;      /**< Phase a reads as not-a-number. */
    sim_sensor_t         sensor[2];        /**< Of phases a and b. */
    bool                 third_sensor;     /**< Phase c has one, too; else its current is the negative sum of the others. */
    bool                 encoder_stuck;    /**< The angle no longer changes, and no edge comes. */
    double               encoder_slip_rad; /**< Angle that the encoder shows too much, in whole counts. */
    bool                 encoder_error;    /**< Phase error of the encoder interface. */
    double               celsius[HAL_TEMPERATURES];      /**< Of motor and bridge. */
    bool                 celsius_lost[HAL_TEMPERATURES]; /**< The sensor is open or shorted. */
    uint16_t             sto;                            /**< Channels that ask for safe torque off, bits. */
    hal_inverter_fault_t inverter_fault;                 /**< The cause, as long as it stands. */
} sim_disturbance_t;

/** CPU cycles that each interrupt takes; a speed interrupt that does not fit between current interrupts ends later. */
typedef struct {
    uint32_t current_cyc, speed_cyc;
} sim_isr_load_t;

typedef struct {
    uint16_t octet[SIM_LINK_OCTETS];
    uint32_t head, tail; /**< Free-running; head - tail octets wait. */
} sim_pipe_t;

typedef struct {
    sim_plant_t          plant;
    hal_limits_t         limits; /**< Set before sim_board_start, which leaves them alone. */
    sim_disturbance_t    disturbance;
    sim_isr_load_t       load;
    uint32_t             used_cyc;       /**< By the interrupts of this period so far. */
    double               speed_left_cyc; /**< Work of the requested speed interrupt that is left. */
    bool                 in_speed_isr;
    uint64_t             periods;
    uint32_t             seq;
    hal_inverter_fault_t latched_fault; /**< What the hardware remembers of it. */
    bool                 armed;         /**< Gates follow the duties in the next period. */
    bool                 gates_on;      /**< They do in this one. */
    double               duty[3];       /**< Duties of this period. */
    double               duty_next[3];  /**< Duties of the next period. */
    double               brake_duty;    /**< Of the switch of the brake resistor, */
    uint32_t             brake_periods; /**< for so many periods more. */
    bool                 speed_requested;
    uint32_t             stuck_theta;
    float                stuck_a[2]; /**< Last readings of the current sensors. */
    double               sum_a; /**< Mean of what three current sensors do not add up to, as the port for the F28379D has it. */
    hal_encoder_edge_t   stuck_edge;
    uint64_t             gate_periods; /**< Periods with the gates on, since the start. */
    hal_reset_t          reset_cause;  /**< Power-up, unless changed after sim_board_start. */
    sim_pipe_t           to_drive, from_drive;
    uint16_t             storage[SIM_STORAGE_PAGES][SIM_STORAGE_WORDS];
    trace_t *trace; /**< Takes down what the functions of the contract give; NULL: nobody does. The start leaves it alone. */
} sim_board_t;

/** Everything but the plant and the limits at rest; storage erased. */
void sim_board_start(sim_board_t *board);
/** Everything but the plant, the limits and the storage at rest. */
void sim_board_restart(sim_board_t *board);
/** The processor starts again: bridge off, hardware faults forgotten, octets lost. The machine goes on; memory and storage stay. */
void sim_board_reset(sim_board_t *board, hal_reset_t cause);
/** Its storage to all ones. */
void sim_board_erase(sim_board_t *board);
/** The board that HAL functions on this thread mean. */
void         sim_board_select(sim_board_t *board);
sim_board_t *sim_board_selected(void);
/** Whether a speed interrupt was requested and comes to its end in this period: then it must be run, between begin and end. */
bool sim_board_speed_due(sim_board_t *board);
void sim_board_speed_begin(sim_board_t *board);
void sim_board_speed_end(sim_board_t *board);
/** One PWM period after the interrupts of its start have run. */
void sim_board_period(sim_board_t *board);

#endif
