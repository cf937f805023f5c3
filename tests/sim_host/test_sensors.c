/* sim_host/plant/plant.c: what the converter, the encoder and its edge timer see. */
#include "tests/sim_host/support/machine.h"

#define COUNT (TWO_PI / 4000.0)

static sim_reading_t reading;

void setUp(void)
{
    machine_defaults();
    model.viscous_nms = 0.0;
}
void tearDown(void) {}

static double angle_at(double theta_m)
{
    plant.x.theta_m_rad = theta_m;
    sim_plant_read(&plant, &reading);
    return reading.theta_m_rad;
}

/* ---- encoder angle -------------------------------------------------------------------------------------------------- */

void test_sensors_encoder_shows_the_count_below(void)
{
    machine_start();
    const double counts[] = {0.0, 0.01, 0.5, 0.99, 1.01, 17.3, 1999.99, 2000.01, 3999.5};
    for (size_t k = 0; k < COUNT_OF(counts); k++) {
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-12, floor(counts[k]) * COUNT, angle_at(counts[k] * COUNT),
                                          at("%g counts", counts[k]));
    }
}

void test_sensors_encoder_wraps_into_one_turn_forward_and_backward(void)
{
    machine_start();
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 17.0 * COUNT, angle_at(3.0 * TWO_PI + 17.3 * COUNT));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 3999.0 * COUNT, angle_at(-0.3 * COUNT)); /* below zero: the last count of a turn */
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 3982.0 * COUNT, angle_at(-17.3 * COUNT));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 3982.0 * COUNT, angle_at(-5.0 * TWO_PI - 17.3 * COUNT));
}

void test_sensors_angle_is_never_negative_and_never_a_whole_turn(void)
{
    machine_start();
    for (int k = -20000; k <= 20000; k++) {
        const double a = angle_at((k + 0.5) * COUNT);
        TEST_ASSERT_TRUE_MESSAGE((a >= 0.0) && (a < TWO_PI - 0.5 * COUNT), at("count %d: %.17g", k, a));
        const double turns = floor(k / 4000.0);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, (k - 4000.0 * turns) * COUNT, a, at("count %d", k));
    }
}

void test_sensors_ideal_encoder_shows_the_angle_itself(void)
{
    model.counts_per_rev = 0.0;
    machine_start();
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.2345678, angle_at(1.2345678));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, TWO_PI - 1.0, angle_at(-1.0));
}

/* ---- edge timer ----------------------------------------------------------------------------------------------------- */

static void turn_at(double speed, double angle)
{
    model.inertia_kgm2 = 1e3;
    model.psi_wb = 0.0;
    model.initial_speed_rad_s = speed;
    model.initial_angle_rad = angle;
    machine_start();
}

/* forward the newest edge is the one below the angle, passed (angle - edge) / w ago; backward the one above */
static void assert_edges(double w, double angle)
{
    turn_at(w, angle);
    for (int k = 1; k <= 300; k++) {
        machine_voltage(0.0, 0.0, 1);
        const double now = angle + w * 1e-4 * k;
        const double edge = (w > 0.0) ? floor(now / COUNT) : floor(now / COUNT) + 1.0;
        const bool   passed = (w > 0.0) ? (edge > floor(angle / COUNT)) : (edge <= floor(angle / COUNT));
        if (passed) {
            TEST_ASSERT_EQUAL_INT64((int64_t)edge, plant.edge_count);
            /* linear between the ends of a step, which at constant speed is exact */
            TEST_ASSERT_DOUBLE_WITHIN(1e-10, (edge * COUNT - angle) / w, plant.edge_time_s);
        }
    }
}

void test_sensors_edges_are_timed_forward(void)
{
    assert_edges(15.7, 0.3 * COUNT);    /* an edge per period */
    assert_edges(300.0, 100.3 * COUNT); /* nearly twenty */
    assert_edges(0.7, 0.3 * COUNT);     /* one in twenty */
}

void test_sensors_edges_are_timed_backward_and_through_zero(void)
{
    assert_edges(-15.7, 0.3 * COUNT);
    assert_edges(-300.0, 100.3 * COUNT);
    assert_edges(-0.7, 0.3 * COUNT);
}

void test_sensors_edges_of_negative_angles_are_timed_forward(void) { assert_edges(40.0, -1.5); }

