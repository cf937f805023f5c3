/* sim_host/capi/blocks: the lists of all blocks, parameters by name, refusals as values, actions. */
#include <math.h>
#include <string.h>

#include "sim_host/capi/evenspin_capi.h"
#include "unity.h"

#define PORTS 8

static es_error_t error;

void setUp(void) { (void)memset(&error, 0, sizeof error); }
void tearDown(void) {}

static es_block_t *made(const char *name)
{
    es_block_t *const block = es_block_new(name, &error);
    TEST_ASSERT_NOT_NULL_MESSAGE(block, name);
    return block;
}

static int words(const char *list)
{
    int n = (list[0] != '\0') ? 1 : 0;
    for (const char *c = strchr(list, '|'); c != NULL; c = strchr(c + 1, '|')) {
        n++;
    }
    return n;
}

static int find(const char *name)
{
    es_block_info_t info;
    for (int b = 0; es_block_info(b, &info); b++) {
        if (strcmp(info.name, name) == 0) {
            return b;
        }
    }
    return -1;
}

void test_blocks_explain_themselves_and_say_nothing_beyond_their_lists(void)
{
    es_block_info_t info;
    es_field_t      f;
    es_action_t     a;
    TEST_ASSERT_TRUE(es_block_count() >= 9);
    for (int b = 0; b < es_block_count(); b++) {
        TEST_ASSERT_TRUE(es_block_info(b, &info));
        TEST_ASSERT_TRUE_MESSAGE((strlen(info.doc) > 0U) && (info.param_count > 0) && (info.action_count > 0), info.name);
        for (int k = 0; k < info.param_count; k++) {
            TEST_ASSERT_TRUE_MESSAGE(es_block_param_info(b, k, &f), info.name);
            TEST_ASSERT_TRUE_MESSAGE(strlen(f.doc) > 0U, f.name);
            TEST_ASSERT_TRUE_MESSAGE((strcmp(f.kind, "choice") == 0) == (strlen(f.choices) > 0U), f.name);
            TEST_ASSERT_TRUE_MESSAGE((strcmp(f.kind, "choice") != 0) || (words(f.choices) == ((int)f.max + 1)), f.name);
        }
        for (int k = 0; k < info.action_count; k++) {
            TEST_ASSERT_TRUE_MESSAGE(es_block_action_info(b, k, &a), info.name);
            TEST_ASSERT_EQUAL_INT_MESSAGE(words(a.inputs), a.input_count, a.name);
            TEST_ASSERT_EQUAL_INT_MESSAGE(words(a.outputs), a.output_count, a.name);
            TEST_ASSERT_TRUE_MESSAGE((a.input_count <= PORTS) && (a.output_count <= PORTS), a.name);
        }
        TEST_ASSERT_FALSE(es_block_param_info(b, info.param_count, &f));
        TEST_ASSERT_FALSE(es_block_param_info(b, -1, &f));
        TEST_ASSERT_FALSE(es_block_action_info(b, info.action_count, &a));
        TEST_ASSERT_FALSE(es_block_action_info(b, 0, NULL));
    }
    TEST_ASSERT_FALSE(es_block_info(-1, &info));
    TEST_ASSERT_FALSE(es_block_info(es_block_count(), &info));
    TEST_ASSERT_FALSE(es_block_info(0, NULL));
    TEST_ASSERT_FALSE(es_block_param_info(-1, 0, &f));
}

void test_blocks_start_with_the_defaults_of_their_lists(void)
{
    es_block_info_t info;
    for (int b = 0; b < es_block_count(); b++) {
        TEST_ASSERT_TRUE(es_block_info(b, &info));
        es_block_t *const block = made(info.name);
        TEST_ASSERT_TRUE_MESSAGE(es_block_start(block, &error), error.name);
        es_block_free(block);
    }
}

