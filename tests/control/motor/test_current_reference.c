/* control/motor/current_reference.c: against the equations of the machine in double precision, searched by brute force. */
#include "tests/support/numeric.h"

#include "control/motor/current_reference.h"

/* A machine in per-unit values that both numerics hold, and its steady state. */
typedef struct {
    double psi, ld, lq, r; /* volts per speed, per speed and current, per current */
} machine_t;

static ctl_reference_plan_t  plan;
static ctl_reference_state_t state;

void setUp(void) {}
void tearDown(void) {}

static ctl_reference_params_t params_of(const machine_t *m, double i_max)
{
    const ctl_reference_params_t p = {.saliency = num_of((m->ld - m->lq) / m->psi),
                                      .d_full = num_of(m->psi / m->ld),
                                      .q_full = num_of(m->psi / m->lq),
                                      .emf = num_of(m->psi),
                                      .ohm = num_of(m->r),
                                      .i_max = num_of(i_max),
                                      .iq_max = num_of(i_max),
                                      .id_max = num_of(i_max),
                                      .share = num_of(0.95),
                                      .smooth = num_of(0.3),
                                      .fall = num_of(0.17),
                                      .rise = num_of(0.0625),
                                      .mtpa = true,
                                      .weakens = true};
    return p;
}

static void begin(const ctl_reference_params_t *p)
{
    memset(&state, 0, sizeof state);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_reference_plan(&plan, p).status);
    ctl_reference_reset(&plan, &state);
}

static double volts(const machine_t *m, double w, double id, double iq, double *vd, double *vq)
{
    *vd = (m->r * id) - (w * m->lq * iq);
    *vq = (m->r * iq) + (w * (m->psi + (m->ld * id)));
    return hypot(*vd, *vq);
}

/* Torque current of the machine. */
static double torque_of(const machine_t *m, double id, double iq) { return iq * (1.0 + (((m->ld - m->lq) / m->psi) * id)); }

/* One sample with a current loop that does what it is asked for: the torque current that comes out. */
static double sample(const machine_t *m, double w, double v_limit, double asked, double *v)
{
    static double id, iq;
    double        vd, vq;
    const double  room = value_of(state.room);
    const double  torque = fmax(fmin(asked, room), -room);
    (void)volts(m, w, id, iq, &vd, &vq);
    const double             size = fmax(hypot(vd, vq), 1e-9);
    const double             cut = fmin(1.0, v_limit / size); /* as the current loop shortens it */
    const ctl_reference_in_t in = {num_of(torque), num_of(w), num_of(v_limit), {num_of(vd * cut), num_of(vq * cut)}};
    ctl_reference_step(&plan, &state, &in);
    id = value_of(state.id);
    const double iq_max = value_of(state.iq_max);
    iq = fmax(fmin(torque * value_of(state.q_share), iq_max), -iq_max);
    *v = volts(m, w, id, iq, &vd, &vq);
    return torque_of(m, id, iq);
}

/* Largest torque current of the machine on the circle within the voltage, on a grid; 0: none. */
static double best_torque(const machine_t *m, double w, double v_max, double i_max, double id_least)
{
    double best = 0.0;
    for (int a = 0; a <= 200; a++) {
        const double id = id_least * a / 200.0;
        double       low = 0.0, high = sqrt(fmax((i_max * i_max) - (id * id), 0.0)), vd, vq;
        if (volts(m, w, id, 0.0, &vd, &vq) > v_max) {
            continue;
        }
        for (int k = 0; k < 25; k++) {
            const double iq = 0.5 * (low + high);
            if (volts(m, w, id, iq, &vd, &vq) <= v_max) {
                low = iq;
            } else {
                high = iq;
            }
        }
        best = fmax(best, torque_of(m, id, low));
    }
    return best;
}

/* ---- most torque per ampere ---------------------------------------------------------------------------------------------- */

