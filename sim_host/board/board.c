#include "sim_host/board/board.h"

#include <math.h>
#include <string.h>

#include "hal/hal_clock.h"
#include "hal/hal_link.h"
#include "sim_host/plant/whole.h"

/* Several times in a period: without a call, where the loader can give it a fixed place. */
#if defined(__linux__) && defined(__GNUC__)
static _Thread_local sim_board_t *selected __attribute__((tls_model("initial-exec")));
#else
static _Thread_local sim_board_t *selected;
#endif

void         sim_board_select(sim_board_t *board) { selected = board; }
sim_board_t *sim_board_selected(void) { return selected; }

static void zero_voltage(double duty[3])
{
    duty[0] = 0.5;
    duty[1] = 0.5;
    duty[2] = 0.5;
}

void sim_board_restart(sim_board_t *board)
{
    const sim_disturbance_t none = {0};
    const sim_isr_load_t    idle = {0};
    board->disturbance = none;
    board->load = idle;
    board->used_cyc = 0U;
    board->speed_left_cyc = 0.0;
    board->in_speed_isr = false;
    board->periods = 0;
    board->seq = 0;
    board->latched_fault = HAL_INVERTER_FINE;
    board->armed = false;
    board->gates_on = false;
    board->brake_duty = 0.0;
    board->brake_periods = 0U;
    board->speed_requested = false;
    board->stuck_theta = 0U;
    board->stuck_a[0] = board->stuck_a[1] = 0.0f;
    board->sum_a = 0.0;
    const hal_encoder_edge_t no_edge = {0};
    board->stuck_edge = no_edge;
    board->gate_periods = 0;
    board->reset_cause = HAL_RESET_POWER_UP;
    board->to_drive.head = board->to_drive.tail = 0;
    board->from_drive.head = board->from_drive.tail = 0;
    zero_voltage(board->duty);
    zero_voltage(board->duty_next);
}

void sim_board_start(sim_board_t *board)
{
    sim_board_erase(board);
    sim_board_restart(board);
}

void sim_board_reset(sim_board_t *board, hal_reset_t cause)
{
    board->reset_cause = cause;
    board->latched_fault = HAL_INVERTER_FINE;
    board->armed = false;
    board->gates_on = false;
    board->brake_periods = 0U;
    board->speed_requested = false;
    board->speed_left_cyc = 0.0;
    board->in_speed_isr = false;
    board->sum_a = 0.0;
    board->to_drive.tail = board->to_drive.head;
    board->from_drive.tail = board->from_drive.head;
    zero_voltage(board->duty);
    zero_voltage(board->duty_next);
}

void sim_board_period(sim_board_t *board)
{
    board->plant.outside.brake_duty = (board->brake_periods > 0U) ? board->brake_duty : 0.0;
    board->brake_periods -= (board->brake_periods > 0U) ? 1U : 0U;
    board->gates_on = board->gates_on && (board->disturbance.sto == 0U); /* whatever the firmware is about */
    sim_plant_period(&board->plant, board->duty, board->gates_on);
    memcpy(board->duty, board->duty_next, sizeof board->duty);
    board->gates_on = board->armed && (board->disturbance.sto == 0U);
    board->gate_periods += board->gates_on ? 1U : 0U;
    board->periods++;
    board->used_cyc = 0U;
}

bool sim_board_speed_due(sim_board_t *board)
{
    if (board->speed_requested) {
        board->speed_left_cyc -= fmax(SIM_CLOCK_HZ * board->plant.period_s - (double)board->load.current_cyc, 0.0);
    }
    return board->speed_requested && (board->speed_left_cyc <= 0.0);
}

void sim_board_speed_begin(sim_board_t *board)
{
    board->speed_requested = false;
    board->in_speed_isr = true;
}

void sim_board_speed_end(sim_board_t *board) { board->in_speed_isr = false; }

/* ---- hal_sample, hal_encoder ------------------------------------------------------------------------------------------ */

static uint32_t to_turns(double rad)
{
    const double turns = rad / 6.283185307179586;
    return (uint32_t)(uint64_t)(((turns - (double)sim_whole_below(turns)) * 4294967296.0) + 0.5); /* a whole turn wraps */
}

/* Counts that the encoder has gained, and the angle that they make. */
static int64_t slipped_counts(const sim_board_t *b) { return llrint(b->disturbance.encoder_slip_rad / b->plant.edge_pitch_rad); }
static double  slipped_rad(const sim_board_t *b)
{
    return (b->disturbance.encoder_slip_rad == 0.0) ? 0.0 : ((double)slipped_counts(b) * b->plant.edge_pitch_rad);
}

static double within_turn(double rad)
{
    const double turns = rad / 6.283185307179586;
    return (turns - (double)sim_whole_below(turns)) * 6.283185307179586;
}