void test_blocks_take_every_value_of_their_range_and_no_other_one(void)
{
    es_block_info_t info;
    es_field_t      f;
    for (int b = 0; b < es_block_count(); b++) {
        TEST_ASSERT_TRUE(es_block_info(b, &info));
        es_block_t *const block = made(info.name);
        for (int k = 0; k < info.param_count; k++) {
            TEST_ASSERT_TRUE(es_block_param_info(b, k, &f));
            TEST_ASSERT_TRUE_MESSAGE(es_block_set(block, f.name, f.value, &error), f.name);
            TEST_ASSERT_EQUAL_MESSAGE(isfinite(f.min) && !f.above, es_block_set(block, f.name, f.min, &error), f.name);
            TEST_ASSERT_EQUAL_MESSAGE(isfinite(f.max) && !f.below, es_block_set(block, f.name, f.max, &error), f.name);
            const double bad[] = {NAN, INFINITY, -INFINITY, f.min - 1.0, f.max + 1.0};
            for (size_t i = 0; i < (sizeof bad / sizeof bad[0]); i++) {
                TEST_ASSERT_FALSE_MESSAGE(es_block_set(block, f.name, bad[i], &error), f.name);
                TEST_ASSERT_EQUAL_STRING(f.name, error.name);
                TEST_ASSERT_EQUAL_STRING("block_param", error.list);
                TEST_ASSERT_EQUAL_STRING(info.name, error.other);
                TEST_ASSERT_EQUAL_DOUBLE(f.min, error.min);
                TEST_ASSERT_EQUAL_DOUBLE(f.max, error.max);
                TEST_ASSERT_EQUAL(f.above, error.above);
                TEST_ASSERT_EQUAL(f.below, error.below);
            }
            if (strcmp(f.kind, "float") != 0) {
                TEST_ASSERT_FALSE_MESSAGE(es_block_set(block, f.name, f.min + 0.5, &error), f.name);
                TEST_ASSERT_EQUAL_INT_MESSAGE(ES_NOT_WHOLE, error.code, f.name);
            }
        }
        es_block_free(block);
    }
}

void test_blocks_refused_value_leaves_the_one_before(void)
{
    const double      in[] = {1.0};
    double            out[1];
    es_block_t *const pi = made("pi");
    TEST_ASSERT_TRUE(es_block_set(pi, "kp", 0.25, &error));
    TEST_ASSERT_FALSE(es_block_set(pi, "kp", -1.0, &error));
    TEST_ASSERT_TRUE(es_block_start(pi, &error));
    TEST_ASSERT_TRUE(es_block_do(pi, 0, in, out));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.25, out[0]);
    es_block_free(pi);
}

static void assert_rule(const char *block_name, const char *param, double value, const char *second, double second_value,
                        const char *said)
{
    es_block_t *const block = made(block_name);
    TEST_ASSERT_TRUE(es_block_set(block, param, value, &error));
    TEST_ASSERT_TRUE(es_block_set(block, second, second_value, &error));
    TEST_ASSERT_FALSE_MESSAGE(es_block_start(block, &error), param);
    TEST_ASSERT_EQUAL_INT(ES_BREAKS_RULE, error.code);
    TEST_ASSERT_EQUAL_STRING(param, error.name);
    TEST_ASSERT_EQUAL_DOUBLE(value, error.given);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.rule, said), error.rule);
    es_block_free(block);
}

void test_blocks_refuse_what_breaks_a_rule_and_name_the_parameter_and_the_rule(void)
{
    assert_rule("rc", "q_centre", 0.9, "q_side", 0.4, "|q_centre| + 2 |q_side| <= 1");
    assert_rule("rc", "capacity", 3.0, "lead", 5.0, "lead + order + 5");
    assert_rule("rc", "lead", 1.0, "memory", 2.0, "at least 2");
    assert_rule("pi", "out_min", 2.0, "out_max", 1.0, "below out_max");
    assert_rule("pll", "kp", 20000.0, "ts_s", 1e-4, "1 / ts_s");
    assert_rule("mt", "clock_hz", 1.0, "ts_s", 1e-3, "within 1 .. 4e9");
    assert_rule("observer", "viscous_nms", 1.0, "inertia_kgm2", 1e-6, "inertia_kgm2 / ts_s");
    assert_rule("observer", "fir2_hz", 6000.0, "ts_s", 1e-4, "0.5 of the sampling rate");
    assert_rule("profile", "speed_rad_s", 4000.0, "ts_s", 1e-3, "half a turn");
}