/* Of all vectors of this length, none makes 0.1 % more torque, from hardly salient to three times the torque of the magnets. */
void test_current_reference_mtpa_makes_the_most_torque_of_the_current_circle(void)
{
    for (double k = -4.0; k <= 4.0; k += 0.37) {
        for (double torque = -3.0; torque <= 3.0; torque += 0.31) {
            const double id = value_of(ctl_mtpa_id(num_of(k), num_of(torque)));
            const double iq = torque / (1.0 + k * id);
            const double i = hypot(id, iq);
            double       most = 0.0;
            for (int a = 0; a <= 300; a++) {                   /* the best of them misses the best there is by less than 1e-4 */
                const double angle = TWO_PI * 0.5 * a / 300.0; /* iq >= 0 */
                most = fmax(most, i * sin(angle) * (1.0 + k * i * cos(angle)));
            }
            TEST_ASSERT_TRUE_MESSAGE(fabs(torque) >= 0.999 * most,
                                     at("k %g, torque %g: %g of %g", k, torque, fabs(torque), most));
        }
    }
}

void test_current_reference_mtpa_of_a_surface_machine_has_no_d_current_at_all(void)
{
    for (double torque = -100.0; torque <= 100.0; torque += 0.7) {
        TEST_ASSERT_TRUE(ctl_mtpa_id((num_t)0, num_of(torque)) == (num_t)0);
    }
}

/* 1.5 kW, Ld 0.9 mH, Lq 1.2 mH, 59.4 mWb: at 19.53 A the formula id = (psi - sqrt(psi^2 + 8 dL^2 i^2)) / (4 dL) gives -1.89 A */
void test_current_reference_mtpa_agrees_with_the_formula_over_the_length_of_the_vector(void)
{
    const double k = (0.9e-3 - 1.2e-3) / 0.0594, i = 19.53;
    const double id = (-1.0 + sqrt(1.0 + 8.0 * k * k * i * i)) / (4.0 * k);
    const double torque = sqrt(i * i - id * id) * (1.0 + k * id);
    const double unit = 20.0; /* both numerics */
    const double found = unit * value_of(ctl_mtpa_id(num_of(k * unit), num_of(torque / unit)));
    TEST_ASSERT_DOUBLE_WITHIN(2e-4, id, found);
}

/* ---- room ------------------------------------------------------------------------------------------------------------------- */

void test_current_reference_room_without_voltage_limit_is_that_of_the_circle(void)
{
    const machine_t m = {0.4, 0.1, 0.25, 0.02};
    const double    i_max = 2.0, k = (m.ld - m.lq) / m.psi;
    double          most = 0.0;
    for (int a = 0; a <= 5000; a++) {
        const double angle = TWO_PI * 0.25 * a / 5000.0;
        most = fmax(most, i_max * cos(angle) * (1.0 - k * i_max * sin(angle)));
    }
    const ctl_reference_params_t p = params_of(&m, i_max);
    begin(&p);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * most, most, value_of(plan.torque_max));
    TEST_ASSERT_TRUE(plan.id_at_max < (num_t)0);

    ctl_reference_params_t plain = p;
    plain.mtpa = false;
    begin(&plain);
    TEST_ASSERT_TRUE(plan.torque_max == plain.iq_max);
}

/* ---- field weakening -------------------------------------------------------------------------------------------------------- */

static const machine_t MACHINES[] = {
    {0.4, 0.1, 0.1, 0.03},   /* surface */
    {0.4, 0.12, 0.16, 0.02}, /* hardly salient */
    {0.3, 0.08, 0.24, 0.02}, /* interior magnets */
    {0.4, 0.25, 0.3, 0.01},  /* psi / Ld within the circle: no end of the speed */
};
#define I_MAX 2.0
#define V_LIMIT 1.0

static double base_speed(const machine_t *m)
{
    double w = 0.05, vd, vq;
    while (volts(m, w, 0.0, I_MAX, &vd, &vq) <= 0.95 * V_LIMIT) {
        w *= 1.01;
    }
    return w;
}

