#include "tests/hal/support/virtual_chip.h"

#include <math.h>
#include <string.h>

#include "hal/f28379d/board.h"

#define PERIOD_CYC 20000U

sim_plant_t plant;
double      amplifier_offset_v[3];
double      amplifier_gain[3];
double      short_circuit_a;
bool        encoder_reversed;
uint32_t    periods_with_gates_on;
uint32_t    longest_hunger;

static uint64_t zero_cycles; /* of the last PWM zero */
static double   zero_time_s; /* of the plant, when the PWM counters started */
static uint64_t start_cycles;
static int64_t  index_turn;
static uint32_t served, hunger;

void world_begin(double angle_rad)
{
    static const double nothing[SIM_EFFECTS_MAX][SIM_EFFECT_PARAMS];
    static double       off[SIM_EFFECTS_MAX][SIM_EFFECT_PARAMS];
    (void)memcpy(off, nothing, sizeof off);
    for (int e = 0; e < sim_effect_total; e++) {
        for (int k = 0; k < sim_effects[e]->param_count; k++) {
            off[e][k] = sim_effects[e]->param[k].off;
        }
    }
    sim_model_t model;
    sim_model_default(&model);
    model.encoder_absolute = 0.0; /* as on the bench: counts from 0 at power-on */
    model.initial_angle_rad = angle_rad;
    TEST_ASSERT_NULL(sim_plant_start(&plant, &model, (const double (*)[SIM_EFFECT_PARAMS])off, (double)BOARD_ENCODER_COUNTS, 1U));
    fake_power_on();
    for (int k = 0; k < 3; k++) {
        amplifier_offset_v[k] = 0.0;
        amplifier_gain[k] = 1.0;
    }
    short_circuit_a = 0.0;
    encoder_reversed = false;
    periods_with_gates_on = 0U;
    longest_hunger = 0U;
    start_cycles = 0U;
    index_turn = plant.index_turn;
    served = 0U;
    hunger = 0U;
}

static void analog_pins(void)
{
    double i[3];
    sim_plant_phase_currents(&plant, i);
    i[0] += short_circuit_a;
    for (int k = 0; k < 3; k++) {
        chip.cmpss[k].volts = 1.65 + amplifier_offset_v[k] + (0.07 * amplifier_gain[k] * i[k]);
    }
    chip.dc_link_pin_v = plant.outside.dc_link_v / 13.42;
}

static uint32_t wrapped(int64_t count)
{
    const int64_t turn = (int64_t)BOARD_ENCODER_COUNTS;
    return (uint32_t)(((count % turn) + turn) % turn);
}

static void encoder_pins(void)
{
    sim_plant_find_edge(&plant);
    const bool upwards = plant.edge_count == plant.edge_cell; /* the last edge leads to where it stands now */
    chip.qep_position = wrapped(encoder_reversed ? (-plant.edge_cell - 1) : plant.edge_cell);
    chip.qep_direction = (upwards != encoder_reversed) ? 1 : -1;
    chip.qep_edge_cycles = start_cycles + (uint64_t)((plant.edge_time_s - zero_time_s) * (double)BOARD_SYSCLK_HZ + 0.5);
    if (plant.index_turn != index_turn) {
        index_turn = plant.index_turn;
        chip.qep_index = wrapped((int64_t)(plant.index_rad / plant.edge_pitch_rad + 0.5));
        chip.qep_flags = (uint16_t)(chip.qep_flags | EQEP_INT_INDEX_EVNT_LATCH);
    }
}

static void feed_watch(void)
{
    hunger = (chip.watchdog_served != served) ? 0U : (hunger + 1U);
    served = chip.watchdog_served;
    longest_hunger = (hunger > longest_hunger) ? hunger : longest_hunger;
}

void world_period(void)
{
    if (start_cycles == 0U) {
        start_cycles = chip.cycles;
        zero_cycles = chip.cycles;
        zero_time_s = plant.time_s;
    }
    TEST_ASSERT_TRUE_MESSAGE(chip.cycles <= zero_cycles + PERIOD_CYC, "the program took longer than a period");
    chip.cycles = zero_cycles;
    analog_pins();
    encoder_pins();
    fake_pwm_zero(); /* interrupts run here */

    double duty[3];
    bool   on = true;
    for (int k = 0; k < 3; k++) {
        duty[k] = fake_duty(k);
        on = on && fake_gate_follows(k);
        TEST_ASSERT_TRUE_MESSAGE(fake_gate_follows(k) || fake_gate_is_low(k), "a gate floats");
    }
    periods_with_gates_on += on ? 1U : 0U;
    sim_plant_period(&plant, duty, on);
    zero_cycles += PERIOD_CYC;
    feed_watch();
}

void world_make_up_time(void) { chip.cycles = (chip.cycles < zero_cycles) ? chip.cycles : zero_cycles; }

void world_run(int periods)
{
    for (int k = 0; k < periods; k++) {
        world_period();
        main_pass();
    }
}