void test_blocks_refuse_names_that_do_not_exist(void)
{
    TEST_ASSERT_NULL(es_block_new("gremlin", &error));
    TEST_ASSERT_EQUAL_INT(ES_UNKNOWN, error.code);
    TEST_ASSERT_EQUAL_STRING("gremlin", error.name);
    TEST_ASSERT_EQUAL_STRING("block", error.list);
    es_block_t *const pi = made("pi");
    TEST_ASSERT_FALSE(es_block_set(pi, "kq", 1.0, &error));
    TEST_ASSERT_EQUAL_INT(ES_UNKNOWN, error.code);
    TEST_ASSERT_EQUAL_STRING("kq", error.name);
    TEST_ASSERT_EQUAL_STRING("pi", error.other);
    es_block_free(pi);
}

void test_blocks_do_nothing_before_the_start_and_no_action_that_is_none(void)
{
    const double      in[PORTS] = {0.0};
    double            out[PORTS];
    es_block_t *const rc = made("rc");
    TEST_ASSERT_FALSE(es_block_do(rc, 0, in, out));
    TEST_ASSERT_EQUAL_INT(0, es_block_table(rc, out, PORTS));
    TEST_ASSERT_TRUE(es_block_start(rc, &error));
    TEST_ASSERT_TRUE(es_block_do(rc, 0, in, out));
    TEST_ASSERT_FALSE(es_block_do(rc, -1, in, out));
    TEST_ASSERT_FALSE(es_block_do(rc, 100, in, out));
    TEST_ASSERT_FALSE(es_block_do(rc, 0, NULL, out));
    TEST_ASSERT_FALSE(es_block_do(rc, 0, in, NULL));
    TEST_ASSERT_TRUE(es_block_do(rc, 1, NULL, NULL)); /* reset takes and gives nothing */
    es_block_free(rc);
}

void test_blocks_give_finite_numbers_whatever_goes_in(void)
{
    static const double NASTY[] = {0.0, 1.0, -1.0, NAN, INFINITY, -INFINITY, 1e300, -1e300, 1e12, 5e9, -5e9, 1e-300};
    const int           count = (int)(sizeof NASTY / sizeof NASTY[0]);
    es_block_info_t     info;
    es_action_t         a;
    for (int b = 0; es_block_info(b, &info); b++) {
        es_block_t *const block = made(info.name);
        TEST_ASSERT_TRUE_MESSAGE(es_block_start(block, &error), info.name);
        for (int round = 0; round < 200; round++) {
            for (int k = 0; k < info.action_count; k++) {
                double in[PORTS];
                double out[PORTS] = {0.0};
                TEST_ASSERT_TRUE(es_block_action_info(b, k, &a));
                for (int i = 0; i < PORTS; i++) {
                    in[i] = NASTY[(round * 7 + k * 5 + i * 3 + round / 12 * i) % count];
                }
                TEST_ASSERT_TRUE(es_block_do(block, k, in, out));
                for (int i = 0; i < a.output_count; i++) {
                    TEST_ASSERT_TRUE_MESSAGE(isfinite(out[i]), a.outputs);
                }
            }
        }
        es_block_free(block);
    }
}

void test_blocks_that_fail_to_start_again_do_not_go_on(void)
{
    const double      in[] = {1.0};
    double            out[1];
    es_block_t *const pi = made("pi");
    TEST_ASSERT_TRUE(es_block_start(pi, &error));
    TEST_ASSERT_TRUE(es_block_set(pi, "out_min", 2.0, &error));
    TEST_ASSERT_FALSE(es_block_start(pi, &error));
    TEST_ASSERT_FALSE(es_block_do(pi, 0, in, out));
    es_block_free(pi);
}