/* From base speed to twice that, in both directions, motor and brake, load from none to more than there is. */
void test_current_reference_keeps_the_voltage_and_makes_nearly_all_torque_that_there_is(void)
{
    for (size_t k = 0; k < COUNT_OF(MACHINES); k++) {
        const machine_t             *m = &MACHINES[k];
        const double                 base = base_speed(m);
        const ctl_reference_params_t p = params_of(m, I_MAX);
        const double                 deepest = -fmin(I_MAX, m->psi / m->ld);
        for (double times = 0.5; times <= 2.01; times += 0.25) {
            const double most = best_torque(m, times * base, 0.95 * V_LIMIT, I_MAX, deepest);
            for (int direction = -1; direction <= 1; direction += 2) {
                for (double load = -0.5; load <= 1.6; load += 0.7) {
                    const double w = direction * times * base;
                    const double asked = direction * load * I_MAX;
                    double       v = 0.0, torque = 0.0;
                    begin(&p);
                    for (int n = 0; n < 400; n++) {
                        torque = sample(m, w, V_LIMIT, asked, &v);
                    }
                    const char *const text = at("machine %u, %g times base, load %g: %g of %g, %g V", (unsigned)k,
                                                times * direction, load, torque, most, v);
                    TEST_ASSERT_TRUE_MESSAGE(v <= 0.955 * V_LIMIT, text);
                    if (asked * direction > 1.05 * most) { /* at its end: room and bound of the q current are what is there */
                        double vd, vq;
                        TEST_ASSERT_TRUE_MESSAGE(value_of(state.room) <= 1.01 * most + 1e-3, text);
                        TEST_ASSERT_TRUE_MESSAGE(volts(m, w, value_of(state.id), direction * value_of(state.iq_max), &vd, &vq) <=
                                                     0.97 * V_LIMIT,
                                                 text);
                    }
                    if (load > 0.0) {
                        TEST_ASSERT_TRUE_MESSAGE(torque * direction >= fmin(load * I_MAX, 0.97 * most) - 1e-3, text);
                    } else {
                        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-3, fmax(asked * direction, -value_of(state.room)),
                                                          torque * direction, text);
                    }
                }
            }
        }
    }
}

/* psi / Ld within the circle: from some speed on the largest torque lies inside it, for salient machines beyond the d current that
 * cancels the magnets. */
void test_current_reference_makes_the_most_torque_per_volt_where_the_circle_is_no_limit(void)
{
    static const struct {
        machine_t m;
        double    least_gain; /* of torque, over the d current that cancels the magnets, at four times base speed */
    } DEEP[] = {{{0.3, 0.2, 0.6, 0.004}, 1.1}, {{0.3, 0.24, 0.72, 0.004}, 1.1}, {{0.3, 0.25, 0.25, 0.004}, 1.0}};
    for (size_t k = 0; k < COUNT_OF(DEEP); k++) {
        const machine_t *const       m = &DEEP[k].m;
        const ctl_reference_params_t p = params_of(m, I_MAX);
        const double                 base = base_speed(m);
        for (double times = 1.0; times <= 4.01; times += 0.5) {
            const double w = times * base;
            const double most = best_torque(m, w, 0.95 * V_LIMIT, I_MAX, -I_MAX);
            const double shallow = best_torque(m, w, 0.95 * V_LIMIT, I_MAX, -m->psi / m->ld);
            double       v = 0.0, torque = 0.0;
            begin(&p);
            for (int n = 0; n < 1000; n++) {
                torque = sample(m, w, V_LIMIT, 12.0, &v);
            }
            const char *const text = at("machine %u, %g times base: %g of %g, at -psi/Ld %g, id %g, %g V", (unsigned)k, times,
                                        torque, most, shallow, value_of(state.id), v);
            TEST_ASSERT_TRUE_MESSAGE(v <= 0.952 * V_LIMIT, text);
            /* 0.5 %: the resistance is in (3) by its largest terms only, and the optimum is flat */
            TEST_ASSERT_TRUE_MESSAGE(torque >= 0.995 * most, text);
            if (times > 3.9) {
                TEST_ASSERT_TRUE_MESSAGE(most >= DEEP[k].least_gain * shallow, text);
                TEST_ASSERT_TRUE_MESSAGE((value_of(state.id) < -m->psi / m->ld - 0.01) == (m->lq > m->ld), text);
            }
            /* what is asked for within it is made, on the ellipse, up to the very optimum */
            for (double part = 0.7; part < 0.995; part += 0.07) {
                for (int n = 0; n < 1000; n++) {
                    torque = sample(m, w, V_LIMIT, part * most, &v);
                }
                TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.005 * most, part * most, torque, text);
                TEST_ASSERT_TRUE_MESSAGE(v <= 0.952 * V_LIMIT, text);
            }
        }
    }
}