/* Passed upwards and, after a reversal, downwards: the same edge, at two times. */
void test_sensors_edge_has_one_position_whichever_way_it_is_passed(void)
{
    model.psi_wb = 0.0;
    model.initial_speed_rad_s = 10.0;
    model.initial_angle_rad = 6.5 * COUNT;
    machine_start();
    machine_voltage(0.0, 0.0, 1); /* 1 mrad: 0.64 counts */
    TEST_ASSERT_EQUAL_INT64(7, plant.edge_count);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.5 * COUNT / 10.0, plant.edge_time_s);

    plant.outside.load_torque_nm = 2.0 * 10.0 / 1e-4 * 7.06e-5; /* -20 rad/s within the period: back where it was */
    machine_voltage(0.0, 0.0, 1);
    plant.outside.load_torque_nm = 0.0;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -10.0, plant.x.speed_rad_s);
    machine_voltage(0.0, 0.0, 1);

    TEST_ASSERT_EQUAL_INT64(7, plant.edge_count);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2.0e-4 + (plant.x.theta_m_rad + 1e-3 - 7.0 * COUNT) / 10.0, plant.edge_time_s);
}

#define TO_AND_FRO 2000

static void note_edges(double speed, int every, int64_t *count, double *time_s)
{
    double duty[3];
    turn_at(speed, 3.7 * COUNT);
    machine_duties(0.0, 0.0, duty);
    for (int k = 0; k < TO_AND_FRO; k++) {
        plant.outside.load_torque_nm = 2e6 * cos(0.006 * k); /* through zero and back, twice */
        sim_plant_period(&plant, duty, true);
        if (((k + 1) % every) == 0) {
            sim_plant_find_edge(&plant);
            count[k] = plant.edge_count;
            time_s[k] = plant.edge_time_s;
        }
    }
}

/* A drive asks once in many steps; the edge is the one that asking after every step finds, through reversals, too. */
void test_sensors_edge_is_the_same_however_seldom_it_is_asked_for(void)
{
    static const int    EVERY[] = {7, 45, 400};
    static const double SPEED[] = {0.3, 7.0, 60.0, -60.0};
    static int64_t      count[TO_AND_FRO], seldom_count[TO_AND_FRO];
    static double       time_s[TO_AND_FRO], seldom_time_s[TO_AND_FRO];
    for (size_t s = 0; s < COUNT_OF(SPEED); s++) {
        note_edges(SPEED[s], 1, count, time_s);
        for (size_t e = 0; e < COUNT_OF(EVERY); e++) {
            note_edges(SPEED[s], EVERY[e], seldom_count, seldom_time_s);
            for (int k = EVERY[e] - 1; k < TO_AND_FRO; k += EVERY[e]) {
                TEST_ASSERT_EQUAL_INT64(count[k], seldom_count[k]);
                TEST_ASSERT_EQUAL_DOUBLE(time_s[k], seldom_time_s[k]);
            }
        }
    }
}

void test_sensors_without_an_edge_its_time_stands(void)
{
    turn_at(0.1, 0.5 * COUNT);
    machine_voltage(0.0, 0.0, 79); /* the edge is 0.785 mrad away: 78.5 periods */
    const double first = plant.edge_time_s;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.5 * COUNT / 0.1, first);
    machine_voltage(0.0, 0.0, 100);

    TEST_ASSERT_EQUAL_DOUBLE(first, plant.edge_time_s);
    TEST_ASSERT_EQUAL_INT64(1, plant.edge_count);
}

/* ---- index of an incremental encoder ---------------------------------------------------------------------------- */

static void incremental(double speed, double angle)
{
    model.encoder_absolute = 0.0;
    turn_at(speed, angle);
}

void test_sensors_incremental_encoder_counts_from_zero_at_the_start(void)
{
    incremental(0.0, 2.3);
    sim_plant_read(&plant, &reading);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, reading.theta_m_rad);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 100.0 * COUNT, angle_at(2.3 + 100.5 * COUNT));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 3999.0 * COUNT, angle_at(2.3 - 0.5 * COUNT));
    TEST_ASSERT_EQUAL_UINT16(0U, plant.index_passes);
}

/* the pulse is at the true angle 0; the encoder, which began at 0 where the rotor stood, reads 2 pi less that angle */
void test_sensors_index_is_seen_where_the_true_angle_is_zero_in_both_directions(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        const double way = (sign > 0) ? TWO_PI - 2.3 : 2.3;
        incremental(100.0 * sign, 2.3);
        machine_voltage(0.0, 0.0, (int)(way / 0.01) - 1);
        TEST_ASSERT_EQUAL_UINT16(0U, plant.index_passes);
        machine_voltage(0.0, 0.0, 3);
        TEST_ASSERT_EQUAL_UINT16(1U, plant.index_passes);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, TWO_PI - 2.3, plant.index_rad);
    }
}