void test_blocks_table_writes_no_more_than_there_is_room_for(void)
{
    double            out[16] = {0.0};
    es_block_t *const fir = made("fir");
    TEST_ASSERT_TRUE(es_block_set(fir, "order", 3.0, &error));
    TEST_ASSERT_TRUE(es_block_start(fir, &error));
    out[2] = 77.0;
    TEST_ASSERT_EQUAL_INT(4, es_block_table(fir, out, 2));
    TEST_ASSERT_EQUAL_DOUBLE(77.0, out[2]);
    TEST_ASSERT_EQUAL_INT(4, es_block_table(fir, NULL, 16));
    TEST_ASSERT_EQUAL_INT(4, es_block_table(fir, out, 16));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, out[0] + out[1] + out[2] + out[3]); /* a low-pass passes what does not change */
    es_block_free(fir);
}

void test_blocks_are_total_for_no_object_no_text_and_nowhere_to_say_why(void)
{
    es_field_t f;
    es_block_free(NULL);
    TEST_ASSERT_NULL(es_block_new(NULL, NULL));
    TEST_ASSERT_NULL(es_block_new("gremlin", NULL));
    TEST_ASSERT_FALSE(es_block_set(NULL, "kp", 1.0, &error));
    TEST_ASSERT_EQUAL_INT(ES_NO_OBJECT, error.code);
    TEST_ASSERT_FALSE(es_block_start(NULL, NULL));
    TEST_ASSERT_FALSE(es_block_do(NULL, 0, NULL, NULL));
    TEST_ASSERT_EQUAL_INT(0, es_block_table(NULL, NULL, 0));
    es_block_t *const pi = made("pi");
    TEST_ASSERT_FALSE(es_block_set(pi, NULL, 1.0, NULL));
    TEST_ASSERT_FALSE(es_block_set(pi, "kp", NAN, NULL));
    TEST_ASSERT_TRUE(es_block_set(pi, "out_min", 2.0, NULL));
    TEST_ASSERT_FALSE(es_block_start(pi, NULL));
    es_block_free(pi);
    TEST_ASSERT_FALSE(es_block_param_info(find("pi"), 0, NULL));
    TEST_ASSERT_FALSE(es_block_param_info(1000, 0, &f));
}

/* ---- functions that may refuse ---------------------------------------------------------------------------------------- */

void test_functions_refuse_with_name_value_and_what_is_allowed(void)
{
    double y[4];
    TEST_ASSERT_FALSE(es_fal(1.0, 0.0, 0.4, y, &error));
    TEST_ASSERT_EQUAL_STRING("alpha", error.name);
    TEST_ASSERT_TRUE(error.above && !error.below && (error.min == 0.0) && (error.max == 1.0));
    TEST_ASSERT_FALSE(es_fal_lambda(1.0, 0.5, -1.0, y, &error));
    TEST_ASSERT_EQUAL_STRING("delta", error.name);
    TEST_ASSERT_FALSE(es_lagrange(4, 0.5, y, &error));
    TEST_ASSERT_EQUAL_STRING("order", error.name);
    TEST_ASSERT_FALSE(es_lagrange(2, 2.5, y, &error));
    TEST_ASSERT_EQUAL_STRING("frac", error.name);
    TEST_ASSERT_EQUAL_DOUBLE(2.0, error.max);
    TEST_ASSERT_FALSE(es_stribeck(1.0, 0.4, 0.3, 0.5, 2.0, y, &error));
    TEST_ASSERT_EQUAL_INT(ES_BELOW_OTHER, error.code);
    TEST_ASSERT_EQUAL_STRING("coulomb", error.other);
    TEST_ASSERT_FALSE(es_spatial_lowpass(60.0, 100.0, 1e-3, y, y, &error));
    TEST_ASSERT_EQUAL_STRING("speed", error.name);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2.0 / (60.0 * 1e-3), error.max); /* where W ts / 2 is 1 */
    TEST_ASSERT_FALSE(es_spatial_lowpass(60.0, NAN, 1e-3, y, y, NULL));
}