/* Each of the four numbers off by what saturation and temperature make of it. */
void test_current_reference_finds_the_voltage_with_data_of_the_motor_that_are_off(void)
{
    for (size_t k = 0; k < COUNT_OF(MACHINES); k++) {
        const double w = fmax(1.6 * base_speed(&MACHINES[k]), 1.1 * V_LIMIT / MACHINES[k].psi); /* weakened without load, too */
        for (int corner = 0; corner < 8; corner++) {
            machine_t believed = MACHINES[k];
            believed.psi *= ((corner & 1) != 0) ? 1.07 : 0.93;
            believed.ld *= ((corner & 2) != 0) ? 1.15 : 0.85;
            believed.lq *= ((corner & 2) != 0) ? 1.15 : 0.85;
            believed.r *= ((corner & 4) != 0) ? 1.3 : 0.7;
            const ctl_reference_params_t p = params_of(&believed, I_MAX);
            for (double load = 0.0; load <= 0.61; load += 0.3) {
                double v = 0.0;
                begin(&p);
                for (int n = 0; n < 3000; n++) {
                    (void)sample(&MACHINES[k], w, V_LIMIT, load, &v);
                }
                TEST_ASSERT_TRUE_MESSAGE(
                    v <= 0.96 * V_LIMIT && v >= 0.9 * V_LIMIT,
                    at("machine %u, corner %d, load %g: %g V, trim %g", (unsigned)k, corner, load, v, value_of(state.trim)));
            }
        }
    }
}

/* Beyond what the d current may do, the q current goes, and comes back. */
void test_current_reference_limit_of_the_d_current_bounds_the_speed_and_is_never_passed(void)
{
    const machine_t       *m = &MACHINES[0];
    ctl_reference_params_t p = params_of(m, I_MAX);
    p.id_max = num_of(0.5);
    begin(&p);
    const double base = base_speed(m);
    double       v = 0.0, torque = 0.0;
    for (int n = 0; n < 500; n++) {
        torque = sample(m, 3.0 * base, V_LIMIT, I_MAX, &v);
        TEST_ASSERT_TRUE(value_of(state.id) >= -0.5 - 1e-6);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, torque);
    for (int n = 0; n < 500; n++) {
        torque = sample(m, 0.5 * base, V_LIMIT, I_MAX, &v);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, I_MAX, torque);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1.0, value_of(state.trim));
}

void test_current_reference_refuses_what_it_cannot_calculate_with(void)
{
    const ctl_reference_params_t good = params_of(&MACHINES[1], I_MAX);
    begin(&good);
    const ctl_reference_plan_t before = plan;
    for (uint16_t field = 1U; field <= (uint16_t)CTL_REFERENCE_GAIN; field++) {
        for (size_t k = 0; k < COUNT_OF(NOT_FINITE); k++) {
            ctl_reference_params_t bad = good;
            num_t *const           of[] = {&bad.saliency, &bad.d_full, &bad.q_full, &bad.emf,   &bad.ohm,
                                           &bad.i_max,    &bad.iq_max, &bad.id_max, &bad.share, &bad.fall};
            *of[field - 1U] = NOT_FINITE[k];
            TEST_ASSERT_NOT_EQUAL(CTL_OK, ctl_reference_plan(&plan, &bad).status);
            ASSERT_SAME_BITS(before, plan);
        }
    }
    ctl_reference_params_t beyond = good; /* a limit of one axis beyond the length of the vector: each is named */
    beyond.iq_max = num_of(1.01 * I_MAX);
    ctl_diag_t d = ctl_reference_plan(&plan, &beyond);
    TEST_ASSERT_EQUAL(CTL_ERR_RELATION, d.status);
    TEST_ASSERT_EQUAL_UINT16(CTL_REFERENCE_IQ_MAX, d.field);
    beyond.iq_max = good.iq_max;
    beyond.id_max = num_of(1.01 * I_MAX);
    d = ctl_reference_plan(&plan, &beyond);
    TEST_ASSERT_EQUAL(CTL_ERR_RELATION, d.status);
    TEST_ASSERT_EQUAL_UINT16(CTL_REFERENCE_ID_MAX, d.field);
    ASSERT_SAME_BITS(before, plan);
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_reference_plan(NULL, &good));
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_reference_plan(&plan, NULL));
}

