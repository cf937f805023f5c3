/* control/memory/ring.c: the newest samples, and zeros for what never was. */
#include "tests/support/numeric.h"

#include "control/memory/ring.h"

#define CAPACITY 5U
#define GUARD 2U /* cells behind the memory that must never change */

static num_t      memory[CAPACITY + GUARD];
static ctl_ring_t ring;

void setUp(void)
{
    for (size_t i = 0; i < COUNT_OF(memory); i++) {
        memory[i] = num_of(99.0);
    }
    TEST_ASSERT_EQUAL(CTL_OK, ctl_ring_init(&ring, memory, CAPACITY).status);
}

void tearDown(void)
{
    for (size_t i = CAPACITY; i < COUNT_OF(memory); i++) {
        ASSERT_NUM_WITHIN_AT(0.0, 99.0, memory[i], "written behind the memory");
    }
}

static void push_up_to(int last)
{
    for (int i = 1; i <= last; i++) {
        ctl_ring_push(&ring, num_of(i));
    }
}

void test_ctl_ring_fresh_reads_zero_whatever_the_memory_held(void)
{
    for (uint16_t delay = 0; delay < CAPACITY; delay++) {
        ASSERT_NUM_WITHIN_AT(0.0, 0.0, ctl_ring_get(&ring, delay), at("delay %u", delay));
    }
}

void test_ctl_ring_get_counts_pushes_back(void)
{
    push_up_to(3);

    ASSERT_NUM_WITHIN(0.0, 3.0, ctl_ring_get(&ring, 0U));
    ASSERT_NUM_WITHIN(0.0, 2.0, ctl_ring_get(&ring, 1U));
    ASSERT_NUM_WITHIN(0.0, 1.0, ctl_ring_get(&ring, 2U));
    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_ring_get(&ring, 3U));
}

void test_ctl_ring_full_forgets_the_oldest(void)
{
    for (int last = 1; last <= 23; last++) {
        ctl_ring_push(&ring, num_of(last));
        for (uint16_t delay = 0; delay < CAPACITY; delay++) {
            const double want = ((last - (int)delay) > 0) ? (last - (int)delay) : 0.0;

            ASSERT_NUM_WITHIN_AT(0.0, want, ctl_ring_get(&ring, delay), at("last %d, delay %u", last, delay));
        }
    }
}

void test_ctl_ring_get_beyond_the_capacity_is_zero(void)
{
    push_up_to(9);

    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_ring_get(&ring, CAPACITY));
    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_ring_get(&ring, UINT16_MAX));
}

void test_ctl_ring_clear_forgets_everything(void)
{
    push_up_to(7);

    ctl_ring_clear(&ring);

    for (uint16_t delay = 0; delay < CAPACITY; delay++) {
        ASSERT_NUM_WITHIN_AT(0.0, 0.0, ctl_ring_get(&ring, delay), at("delay %u", delay));
    }
}

void test_ctl_ring_after_a_clear_shows_only_new_samples(void)
{
    push_up_to(7);
    ctl_ring_clear(&ring);

    ctl_ring_push(&ring, num_of(20.0));

    ASSERT_NUM_WITHIN(0.0, 20.0, ctl_ring_get(&ring, 0U));
    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_ring_get(&ring, 1U));
    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_ring_get(&ring, CAPACITY - 1U));
}

void test_ctl_ring_set_changes_one_sample_only(void)
{
    push_up_to(8);

    ctl_ring_set(&ring, 2U, num_of(-1.0));

    ASSERT_NUM_WITHIN(0.0, 8.0, ctl_ring_get(&ring, 0U));
    ASSERT_NUM_WITHIN(0.0, 7.0, ctl_ring_get(&ring, 1U));
    ASSERT_NUM_WITHIN(0.0, -1.0, ctl_ring_get(&ring, 2U));
    ASSERT_NUM_WITHIN(0.0, 5.0, ctl_ring_get(&ring, 3U));
    ASSERT_NUM_WITHIN(0.0, 4.0, ctl_ring_get(&ring, 4U));
}

void test_ctl_ring_set_of_a_cleared_sample_makes_the_younger_ones_zero(void)
{
    push_up_to(8);
    ctl_ring_clear(&ring);

    ctl_ring_set(&ring, 3U, num_of(-1.0));

    for (uint16_t delay = 0; delay < CAPACITY; delay++) {
        ASSERT_NUM_WITHIN_AT(0.0, (delay == 3U) ? -1.0 : 0.0, ctl_ring_get(&ring, delay), at("delay %u", delay));
    }
}

void test_ctl_ring_set_before_the_first_push_moves_along_with_the_pushes(void)
{
    ctl_ring_set(&ring, 1U, num_of(-1.0));

    push_up_to(2);

    ASSERT_NUM_WITHIN(0.0, 2.0, ctl_ring_get(&ring, 0U));
    ASSERT_NUM_WITHIN(0.0, 1.0, ctl_ring_get(&ring, 1U));
    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_ring_get(&ring, 2U));
    ASSERT_NUM_WITHIN(0.0, -1.0, ctl_ring_get(&ring, 3U));
}

void test_ctl_ring_set_beyond_the_capacity_changes_nothing(void)
{
    push_up_to(2);
    const ctl_ring_t before = ring;

    ctl_ring_set(&ring, CAPACITY, num_of(-1.0));
    ctl_ring_set(&ring, UINT16_MAX, num_of(-1.0));

    ASSERT_SAME_BITS(before, ring);
    ASSERT_NUM_WITHIN(0.0, 2.0, ctl_ring_get(&ring, 0U));
    ASSERT_NUM_WITHIN(0.0, 1.0, ctl_ring_get(&ring, 1U));
}

