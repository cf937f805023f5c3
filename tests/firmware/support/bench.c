#include "tests/firmware/support/bench.h"

#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"

bench_t bench;
drive_t drive;

static void note(bench_call_t call)
{
    if (bench.logged < BENCH_LOG) {
        bench.log[bench.logged++] = call;
    }
}

/* Once only: the interrupt that it runs calls the same functions. */
static void preempt(void (**hook)(void))
{
    void (*const interrupt)(void) = *hook;
    *hook = NULL;
    if (interrupt != NULL) {
        interrupt();
    }
}

static hal_status_t sample_read(hal_sample_t *out, int calls)
{
    (void)calls;
    note(CALL_READ);
    bench.reads++;
    *out = bench.sample;
    out->at_cyc = bench.clock_cyc;
    bench.clock_cyc += bench.isr_cyc;
    return ((bench.sample_status == HAL_OK) && ((bench.inverter_fault != HAL_INVERTER_FINE) || (bench.sto != 0U)))
               ? HAL_TRIPPED
               : bench.sample_status;
}

static hal_status_t encoder_edge(hal_encoder_edge_t *out, int calls)
{
    (void)calls;
    note(CALL_EDGE);
    bench.edges++;
    *out = bench.edge;
    return bench.edge_status;
}

static hal_status_t set_duty(const hal_duty_t *duty, int calls)
{
    (void)calls;
    note(CALL_DUTY);
    bench.duties++;
    bench.duty = *duty;
    return HAL_OK;
}

static hal_status_t arm(int calls)
{
    (void)calls;
    preempt(&bench.in_arm);
    note(CALL_ARM);
    bench.arms++;
    if (bench.arm_status == HAL_OK) {
        bench.armed = true;
    }
    return bench.arm_status;
}

static void disarm(int calls)
{
    (void)calls;
    preempt(&bench.in_disarm);
    note(CALL_DISARM);
    bench.disarms++;
    bench.armed = false;
}

static hal_inverter_fault_t inverter_fault(int calls)
{
    (void)calls;
    return (bench.sto != 0U) ? HAL_INVERTER_STO : bench.inverter_fault;
}

static void clear_fault(int calls)
{
    (void)calls;
    note(CALL_CLEAR);
    bench.clears++;
    preempt(&bench.in_clear);
}

static uint32_t clock_cyc(int calls)
{
    (void)calls;
    const uint32_t now = bench.clock_cyc;
    bench.clock_cyc += bench.isr_cyc;
    return now;
}

static uint32_t clock_hz(int calls)
{
    (void)calls;
    preempt(&bench.in_clock_hz);
    return BENCH_CPU_HZ;
}

static void request_speed_isr(int calls)
{
    (void)calls;
    note(CALL_REQUEST_SPEED);
    bench.requests++;
    bench.speed_requested = true;
}

static hal_status_t temperature(hal_temperature_t which, float *celsius, int calls)
{
    (void)calls;
    *celsius = bench.celsius[which];
    return bench.celsius_status[which];
}

static void brake_duty(float duty, int calls)
{
    (void)calls;
    bench.brakes++;
    bench.brake_duty = duty;
}

static uint16_t sto(int calls)
{
    (void)calls;
    return bench.sto;
}

static void limits(hal_limits_t *out, int calls)
{
    (void)calls;
    *out = bench.limits;
}

void bench_start(void)
{
    const bench_t board = {.sample = {0.0f, 0.0f, 0.0f, (float)BENCH_VDC, 0U, 0U, 0U},
                           .seq_by_itself = true,
                           .celsius = {25.0f, 25.0f},
                           .limits = {1000.0f, 1000.0f, 20000.0f, 100.0f, 0.0f, true}};
    bench = board;
    (void)memset(&drive, 0, sizeof drive);
    hal_sample_read_Stub(sample_read);
    hal_temperature_Stub(temperature);
    hal_encoder_edge_Stub(encoder_edge);
    hal_inverter_set_duty_Stub(set_duty);
    hal_brake_duty_Stub(brake_duty);
    hal_sto_Stub(sto);
    hal_limits_Stub(limits);
    hal_inverter_arm_Stub(arm);
    hal_inverter_disarm_Stub(disarm);
    hal_inverter_fault_Stub(inverter_fault);
    hal_inverter_clear_fault_Stub(clear_fault);
    hal_clock_cyc_Stub(clock_cyc);
    hal_clock_hz_Stub(clock_hz);
    hal_clock_request_speed_isr_Stub(request_speed_isr);
}

void bench_forget_calls(void) { bench.logged = 0U; }

drive_params_t bench_params(void)
{
    drive_params_t p;
    params_default(&p);
    p.offset_calibration_periods = 0U;
    p.align_periods = 0U;
    p.current_ki_v_per_as = 0.0f;
    p.encoder_jump_rad = 3.2f; /* the shaft is where a test puts it, whatever the torque... */
    p.speed_deviation_s = 0.0f;
    p.stall_s = 0.0f;
    p.zero_check = 0U;           /* ...and has no back-EMF, */
    p.plausibility_share = 0.0f; /* no windings either */
    p.restart_limit = 0U;        /* a test trips and starts as often as it wants */
    return p;
}