void test_current_reference_mtpa_of_what_is_no_number_is_no_d_current(void)
{
    for (size_t k = 0; k < COUNT_OF(NOT_FINITE); k++) {
        TEST_ASSERT_DOUBLE_WITHIN(0.0, 0.0, value_of(ctl_mtpa_id(NOT_FINITE[k], num_of(0.5))));
        TEST_ASSERT_DOUBLE_WITHIN(0.0, 0.0, value_of(ctl_mtpa_id(num_of(-0.5), NOT_FINITE[k])));
    }
}

/* Any input in any order leaves what the header says. */
void test_current_reference_stays_bounded_whatever_comes(void)
{
    noise_t noise = {7U};
    for (size_t m = 0; m < COUNT_OF(MACHINES); m++) {
        const ctl_reference_params_t p = params_of(&MACHINES[m], I_MAX);
        begin(&p);
        for (uint32_t k = 0U; k < 20000U; k++) {
            const ctl_reference_in_t in = {
                noise_nasty(&noise), noise_nasty(&noise), noise_nasty(&noise), {noise_nasty(&noise), noise_nasty(&noise)}};
            ctl_reference_step(&plan, &state, &in);
            ASSERT_BOUNDED_AT(I_MAX, state.id, "id");
            TEST_ASSERT_TRUE(value_of(state.iq_max) >= 0.0 && value_of(state.iq_max) <= I_MAX);
            TEST_ASSERT_TRUE(hypot(value_of(state.id), value_of(state.iq_max)) <= 1.00001 * I_MAX);
            TEST_ASSERT_TRUE(value_of(state.room) >= 0.0 && value_of(state.room) <= value_of(plan.torque_max));
            TEST_ASSERT_TRUE(value_of(state.trim) >= 0.25 && value_of(state.trim) <= 1.5);
            TEST_ASSERT_TRUE(value_of(state.q_share) >= 0.0 && value_of(state.q_share) <= 8.1);
        }
        TEST_ASSERT_TRUE(state.rejected > 0U);
        double v = 0.0; /* and works again at once */
        for (int n = 0; n < 200; n++) {
            (void)sample(&MACHINES[m], 0.1, V_LIMIT, 0.5, &v);
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1.0, value_of(state.trim));
    }
}

/* ---- what follows from the parameters ----------------------------------------------------------------------------------------- */

/* k = (Ld - Lq) / psi: hardly any, 1 on either side, much; short circles and long ones. */
static const machine_t ANY[] = {
    {0.25, 0.25, 0.5, 0.02}, {0.25, 0.5, 0.25, 0.02}, {0.4, 0.6, 0.4, 0.02}, {0.4, 0.1, 0.25, 0.02}, {0.1, 0.1, 0.5, 0.02}};

void test_current_reference_plan_has_the_torque_of_the_circle_and_its_d_current_whatever_the_machine(void)
{
    static const double CIRCLE[] = {0.3, 0.9, 2.0};
    for (size_t n = 0; n < COUNT_OF(ANY); n++) {
        for (size_t c = 0; c < COUNT_OF(CIRCLE); c++) {
            const machine_t *const m = &ANY[n];
            const double           i_max = CIRCLE[c], k = (m->ld - m->lq) / m->psi;
            double                 most = 0.0, id_there = 0.0;
            for (int a = 0; a <= 5000; a++) {
                const double angle = TWO_PI * 0.5 * a / 5000.0;
                const double torque = i_max * sin(angle) * (1.0 + k * i_max * cos(angle));
                id_there = (torque > most) ? (i_max * cos(angle)) : id_there;
                most = fmax(most, torque);
            }
            const ctl_reference_params_t p = params_of(m, i_max);
            begin(&p);
            const char *const text = at("machine %u, circle %g", (unsigned)n, i_max);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-4 * most, most, value_of(plan.torque_max), text);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.01 * i_max, id_there, value_of(plan.id_at_max), text); /* the optimum is flat */
        }
    }
    ctl_reference_params_t plain = params_of(&ANY[0], 2.0);
    plain.mtpa = false;
    begin(&plain); /* a plan that had another one before */
    ASSERT_NUM_WITHIN(0.0, 2.0, plan.torque_max);
    ASSERT_NUM_WITHIN(0.0, 0.0, plan.id_at_max);
}