void test_ctl_ring_of_any_length_agrees_with_a_plain_list(void)
{
    static num_t store[8];
    double       list[64] = {0.0}; /* newest first, as long as a sample can matter */
    noise_t      noise = {8U};
    for (uint16_t capacity = 2U; capacity <= COUNT_OF(store); capacity++) {
        TEST_ASSERT_EQUAL(CTL_OK, ctl_ring_init(&ring, store, capacity).status);
        memset(list, 0, sizeof list);
        for (uint32_t turn = 0; turn < 400U; turn++) {
            const double   x = noise_next(&noise);
            const uint16_t delay = (uint16_t)noise_pick(&noise, capacity);
            switch (noise_pick(&noise, 8U)) {
            case 0:
                ctl_ring_set(&ring, delay, num_of(x));
                list[delay] = x;
                break;
            case 1:
                if (noise_pick(&noise, 8U) == 0U) {
                    ctl_ring_clear(&ring);
                    memset(list, 0, sizeof list);
                }
                break;
            default:
                ctl_ring_push(&ring, num_of(x));
                memmove(&list[1], &list[0], sizeof list - sizeof list[0]);
                list[0] = x;
                list[capacity] = 0.0;
                break;
            }
            for (uint16_t d = 0; d < capacity; d++) {
                ASSERT_NUM_WITHIN_AT(0.0, list[d], ctl_ring_get(&ring, d),
                                     at("capacity %u, turn %u, delay %u", capacity, turn, d));
            }
        }
    }
    TEST_ASSERT_EQUAL(CTL_OK, ctl_ring_init(&ring, memory, CAPACITY).status);
}

void test_ctl_ring_init_without_a_pointer_names_it(void)
{
    const ctl_ring_t before = ring;

    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_ring_init(NULL, memory, CAPACITY));
    ASSERT_DIAG(CTL_ERR_NULL, CTL_RING_MEMORY, 0.0, ctl_ring_init(&ring, NULL, CAPACITY));
    ASSERT_SAME_BITS(before, ring);
}

void test_ctl_ring_init_rejects_a_capacity_out_of_range(void)
{
    static const uint16_t WRONG[] = {0U, 1U, 32768U, UINT16_MAX};
    const ctl_ring_t      before = ring;
    for (size_t i = 0; i < COUNT_OF(WRONG); i++) {
        const ctl_diag_t got = ctl_ring_init(&ring, memory, WRONG[i]);

        TEST_ASSERT_EQUAL(CTL_ERR_MEMORY, got.status);
        TEST_ASSERT_EQUAL_UINT16(CTL_RING_CAPACITY, got.field);
        ASSERT_NUM_WITHIN(FIXED_STEP, fmin(fmin(WRONG[i], 32767.0), num_max_value()), got.given);
        ASSERT_SAME_BITS(before, ring);
    }
}

void test_ctl_ring_init_does_not_rely_on_what_was_there(void)
{
    memset(&ring, 0xA5, sizeof ring);

    TEST_ASSERT_EQUAL(CTL_OK, ctl_ring_init(&ring, memory, CAPACITY).status);
    TEST_ASSERT_LESS_THAN_UINT16(CAPACITY, ring.head); /* a set before the first push writes there */
    push_up_to(2);

    ASSERT_NUM_WITHIN(0.0, 2.0, ctl_ring_get(&ring, 0U));
    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_ring_get(&ring, 2U));
}

void test_ctl_ring_init_takes_the_ends_of_the_range(void)
{
    static num_t large[32767];

    TEST_ASSERT_EQUAL(CTL_OK, ctl_ring_init(&ring, memory, 2U).status);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_ring_init(&ring, large, 32767U).status);
    for (uint32_t i = 0; i < 40000U; i++) { /* head + 1 and head + capacity pass 2^15 and 2^16 */
        ctl_ring_push(&ring, num_of((double)(i % 101U)));
    }
    ASSERT_NUM_WITHIN(0.0, (double)((40000U - 1U - 32766U) % 101U), ctl_ring_get(&ring, 32766U));
    TEST_ASSERT_EQUAL(CTL_OK, ctl_ring_init(&ring, memory, CAPACITY).status);
}

/* ---- full from the start --------------------------------------------------------------------------------------------- */

void test_ctl_ring_filled_with_zeros_is_valid_everywhere_and_stays_within_its_memory(void)
{
    push_up_to(2);
    ctl_ring_fill_zero(&ring);

    TEST_ASSERT_EQUAL_UINT16(CAPACITY, ring.filled);
    for (uint16_t d = 0; d < CAPACITY; d++) {
        ASSERT_NUM_WITHIN(0.0, 0.0, memory[d]);
    }
    for (int k = 1; k <= 12; k++) {
        ctl_ring_push_full(&ring, num_of(k));
        for (uint16_t d = 0; d < CAPACITY; d++) {
            const double want = (k > d) ? (double)(k - d) : 0.0;
            ASSERT_NUM_WITHIN_AT(0.0, want, ctl_ring_get(&ring, d), at("push %d, delay %u", k, d));
            ASSERT_NUM_WITHIN_AT(0.0, want, memory[ctl_ring_place(&ring, d)], at("push %d, place of delay %u", k, d));
        }
    }
}