static uint32_t to_cycles(double time_s)
{
    return (uint32_t)(int64_t)(time_s * SIM_CLOCK_HZ + 0.5); /* wraps, as the counter on the chip does */
}

/* The clock, and the memory of the hardware, of a board that has been looked up already. */
static inline uint32_t clock_cyc(sim_board_t *b)
{
    const uint32_t now = to_cycles(b->plant.time_s) + b->used_cyc;
    if (b->in_speed_isr) {
        b->used_cyc += b->load.speed_cyc; /* the second reading of the clock comes at the end */
    }
    return now;
}

static inline hal_inverter_fault_t latched_fault(sim_board_t *b)
{
    if (b->latched_fault == HAL_INVERTER_FINE) {
        b->latched_fault = (b->disturbance.sto != 0U) ? HAL_INVERTER_STO : b->disturbance.inverter_fault;
    }
    return b->latched_fault;
}

static float sensed(sim_board_t *b, int phase, double current_a)
{
    const sim_sensor_t *const s = &b->disturbance.sensor[phase];
    if (!s->faulty) {
        b->stuck_a[phase] = (float)current_a;
    } else if (!s->stands) {
        const double range_a = b->plant.model.current_range_a;
        b->stuck_a[phase] = (float)fmax(-range_a, fmin(range_a, s->gain * current_a + s->offset_a));
    } else {
        /* as it was */
    }
    return b->stuck_a[phase];
}

/* As hal/f28379d/sampling.c does it: a sum that is off by more than 1 A of 20, in the mean over 64 samples. */
static void judge_sum(sim_board_t *b, const hal_sample_t *s)
{
    const double sum_a = fabs((double)s->ia_a + (double)s->ib_a + (double)s->ic_a);
    b->sum_a = b->armed ? (b->sum_a + ((sum_a - b->sum_a) / 64.0)) : 0.0;
    if ((b->sum_a > 0.05 * (double)b->limits.current_a) && (b->latched_fault == HAL_INVERTER_FINE)) {
        b->latched_fault = HAL_INVERTER_CURRENT_SUM;
    }
}

static hal_status_t read_sample(sim_board_t *b, hal_sample_t *out)
{
    sim_reading_t r;
    sim_plant_read(&b->plant, &r);
    out->ia_a = b->disturbance.current_nan ? NAN : sensed(b, 0, r.ia_a);
    out->ib_a = sensed(b, 1, r.ib_a);
    out->ic_a = b->disturbance.third_sensor ? -(float)r.ia_a - (float)r.ib_a : -out->ia_a - out->ib_a;
    if (b->disturbance.third_sensor) {
        judge_sum(b, out);
    }
    out->vdc_v = (float)r.vdc_v;
    if (!b->disturbance.encoder_stuck) {
        b->stuck_theta = to_turns(r.theta_m_rad + slipped_rad(b));
    }
    out->theta_m = b->stuck_theta;
    out->at_cyc = clock_cyc(b);
    if (b->disturbance.sample_lost) {
        out->seq = b->seq;
        return HAL_STALE;
    }
    b->seq++;
    out->seq = b->seq;
    if (b->disturbance.encoder_error) {
        return HAL_SENSOR_FAULT;
    }
    return (latched_fault(b) != HAL_INVERTER_FINE) ? HAL_TRIPPED : HAL_OK;
}

hal_status_t hal_sample_read(hal_sample_t *out)
{
    sim_board_t *const b = selected;
    const hal_status_t status = read_sample(b, out);
    trace_sample(b->trace, status, out);
    return status;
}

hal_status_t hal_temperature(hal_temperature_t which, float *celsius)
{
    const sim_disturbance_t *const d = &selected->disturbance;
    const hal_status_t             status = d->celsius_lost[which] ? HAL_SENSOR_FAULT : HAL_OK;
    *celsius = (float)d->celsius[which];
    trace_temperature(selected->trace, status, *celsius);
    return status;
}

hal_status_t hal_encoder_edge(hal_encoder_edge_t *out)
{
    sim_board_t *const b = selected;
    if (!b->disturbance.encoder_stuck) {
        sim_plant_find_edge(&b->plant);
        b->stuck_edge.edge_count = (int32_t)(uint32_t)(uint64_t)(b->plant.edge_count + slipped_counts(b));
        b->stuck_edge.edge_cyc = to_cycles(b->plant.edge_time_s);
        if (b->stuck_edge.index_passes != b->plant.index_passes) { /* the count is latched as it is there */
            b->stuck_edge.index_passes = b->plant.index_passes;
            b->stuck_edge.index_rad = (float)within_turn(b->plant.index_rad + slipped_rad(b));
        }
    }
    *out = b->stuck_edge;
    const hal_status_t status = b->disturbance.encoder_error ? HAL_SENSOR_FAULT : HAL_OK;
    trace_edge(b->trace, status, out);
    return status;
}