void test_sensors_absolute_encoder_needs_no_index(void)
{
    turn_at(0.0, 2.3);
    TEST_ASSERT_EQUAL_UINT16(1U, plant.index_passes);
}

/* ---- current sensors ------------------------------------------------------------------------------------------------ */

/* Locked at angle 0 with id = alpha, iq = beta. */
static void currents(double a, double b)
{
    plant.x.id_a = a;
    plant.x.iq_a = (a + 2.0 * b) / SQRT3;
    sim_plant_read(&plant, &reading);
}

void test_sensors_currents_arrive_as_they_are_without_errors(void)
{
    machine_start();
    currents(1.2345678, -0.987654);

    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.2345678, reading.ia_a);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.987654, reading.ib_a);
}

void test_sensors_converter_rounds_to_the_nearest_step(void)
{
    model.current_lsb_a = 0.01;
    machine_start();
    currents(1.2349, -0.9876);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.23, reading.ia_a);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.99, reading.ib_a);

    currents(0.0049, -0.0051);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, reading.ia_a);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.01, reading.ib_a);
}

void test_sensors_converter_clips_at_its_range_in_both_directions(void)
{
    model.current_range_a = 5.0;
    machine_start();
    currents(6.0, -7.0);

    TEST_ASSERT_EQUAL_DOUBLE(5.0, reading.ia_a);
    TEST_ASSERT_EQUAL_DOUBLE(-5.0, reading.ib_a);
}

/* sigma of the mean 0.03 / sqrt(n) = 9.5e-5, of the standard deviation 0.03 / sqrt(2 n) = 6.7e-5: five of each */
void test_sensors_noise_has_the_mean_and_deviation_it_should_and_differs_between_the_phases(void)
{
    const int n = 100000;
    model.current_noise_a = 0.03;
    machine_start();
    double sum[2] = {0.0, 0.0};
    double square[2] = {0.0, 0.0};
    double product = 0.0;
    for (int k = 0; k < n; k++) {
        currents(1.0, -2.0);
        const double e[2] = {reading.ia_a - 1.0, reading.ib_a + 2.0};
        for (int i = 0; i < 2; i++) {
            sum[i] += e[i];
            square[i] += e[i] * e[i];
        }
        product += e[0] * e[1];
    }
    for (int i = 0; i < 2; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(4.8e-4, 0.0, sum[i] / n);
        TEST_ASSERT_DOUBLE_WITHIN(3.4e-4, 0.03, sqrt(square[i] / n));
    }
    TEST_ASSERT_DOUBLE_WITHIN(5.0 * 0.03 * 0.03 / sqrt((double)n), 0.0, product / n);
}

void test_sensors_noise_comes_before_the_rounding(void)
{
    model.current_noise_a = 0.03;
    model.current_lsb_a = 0.01;
    machine_start();
    int moved = 0;
    for (int k = 0; k < 100; k++) {
        currents(1.0, 0.0);
        const double steps = reading.ia_a / 0.01;
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, rint(steps), steps);
        moved += (fabs(reading.ia_a - 1.0) > 0.005) ? 1 : 0;
    }
    TEST_ASSERT_TRUE(moved > 50); /* a sixth of all within half a step */
}

void test_sensors_noise_is_the_same_for_the_same_seed_and_another_for_another(void)
{
    model.current_noise_a = 0.03;
    double first[3];
    for (int run = 0; run < 3; run++) {
        TEST_ASSERT_NULL(
            sim_plant_start(&plant, &model, (const double (*)[SIM_EFFECT_PARAMS])effect_values, 4000.0, (run == 2) ? 8U : 7U));
        sim_plant_read(&plant, &reading);
        first[run] = reading.ia_a;
    }
    TEST_ASSERT_EQUAL_DOUBLE(first[0], first[1]);
    TEST_ASSERT_TRUE(first[0] != first[2]);
}

/* ---- dc link -------------------------------------------------------------------------------------------------------- */

/* first order with 20 Hz: 24 - 14 (1 - exp(-2 pi 20 t)) */
void test_sensors_dc_link_is_measured_through_its_filter(void)
{
    machine_start();
    plant.outside.dc_link_v = 10.0;
    for (int k = 1; k <= 300; k++) {
        machine_voltage(0.0, 0.0, 1);
        sim_plant_read(&plant, &reading);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 10.0 + 14.0 * exp(-TWO_PI * 20.0 * 1e-4 * k), reading.vdc_v);
    }
}