/* As the header and make_room have them: c = k F / (1 - k F), L^2 I^2 / (2 psi Ld), (Lq^2 - Ld^2) / (2 psi Ld). */
void test_current_reference_plan_follows_from_the_inductances_and_the_flux(void)
{
    const double i_max = 1.5;
    for (size_t n = 0; n < COUNT_OF(ANY); n++) {
        const machine_t *const m = &ANY[n];
        const double           k_f = (m->ld - m->lq) / m->ld, by = 2.0 * m->psi * m->ld;
        ctl_reference_params_t p = params_of(m, i_max);
        memset(&plan, 0x3F, sizeof plan);
        begin(&p);
        /* fixed: a quotient is off by a step, divided again by psi / Lq down to 0.2 and multiplied by I^2 and by 1 / 2: 6 steps each */
        const double within = per_numeric(4e-6, 80.0 * FIXED_STEP);
        ASSERT_NUM_WITHIN(within, m->ld / m->psi, plan.per_d_full);
        ASSERT_NUM_WITHIN(within, k_f, plan.share_full);
        if (k_f < 0.9) {
            ASSERT_NUM_WITHIN(within, k_f / (1.0 - k_f), plan.volt_gain);
        }
        ASSERT_NUM_WITHIN(within, i_max * i_max * m->lq * m->lq / by, plan.half_square);
        ASSERT_NUM_WITHIN(within, (m->lq * m->lq - m->ld * m->ld) / by, plan.curvature);
        ASSERT_NUM_WITHIN(within, (k_f > 0.0) ? 0.0 : (-m->psi / m->ld), plan.surely);
    }
}

/* (2) by halving an interval in double precision: u^4 - u^3 = t^2, id = k i_T^2 / u^3. The third Newton step leaves
 * 5e-6 of it, the second a hundred times as much. */
void test_current_reference_mtpa_solves_its_equation(void)
{
    for (double k = -3.0; k <= 3.0; k += 0.43) {
        for (double torque = -4.0; torque <= 4.0; torque += 0.37) {
            double       low = 1.0, high = 8.0;
            const double t = fabs(k * torque);
            for (int n = 0; n < 60; n++) {
                const double u = 0.5 * (low + high);
                if (u * u * u * (u - 1.0) < t * t) {
                    low = u;
                } else {
                    high = u;
                }
            }
            const double want = k * torque * torque / (low * low * low);
            ASSERT_NUM_WITHIN_AT(per_numeric(1e-5, 1e-5), want, ctl_mtpa_id(num_of(k), num_of(torque)),
                                 at("k %g, torque %g", k, torque));
        }
    }
}

/* ---- state ---------------------------------------------------------------------------------------------------------------------- */

void test_current_reference_reset_is_without_current_and_without_a_limit(void)
{
    const ctl_reference_params_t p = params_of(&MACHINES[2], I_MAX);
    begin(&p);
    memset(&state, 0x3F, sizeof state);
    state.limited = true;
    ctl_reference_reset(&plan, &state);
    ASSERT_NUM_WITHIN(0.0, 0.0, state.id);
    ASSERT_NUM_WITHIN(0.0, I_MAX, state.iq_max);
    ASSERT_NUM_WITHIN(0.0, 1.0, state.q_share);
    ASSERT_NUM_WITHIN(0.0, 1.0, state.gain);
    ASSERT_NUM_WITHIN(0.0, value_of(plan.torque_max), state.room);
    ASSERT_NUM_WITHIN(0.0, 1.0, state.trim);
    ASSERT_NUM_WITHIN(0.0, 0.0, state.used);
    ASSERT_NUM_WITHIN(0.0, 0.0, state.drop);
    TEST_ASSERT_FALSE(state.limited);
}