/* ---- hal_inverter --------------------------------------------------------------------------------------------------------- */

static double cut(float duty) { return (duty > 0.0f) ? ((duty < 1.0f) ? (double)duty : 1.0) : 0.0; /* NaN gives 0 */ }

hal_status_t hal_inverter_set_duty(const hal_duty_t *duty)
{
    sim_board_t *const b = selected;
    b->duty_next[0] = cut(duty->a);
    b->duty_next[1] = cut(duty->b);
    b->duty_next[2] = cut(duty->c);
    b->used_cyc += b->load.current_cyc;
    trace_duty(b->trace, HAL_OK, duty);
    return HAL_OK;
}

hal_inverter_fault_t hal_inverter_fault(void)
{
    const hal_inverter_fault_t fault = latched_fault(selected);
    trace_status(selected->trace, TRACE_hal_inverter_fault, (uint16_t)fault);
    return fault;
}

void hal_inverter_clear_fault(void)
{
    if (selected->latched_fault < HAL_INVERTER_RAM_TEST) { /* the self tests stand until the next reset */
        selected->latched_fault = HAL_INVERTER_FINE;
    }
    trace_asked(selected->trace, TRACE_hal_inverter_clear_fault);
}

hal_status_t hal_inverter_arm(void)
{
    const hal_status_t status = (latched_fault(selected) != HAL_INVERTER_FINE) ? HAL_SENSOR_FAULT : HAL_OK;
    trace_status(selected->trace, TRACE_hal_inverter_arm, (uint16_t)status);
    if (status != HAL_OK) {
        return status;
    }
    selected->armed = true;
    if (selected->periods == 0U) { /* before the first period there is no earlier one to wait for */
        selected->gates_on = true;
    }
    return HAL_OK;
}

void hal_inverter_disarm(void)
{
    selected->armed = false;
    selected->gates_on = false;
    trace_asked(selected->trace, TRACE_hal_inverter_disarm);
}

uint16_t hal_sto(void)
{
    trace_status(selected->trace, TRACE_hal_sto, selected->disturbance.sto);
    return selected->disturbance.sto;
}

void hal_brake_duty(float duty)
{
    selected->brake_duty = cut(duty);
    selected->brake_periods = SIM_BRAKE_PERIODS;
    trace_brake(selected->trace, duty);
}

/* ---- hal_clock -------------------------------------------------------------------------------------------------------------- */

uint32_t hal_clock_cyc(void)
{
    const uint32_t now = clock_cyc(selected);
    trace_clock(selected->trace, now);
    return now;
}

uint32_t hal_clock_hz(void)
{
    trace_count(selected->trace, TRACE_hal_clock_hz, (uint32_t)SIM_CLOCK_HZ);
    return (uint32_t)SIM_CLOCK_HZ;
}
void hal_clock_request_speed_isr(void)
{
    if (!selected->speed_requested) {
        selected->speed_left_cyc = (double)selected->load.speed_cyc;
    }
    selected->speed_requested = true;
    trace_asked(selected->trace, TRACE_hal_clock_request_speed_isr);
}

hal_reset_t hal_reset_cause(void)
{
    trace_status(selected->trace, TRACE_hal_reset_cause, (uint16_t)selected->reset_cause);
    return selected->reset_cause;
}

/* ---- hal_link ----------------------------------------------------------------------------------------------------------------- */

uint16_t hal_link_read(uint16_t *octets, uint16_t limit)
{
    sim_pipe_t *const p = &selected->to_drive;
    uint16_t          n = 0;
    while ((n < limit) && (p->tail != p->head)) {
        octets[n++] = p->octet[p->tail++ % SIM_LINK_OCTETS];
    }
    trace_link_read(selected->trace, octets, n);
    return n;
}

uint16_t hal_link_write(const uint16_t *octets, uint16_t count)
{
    sim_pipe_t *const p = &selected->from_drive;
    uint16_t          n = 0;
    while ((n < count) && ((p->head - p->tail) < SIM_LINK_OCTETS)) {
        p->octet[p->head++ % SIM_LINK_OCTETS] = (uint16_t)(octets[n++] & 0xFFU);
    }
    trace_link_write(selected->trace, octets, count, n);
    return n;
}

uint32_t hal_link_lost(void) /* a full pipe takes nothing more, see es_sim_link_write */
{
    trace_count(selected->trace, TRACE_hal_link_lost, 0U);
    return 0U;
}

/* ---- hal_limits --------------------------------------------------------------------------------------------------------------- */

void hal_limits(hal_limits_t *out)
{
    *out = selected->limits;
    trace_limits(selected->trace, out);
}
