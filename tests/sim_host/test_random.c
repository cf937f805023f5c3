/* sim_host/plant/random.c: the published generators, and numbers with the distributions they promise. */
#include <math.h>
#include <string.h>

#include "sim_host/plant/random.h"
#include "unity.h"

#define DRAWS 400000

static sim_random_t r;

void setUp(void) { sim_random_seed(&r, 1U); }
void tearDown(void) {}

/* Vigna's splitmix64.c with seed 0 */
void test_random_seed_is_spread_by_splitmix64(void)
{
    sim_random_seed(&r, 0U);

    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0xe220a8397b1dcdaf), r.s[0]);
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0x6e789e6aa1b965f4), r.s[1]);
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0x06c45d188009454f), r.s[2]);
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0xf88bb8a8724c81ec), r.s[3]);
}

/* Blackman and Vigna's xoshiro256plusplus.c from state 1, 2, 3, 4; a uniform number is the upper 53 bits */
void test_random_uniform_numbers_are_those_of_xoshiro256_plus_plus(void)
{
    static const uint64_t PUBLISHED[] = {UINT64_C(41943041),
                                         UINT64_C(58720359),
                                         UINT64_C(3588806011781223),
                                         UINT64_C(3591011842654386),
                                         UINT64_C(9228616714210784205),
                                         UINT64_C(9973669472204895162),
                                         UINT64_C(14011001112246962877),
                                         UINT64_C(12406186145184390807),
                                         UINT64_C(15849039046786891736),
                                         UINT64_C(10450023813501588000)};
    const sim_random_t    state = {{1U, 2U, 3U, 4U}};
    r = state;
    for (size_t k = 0; k < sizeof PUBLISHED / sizeof PUBLISHED[0]; k++) {
        const double x = sim_random_uniform(&r); /* the assertion looks twice */
        TEST_ASSERT_EQUAL_DOUBLE((double)(PUBLISHED[k] >> 11) / 9007199254740992.0, x);
    }
}

void test_random_same_seed_gives_the_same_numbers(void)
{
    sim_random_t other;
    sim_random_seed(&other, 1U);
    for (int k = 0; k < 1000; k++) {
        const double x = sim_random_uniform(&r);
        const double y = sim_random_uniform(&other);
        TEST_ASSERT_EQUAL_DOUBLE(x, y);
    }
    double a[2];
    double b[2];
    for (int k = 0; k < 1000; k++) {
        sim_random_normal2(&r, a);
        sim_random_normal2(&other, b);
        TEST_ASSERT_EQUAL_MEMORY(a, b, sizeof a);
    }
}

void test_random_other_seed_gives_other_numbers(void)
{
    sim_random_t other;
    sim_random_seed(&other, 2U);
    int same = 0;
    for (int k = 0; k < 1000; k++) {
        same += (sim_random_uniform(&r) == sim_random_uniform(&other)) ? 1 : 0;
    }
    TEST_ASSERT_EQUAL_INT(0, same);
}

/* mean 1/2 with sigma sqrt(1/12/n) = 4.6e-4, mean square 1/3 with sqrt(4/45/n) = 4.7e-4: five of each */
void test_random_uniform_numbers_fill_the_unit_interval_evenly(void)
{
    double sum = 0.0;
    double square = 0.0;
    int    tenth[10] = {0};
    for (int k = 0; k < DRAWS; k++) {
        const double x = sim_random_uniform(&r);
        TEST_ASSERT_TRUE((x >= 0.0) && (x < 1.0));
        sum += x;
        square += x * x;
        tenth[(int)(x * 10.0)]++;
    }
    TEST_ASSERT_DOUBLE_WITHIN(2.3e-3, 0.5, sum / DRAWS);
    TEST_ASSERT_DOUBLE_WITHIN(2.4e-3, 1.0 / 3.0, square / DRAWS);
    for (int k = 0; k < 10; k++) { /* 40000 with sigma 190 */
        TEST_ASSERT_INT_WITHIN(950, DRAWS / 10, tenth[k]);
    }
}

/* n pairs: sigma of the mean 1/sqrt(n) = 1.6e-3, of the variance sqrt(2/n) = 2.2e-3, of the third moment sqrt(15/n),
 * of the fourth sqrt(96/n), of the product 1/sqrt(n): five of each */
void test_random_normal_numbers_have_the_moments_of_a_normal_distribution_and_come_in_independent_pairs(void)
{
    double m[2][4] = {{0.0}};
    double product = 0.0;
    int    beyond_3 = 0;
    for (int k = 0; k < DRAWS; k++) {
        double x[2];
        sim_random_normal2(&r, x);
        for (int i = 0; i < 2; i++) {
            m[i][0] += x[i];
            m[i][1] += x[i] * x[i];
            m[i][2] += x[i] * x[i] * x[i];
            m[i][3] += x[i] * x[i] * x[i] * x[i];
            beyond_3 += (fabs(x[i]) > 3.0) ? 1 : 0;
        }
        product += x[0] * x[1];
    }
    const double n = sqrt((double)DRAWS);
    for (int i = 0; i < 2; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(5.0 / n, 0.0, m[i][0] / DRAWS);
        TEST_ASSERT_DOUBLE_WITHIN(5.0 * sqrt(2.0) / n, 1.0, m[i][1] / DRAWS);
        TEST_ASSERT_DOUBLE_WITHIN(5.0 * sqrt(15.0) / n, 0.0, m[i][2] / DRAWS);
        TEST_ASSERT_DOUBLE_WITHIN(5.0 * sqrt(96.0) / n, 3.0, m[i][3] / DRAWS);
    }
    TEST_ASSERT_DOUBLE_WITHIN(5.0 / n, 0.0, product / DRAWS);
    TEST_ASSERT_INT_WITHIN(235, 2160, beyond_3); /* 0.27 % of 800000, sigma 46 */
}