void test_current_reference_leaves_all_as_it_is_and_counts_where_one_input_is_no_number(void)
{
    const ctl_reference_params_t p = params_of(&MACHINES[2], I_MAX);
    const ctl_reference_in_t     good = {num_of(0.5), num_of(1.0), num_of(1.0), {num_of(0.25), num_of(0.5)}};
    begin(&p);
    ctl_reference_step(&plan, &state, &good);
    for (size_t k = 0; k < COUNT_OF(NOT_FINITE); k++) {
        for (int field = 0; field < 5; field++) {
            ctl_reference_in_t          in = good;
            num_t *const                of[] = {&in.torque, &in.speed, &in.v_limit, &in.volt.d, &in.volt.q};
            const ctl_reference_state_t before = state;
            *of[field] = NOT_FINITE[k];
            ctl_reference_step(&plan, &state, &in);
            TEST_ASSERT_EQUAL_UINT32(before.rejected + 1U, state.rejected);
            state.rejected = before.rejected;
            TEST_ASSERT_TRUE_MESSAGE((state.id == before.id) && (state.iq_max == before.iq_max) && (state.room == before.room) &&
                                         (state.trim == before.trim) && (state.used == before.used) &&
                                         (state.drop == before.drop),
                                     at("field %d", field));
        }
    }
}

void test_current_reference_without_either_has_no_d_current_and_the_room_of_its_limit(void)
{
    ctl_reference_params_t p = params_of(&MACHINES[2], I_MAX);
    p.mtpa = false;
    p.weakens = false;
    p.iq_max = num_of(1.25);
    begin(&p);
    memset(&state, 0x3F, sizeof state);
    const ctl_reference_in_t in = {num_of(0.5), num_of(3.0), num_of(1.0), {num_of(0.25), num_of(0.5)}};
    ctl_reference_step(&plan, &state, &in);
    ASSERT_NUM_WITHIN(0.0, 0.0, state.id);
    ASSERT_NUM_WITHIN(0.0, 1.25, state.iq_max);
    ASSERT_NUM_WITHIN(0.0, 1.25, state.room);
    ASSERT_NUM_WITHIN(0.0, 1.0, state.gain);
    ASSERT_NUM_WITHIN(0.0, 1.0, state.q_share);

    p = params_of(&MACHINES[2], I_MAX); /* 1 + k id of most torque per ampere, and what the circle leaves beside it */
    p.weakens = false;
    begin(&p);
    const ctl_reference_in_t much = {plan.torque_max, num_of(0.0), num_of(1.0), {num_of(0.0), num_of(0.0)}};
    ctl_reference_step(&plan, &state, &much);
    const double k = (MACHINES[2].ld - MACHINES[2].lq) / MACHINES[2].psi, id = value_of(state.id);
    TEST_ASSERT_TRUE(id < -0.5);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0 + k * id, value_of(state.gain));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0 / (1.0 + k * id), value_of(state.q_share));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, sqrt(I_MAX * I_MAX - id * id), value_of(state.iq_max));
}

/* One sample at standstill, where the voltage is no limit, with a measured voltage and the mean of it as given. */
static double trim_after(double trim, double used)
{
    state.trim = num_of(trim);
    state.used = num_of(used);
    const ctl_reference_in_t in = {num_of(0.0), num_of(0.0), num_of(1.0), {num_of(0.75 * used), num_of(0.0)}};
    ctl_reference_step(&plan, &state, &in);
    return value_of(state.trim);
}

/* Above what may be used by a quarter: 0.25 of the gain 0.125 down. At it or below it: back to 1, by the other gain. */
void test_current_reference_correction_falls_with_the_excess_and_goes_back_to_one_without(void)
{
    ctl_reference_params_t p = params_of(&MACHINES[0], I_MAX);
    p.share = num_of(0.75);
    p.fall = num_of(0.125);
    p.rise = num_of(0.25);
    begin(&p);
    const double within = per_numeric(1e-6, 4.0 * FIXED_STEP);
    TEST_ASSERT_DOUBLE_WITHIN(within, 0.75 - 0.125 * 0.25, trim_after(0.75, 1.25));
    TEST_ASSERT_DOUBLE_WITHIN(within, 0.75 + 0.25 * 0.25, trim_after(0.75, 1.0));
    TEST_ASSERT_DOUBLE_WITHIN(within, 0.75 + 0.25 * 0.25, trim_after(0.75, 0.5));
    state.limited = true; /* it is the limit: up to all that there is, not to 1 */
    TEST_ASSERT_DOUBLE_WITHIN(within, 1.25 + 0.25 * 0.5, trim_after(1.25, 0.5));
    TEST_ASSERT_FALSE(state.limited);
    TEST_ASSERT_DOUBLE_WITHIN(within, 0.25, trim_after(0.25, 1.5));
    state.limited = true;
    TEST_ASSERT_DOUBLE_WITHIN(within, 1.5, trim_after(1.5, 0.0));
}