void bench_run_with(const drive_params_t *params)
{
    drive_init(&drive, params);
    drive_start(&drive);
    for (int pass = 0; (pass < 3) && (drive.state != DRIVE_RUN); pass++) {
        drive_background(&drive);
    }
    TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_RUN, drive.state, "the bench could not start the drive");
    bench_forget_calls();
}

void bench_into(drive_state_t state)
{
    drive_params_t p = bench_params();
    p.offset_calibration_periods = (state == DRIVE_OFFSET_CALIBRATION) ? 60000U : 0U;
    p.align_periods = (state == DRIVE_ALIGN) ? 60000U : 0U; /* 3 quarters of a pass are 0.5 s */
    drive_init(&drive, &p);
    if ((state == DRIVE_RUN) || (state == DRIVE_ALIGN)) {
        drive_start(&drive);
    }
    for (int pass = 0; (pass < 3) && (state != DRIVE_INIT); pass++) {
        drive_background(&drive);
    }
    if (state == DRIVE_ALIGN) { /* the shaft rests: on to the first vector */
        bench_live(1100U);
        TEST_ASSERT_EQUAL_INT(DRIVE_ALIGN_PULL, drive.align.phase);
    }
    if (state == DRIVE_FAULT) {
        bench.sample.vdc_v = 100.0f;
        bench_period();
        bench.sample.vdc_v = (float)BENCH_VDC;
    }
    TEST_ASSERT_EQUAL_INT_MESSAGE(state, drive.state, "the bench could not reach the state");
    bench_forget_calls();
}

void bench_rotor(double pole_pairs, double theta_e)
{
    bench.rotor_pairs = pole_pairs;
    bench.rotor_e = theta_e;
    bench_angle(theta_e / pole_pairs);
}

void bench_align(void)
{
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    drive_start(&drive);
    drive_background(&drive);
    TEST_ASSERT_EQUAL_INT(DRIVE_ALIGN, drive.state);
    for (uint32_t k = 0U; (k < 100000U) && (drive.state != DRIVE_RUN) && (drive.state != DRIVE_FAULT); k += 10U) {
        bench_live(10U);
    }
}

static void turn_rotor(void)
{
    double alpha, beta;
    bench_voltage(&alpha, &beta);
    if ((bench.rotor_pairs != 0.0) && bench.armed && (hypot(alpha, beta) > 1.0e-3)) {
        const double load = bench.rotor_load * 2.4 / hypot(alpha, beta);
        bench.rotor_e += 0.05 * remainder(atan2(beta, alpha) - load - bench.rotor_e, TWO_PI);
        bench_angle(bench.rotor_e / bench.rotor_pairs);
    }
}

void bench_period(void)
{
    turn_rotor();
    if (bench.seq_by_itself) {
        bench.sample.seq++;
    }
    drive_current_isr(&drive);
    drive_watch_isr(&drive);
    if (bench.speed_requested) {
        bench.speed_requested = false;
        drive_speed_isr(&drive);
    }
}

void bench_periods(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        bench_period();
    }
}

void bench_live(uint32_t periods)
{
    for (uint32_t k = 0U; k < periods; k++) {
        bench_period();
        if ((k % 10U) == 9U) {
            drive_background(&drive);
        }
    }
}

void bench_command(drive_mode_t mode, double speed_ref_rad_s, double id_ref_a, double iq_ref_a)
{
    const drive_command_t c = {
        .mode = mode, .speed_ref_rad_s = (float)speed_ref_rad_s, .id_ref_a = (float)id_ref_a, .iq_ref_a = (float)iq_ref_a};
    TEST_ASSERT_TRUE(drive_command(&drive, &c));
}

void bench_currents(double d_a, double q_a, double theta_e)
{
    for (int k = 0; k < 3; k++) {
        const double axis = theta_e - (TWO_PI / 3.0) * k; /* i_k = d cos - q sin */
        const float  i = (float)(d_a * cos(axis) - q_a * sin(axis));
        *((k == 0) ? &bench.sample.ia_a : ((k == 1) ? &bench.sample.ib_a : &bench.sample.ic_a)) = i;
    }
}

void bench_angle(double theta_m)
{
    const double turns = theta_m / TWO_PI;
    bench.sample.theta_m = (uint32_t)(uint64_t)llround((turns - floor(turns)) * 4294967296.0);
}

void bench_voltage(double *alpha_v, double *beta_v)
{
    const double v = (double)bench.sample.vdc_v;
    const double a = (double)bench.duty.a;
    const double b = (double)bench.duty.b;
    const double c = (double)bench.duty.c;
    *alpha_v = v * (2.0 * a - b - c) / 3.0;
    *beta_v = v * (b - c) / SQRT3;
}

void bench_spin(double speed_rad_s, double end)
{
    /* Up to speed in 0.2 s, gently enough for the check of the encoder, then 0.1 s, 38 time constants of the filter's
     * default double pole at 377 rad/s. */
    const double ramp = 2000.0;
    const double hold = 1000.0;
    for (double k = 1.0; k <= ramp + hold; k += 1.0) {
        const double way = (k < ramp) ? 0.5 * k * k / ramp : k - 0.5 * ramp;
        bench_angle(end - speed_rad_s * 1e-4 * (0.5 * ramp + hold - way));
        bench_period();
    }
}

int bench_first(bench_call_t call)
{
    for (uint16_t i = 0U; i < bench.logged; i++) {
        if (bench.log[i] == call) {
            return (int)i;
        }
    }
    return -1;
}