/* 2 R w psi i_T + R^2 i^2, of the header, once the mean has settled. */
void test_current_reference_knows_what_the_resistance_takes_of_the_square_of_the_voltage(void)
{
    for (size_t k = 0; k < COUNT_OF(MACHINES); k++) {
        const machine_t             *m = &MACHINES[k];
        const ctl_reference_params_t p = params_of(m, I_MAX);
        const double                 w = 0.7 * base_speed(m), torque = 0.8;
        double                       v = 0.0;
        begin(&p);
        for (int n = 0; n < 100; n++) {
            (void)sample(m, w, V_LIMIT, torque, &v);
        }
        const double id = value_of(state.id), iq = torque * value_of(state.q_share);
        const double want = 2.0 * m->r * w * m->psi * torque + m->r * m->r * (id * id + iq * iq);
        ASSERT_DOUBLE_WITHIN_AT(2e-6 + 0.0001 * want, want, value_of(state.drop), at("machine %u", (unsigned)k));
    }
}

/* Without resistance, with the voltage that may be used and no correction: (3) with n = 0.9. The d current ends at 0.5, flux 1 - 0.5 / 4 =
 * 0.875: Q sqrt(0.81 - 0.875^2) = 0.8427 of q current is left, which is the torque as well. */
void test_current_reference_bounds_the_q_current_by_the_voltage_where_the_d_current_has_its_limit(void)
{
    const machine_t        m = {0.4, 0.1, 0.1, 0.0};
    ctl_reference_params_t p = params_of(&m, I_MAX);
    p.id_max = num_of(0.5);
    begin(&p);
    const ctl_reference_in_t in = {num_of(2.0), num_of(0.95 / (0.9 * 0.4)), num_of(1.0), {num_of(0.0), num_of(0.0)}};
    ctl_reference_step(&plan, &state, &in);
    const double want = 4.0 * sqrt(0.81 - 0.875 * 0.875);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, -0.5, value_of(state.id));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, want, value_of(state.iq_max));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, want, value_of(state.room));
    TEST_ASSERT_TRUE(state.limited);
}

/* The d current of most torque per volt itself, which its torque hardly shows: the best of 40000 on (3) without resistance. */
void test_current_reference_d_current_of_most_torque_per_volt_is_the_best_on_the_ellipse(void)
{
    static const machine_t DEEP[] = {{0.3, 0.2, 0.6, 0.0}, {0.3, 0.24, 0.72, 0.0}, {0.3, 0.25, 0.3, 0.0}};
    for (size_t i = 0; i < COUNT_OF(DEEP); i++) {
        const machine_t *const       m = &DEEP[i];
        const ctl_reference_params_t p = params_of(m, I_MAX);
        const double                 n = 0.4, f = m->psi / m->ld, q = m->psi / m->lq, k = (m->ld - m->lq) / m->psi;
        double                       most = 0.0, id_there = 0.0;
        for (int a = 0; a < 40000; a++) {
            const double angle = 0.5 * TWO_PI * a / 40000.0, id = f * (n * cos(angle) - 1.0);
            const double torque = q * n * sin(angle) * (1.0 + k * id);
            id_there = (torque > most) ? id : id_there;
            most = fmax(most, torque);
        }
        begin(&p);
        state.used = num_of(1.0); /* the voltage is what may be used: no correction */
        for (int step = 0; step < 60; step++) {
            const ctl_reference_in_t in = {state.room, num_of(0.95 / (n * m->psi)), num_of(1.0), {num_of(0.95), num_of(0.0)}};
            ctl_reference_step(&plan, &state, &in);
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, 1.0, value_of(state.trim));
        ASSERT_DOUBLE_WITHIN_AT(1e-3, id_there, value_of(state.id), at("machine %u", (unsigned)i));
        ASSERT_DOUBLE_WITHIN_AT(1e-3 * most, most, value_of(state.room), at("machine %u", (unsigned)i));
    }
}
