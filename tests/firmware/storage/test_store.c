/* firmware/storage: the old set or the new one, never a mix, wherever the power goes, in a flash that shows what was cut one way
 * or the other at every read. What was saved is known here by its numbers alone. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "firmware/storage/format.h"
#include "mock_hal_storage.h"
#include "tests/firmware/support/flash.h"
#include "unity.h"

#define P_WORDS 21U /* not whole blocks */
#define T_WORDS 34U
#define TAG 0x12345678U
#define SET_WORDS (8U + 24U + 36U + 12U)
#define SET_BLOCKS ((int32_t)(SET_WORDS / 4U))

static store_t  store;
static uint16_t given[64]; /* [0] counts the parts that were saved */
static uint16_t taken[64];

static uint16_t give(const void *from, uint16_t i) { return ((const uint16_t *)from)[i]; }
static void     take(void *to, uint16_t i, uint16_t word) { ((uint16_t *)to)[i] = word; }

/* Every word of one number differs from that of another. */
static void fill(uint16_t *words, uint16_t number, uint16_t salt)
{
    for (uint16_t i = 0U; i < 64U; i++) {
        words[i] = (uint16_t)((number * 40503U) + (i * 7919U) + salt);
    }
}

static uint16_t words_of(store_part_t part) { return (part == STORE_TABLE) ? T_WORDS : P_WORDS; }

static hal_status_t save(store_part_t part, uint16_t number)
{
    fill(given, number, (uint16_t)part);
    hal_status_t s = store_begin(&store, part, TAG, words_of(part), give, given);
    for (uint16_t k = 0U; (k < 200U) && (s == HAL_OK) && store.active; k++) {
        s = store_step(&store);
    }
    return s;
}

static hal_status_t load(store_part_t part) { return store_load(&store, part, TAG, words_of(part), take, taken); }

/* Which of two numbers is stored; UINT16_MAX: neither. */
static uint16_t stored(store_part_t part, uint16_t older, uint16_t newer)
{
    uint16_t want[64];
    if (load(part) != HAL_OK) {
        return UINT16_MAX;
    }
    fill(want, newer, (uint16_t)part);
    if (memcmp(want, taken, words_of(part) * sizeof want[0]) == 0) {
        return newer;
    }
    fill(want, older, (uint16_t)part);
    return (memcmp(want, taken, words_of(part) * sizeof want[0]) == 0) ? older : UINT16_MAX;
}

static void power_up(void)
{
    flash_power_up();
    store_reset(&store);
}

void setUp(void)
{
    flash_start();
    store_reset(&store);
}

void tearDown(void) {}

static unsigned trials(unsigned nominal, unsigned all) { return (getenv("EVENSPIN_CAMPAIGN") != NULL) ? all : nominal; }

void test_store_gives_back_what_was_saved_and_keeps_the_other_part(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_STALE, load(STORE_PARAMETERS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
    TEST_ASSERT_EQUAL_INT(HAL_STALE, load(STORE_TABLE));
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_TABLE, 2U));
    power_up();
    TEST_ASSERT_EQUAL_UINT16(1U, stored(STORE_PARAMETERS, 9U, 1U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 3U));
    power_up();
    TEST_ASSERT_EQUAL_UINT16(3U, stored(STORE_PARAMETERS, 1U, 3U));
    TEST_ASSERT_EQUAL_UINT16(2U, stored(STORE_TABLE, 9U, 2U));
}

void test_store_does_not_know_a_set_of_another_tag_or_size(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
    TEST_ASSERT_EQUAL_INT(HAL_STALE, store_load(&store, STORE_PARAMETERS, TAG ^ 0x10000U, P_WORDS, take, taken));
    TEST_ASSERT_EQUAL_INT(HAL_STALE, store_load(&store, STORE_PARAMETERS, TAG, P_WORDS + 1U, take, taken));
}

void test_store_without_room_or_a_second_page_touches_nothing(void)
{
    flash.pages = 1U;
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, save(STORE_PARAMETERS, 1U));
    flash.pages = 2U;
    flash.page_words = 4U + 8U + 24U + 12U - 4U;
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, save(STORE_PARAMETERS, 1U));
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, load(STORE_PARAMETERS));
    TEST_ASSERT_EQUAL_UINT32(0U, flash.changes);
    flash.page_words += 4U;
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
}

void test_store_second_save_or_a_load_during_a_save_is_refused(void)
{
    fill(given, 1U, 0U);
    TEST_ASSERT_EQUAL_INT(HAL_OK, store_begin(&store, STORE_TABLE, 0U, T_WORDS, give, given));
    TEST_ASSERT_EQUAL_INT(HAL_BUSY, store_begin(&store, STORE_PARAMETERS, TAG, P_WORDS, give, given));
    TEST_ASSERT_EQUAL_INT(HAL_BUSY, load(STORE_PARAMETERS));
}

void test_store_wears_its_pages_evenly_and_counts_the_erases(void)
{
    for (uint16_t k = 0U; k < 600U; k++) {
        TEST_ASSERT_EQUAL_INT(HAL_OK, save(((k % 3U) == 0U) ? STORE_TABLE : STORE_PARAMETERS, k));
        if ((k % 7U) == 0U) {
            power_up();
        }
    }
    uint32_t least = UINT32_MAX;
    uint32_t most = 0U;
    for (uint16_t page = 0U; page < FLASH_PAGES; page++) {
        least = (flash.cells.erased[page] < least) ? flash.cells.erased[page] : least;
        most = (flash.cells.erased[page] > most) ? flash.cells.erased[page] : most;
    }
    TEST_ASSERT_TRUE((most - least) <= 1U);
    TEST_ASSERT_TRUE(most < 60U); /* 600 saves: 12 sets of a page, and a fresh page after each power-up */
    TEST_ASSERT_UINT32_WITHIN(FLASH_PAGES * most, FLASH_PAGES * most, store.erases + 1U);
    TEST_ASSERT_TRUE(store.erases >= most);
}

/* ---- the power goes -------------------------------------------------------------------------------------------------------- */

static uint16_t first_used_page(void)
{
    uint16_t page = 0U;
    while ((page < (FLASH_PAGES - 1U)) && (flash.cells.erased[page] == 0U)) {
        page++;
    }
    return page;
}

/* Before, within and after every block and erase of a save, with the new set behind the old one and in a fresh page; and the
 * power goes again, at every place, in the save that comes next. Each is read several times: cut cells differ each time. */
static void cut_everywhere(bool fresh_page, bool ecc, unsigned seed)
{
    static flash_cells_t before, after_cut;
    flash_start();
    flash.chance = seed;
    flash.ecc = ecc;
    store_reset(&store);
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_TABLE, 50U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
    if (fresh_page) {
        power_up();
    }
    before = flash.cells;
    const store_t ready = store;
    const int32_t changes = SET_BLOCKS + (fresh_page ? 2 : 0); /* the erase, and the block of the page */
    for (int32_t cut = 0; cut <= changes; cut++) {
        for (unsigned torn = 0U; torn < 2U; torn++) {
            flash.cells = before;
            store = ready;
            flash.until_power_fails = cut;
            flash.torn = torn != 0U;
            (void)save(STORE_PARAMETERS, 2U);
            power_up();
            after_cut = flash.cells;
            uint16_t first = 0U;
            for (int32_t second = -1; second <= (changes + 3); second += ((seed % 2U) == 0U) ? 3 : 4) {
                flash.cells = after_cut;
                power_up();
                first = stored(STORE_PARAMETERS, 1U, 2U);
                TEST_ASSERT_TRUE_MESSAGE(first != UINT16_MAX, "neither the old set nor the new one");
                TEST_ASSERT_TRUE_MESSAGE((cut < (changes - 1)) ? (first == 1U) : true, "a set that was not committed");
                TEST_ASSERT_TRUE_MESSAGE((cut == changes) ? (first == 2U) : true, "a save that was finished is gone");
                TEST_ASSERT_EQUAL_UINT16_MESSAGE(50U, stored(STORE_TABLE, 99U, 50U), "the other part");
                TEST_ASSERT_EQUAL_UINT16_MESSAGE(first, stored(STORE_PARAMETERS, 1U, 2U), "it does not stay what it was");
                flash.until_power_fails = second;
                flash.torn = true;
                (void)save(STORE_PARAMETERS, 3U);
                power_up();
                for (unsigned again = 0U; again < 2U; again++) {
                    const uint16_t now = stored(STORE_PARAMETERS, first, 3U);
                    TEST_ASSERT_TRUE_MESSAGE(now != UINT16_MAX, "after the second cut");
                    TEST_ASSERT_EQUAL_UINT16_MESSAGE(50U, stored(STORE_TABLE, 99U, 50U), "the other part, after the second cut");
                }
                TEST_ASSERT_EQUAL_INT_MESSAGE(HAL_OK, save(STORE_PARAMETERS, 4U), "saving works again");
                TEST_ASSERT_EQUAL_UINT16(4U, stored(STORE_PARAMETERS, 3U, 4U));
            }
        }
    }
}

void test_store_power_cut_anywhere_and_again_in_the_next_save_leaves_the_old_or_the_new_set(void)
{
    const unsigned all = trials(1U, 30U);
    for (unsigned seed = 1U; seed <= all; seed++) {
        cut_everywhere(false, (seed % 2U) == 0U, seed);
        cut_everywhere(true, (seed % 2U) == 1U, seed);
    }
}

void test_store_first_save_that_was_cut_leaves_nothing_and_the_next_one_works(void)
{
    for (int32_t cut = 0; cut < SET_BLOCKS; cut++) {
        setUp();
        flash.until_power_fails = cut;
        flash.torn = true;
        (void)save(STORE_PARAMETERS, 1U);
        power_up();
        const uint16_t found = stored(STORE_PARAMETERS, 1U, 1U);
        TEST_ASSERT_TRUE((found == UINT16_MAX) || (cut >= (int32_t)(1 + 1 + (8 + 24 + 4) / 4))); /* erase, page, body */
        TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 2U));
        TEST_ASSERT_EQUAL_UINT16(2U, stored(STORE_PARAMETERS, 1U, 2U));
    }
}

/* A commit of which one bit hangs between: once it has read right, it stays the one that counts. */
void test_store_set_that_was_taken_once_stays_the_newest_although_its_commit_was_cut(void)
{
    unsigned seen = 0U;
    for (uint16_t bit = 0U; bit < 64U; bit++) {
        setUp();
        flash.chance = bit;
        TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
        power_up();
        flash.until_power_fails = 2 + ((8 + 24 + 4) / 4); /* erase, block of the page, head to trailer: then the commit */
        flash.torn = true;
        (void)save(STORE_PARAMETERS, 2U);
        power_up();
        const uint16_t commit = 4U + 8U + 24U + 4U;
        for (uint16_t i = 0U; i < 4U; i++) {
            flash.cells.word[1][commit + i] = flash.cells.meant[1][commit + i];
            flash.cells.unsure[1][commit + i] = (i == (bit / 16U)) ? (uint16_t)(1U << (bit % 16U)) : 0U;
        }
        bool taken_once = false;
        for (unsigned k = 0U; k < 20U; k++) {
            power_up();
            const uint16_t now = stored(STORE_PARAMETERS, 1U, 2U);
            TEST_ASSERT_TRUE((now == 2U) || ((now == 1U) && !taken_once));
            taken_once = now == 2U;
        }
        seen += taken_once ? 1U : 0U;
    }
    TEST_ASSERT_TRUE(seen > 50U);
}

/* A life: saves of both parts, the power goes at any change of some of them, and comes back to a load. */
void test_store_a_thousand_saves_with_cuts_are_each_the_old_or_the_new_set(void)
{
    uint16_t       last[STORE_PARTS] = {1U, 1U};
    unsigned       cuts = 0U;
    unsigned       kept = 0U;
    const unsigned all = trials(1000U, 20000U);
    flash.ecc = true;
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_TABLE, 1U));
    for (unsigned k = 2U; k < (all + 2U); k++) {
        const store_part_t part = (flash_pick(3U) == 0U) ? STORE_TABLE : STORE_PARAMETERS;
        const bool         cut = flash_pick(2U) == 0U;
        if (cut) {
            flash.until_power_fails = (int32_t)flash_pick((uint32_t)SET_BLOCKS + 4U);
            flash.torn = flash_pick(4U) != 0U;
        }
        const bool     finished = (save(part, (uint16_t)k) == HAL_OK) && (flash.until_power_fails != 0);
        const bool     dark = flash.until_power_fails == 0;
        const uint16_t older = last[part];
        if (cut || (flash_pick(5U) == 0U)) {
            power_up();
        }
        const uint16_t now = stored(part, older, (uint16_t)k);
        TEST_ASSERT_TRUE_MESSAGE(now != UINT16_MAX, "neither the old set nor the new one");
        TEST_ASSERT_TRUE_MESSAGE(dark || (finished && (now == (uint16_t)k)), "a finished save is gone");
        cuts += dark ? 1U : 0U;
        kept += (dark && (now == older)) ? 1U : 0U;
        last[part] = now;
        for (uint16_t p = 0U; p < (uint16_t)STORE_PARTS; p++) {
            TEST_ASSERT_EQUAL_UINT16_MESSAGE(last[p], stored((store_part_t)p, UINT16_MAX - 1U, last[p]), "the other part");
        }
    }
    (void)printf("%u saves, %u cut, %u of these left the old set\n", all, cuts, kept);
    TEST_ASSERT_TRUE((cuts > (all / 4U)) && (kept > (cuts / 2U)) && (kept < cuts));
}

/* ---- cells that do not keep or do not show what was written ---------------------------------------------------------------- */

void test_store_one_wrong_bit_anywhere_in_the_newest_set_makes_the_older_one_count(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 2U));
    const uint16_t length = 8U + 24U + 12U;
    for (uint16_t word = 4U + length; word < (4U + (2U * length)); word++) {
        const uint16_t in_set = (uint16_t)(word - 4U - length);
        const bool     padding = (in_set >= (8U + P_WORDS)) && (in_set < (8U + 24U));
        const bool     twice = in_set >= (length - 8U); /* commit and confirm stand for each other */
        for (uint16_t bit = 0U; bit < 16U; bit++) {
            flash.cells.word[0][word] ^= (uint16_t)(1U << bit);
            TEST_ASSERT_EQUAL_UINT16((padding || twice) ? 2U : 1U, stored(STORE_PARAMETERS, 1U, 2U));
            flash.cells.word[0][word] ^= (uint16_t)(1U << bit);
        }
    }
}

/* Any bit of any word that the save writes. "Saved" means that the set can be read again. */
void test_store_save_into_a_cell_that_is_stuck_is_not_called_a_save(void)
{
    unsigned       saved = 0U;
    unsigned       wrong = 0U;
    const unsigned all = trials(500U, 5000U);
    for (unsigned k = 0U; k < all; k++) {
        setUp();
        flash.chance = k;
        TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_TABLE, 5U));
        TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
        power_up();
        flash.odd_page = 1U;
        flash.odd_word = (uint16_t)flash_pick(4U + SET_WORDS);
        flash.stuck = (uint16_t)(1U << flash_pick(16U));
        const bool ok = save(STORE_PARAMETERS, (uint16_t)(2U + flash_pick(1000U))) == HAL_OK;
        uint16_t   want[64];
        fill(want, 1U, (uint16_t)STORE_PARAMETERS);
        const hal_status_t found = load(STORE_PARAMETERS);
        saved += ok ? 1U : 0U;
        wrong += ((found == HAL_OK) && (memcmp(ok ? given : want, taken, P_WORDS * sizeof want[0]) == 0)) ? 0U : 1U;
        wrong += (stored(STORE_TABLE, 99U, 5U) == 5U) ? 0U : 1U;
        if (!ok) { /* and the next attempt goes elsewhere */
            TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 3U));
        }
    }
    (void)printf("stuck bit: %u of %u saves called saved, %u of these or of the older sets not to be read again\n", saved, all,
                 wrong);
    TEST_ASSERT_EQUAL_UINT32(0U, wrong);
    TEST_ASSERT_TRUE((saved > (all / 4U)) && (saved < all));
}

void test_store_load_from_a_cell_that_is_unsteady_takes_a_set_that_was_saved(void)
{
    unsigned       never = 0U;
    unsigned       newest = 0U;
    const unsigned all = trials(2000U, 20000U);
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 2U));
    for (unsigned k = 0U; k < all; k++) {
        flash.odd_page = 0U;
        flash.odd_word = (uint16_t)flash_pick(4U + (2U * (8U + 24U + 12U)));
        flash.unsteady = (uint16_t)(1U << flash_pick(16U));
        store_reset(&store);
        const hal_status_t found = load(STORE_PARAMETERS);
        uint16_t           want[2][64];
        fill(want[0], 1U, (uint16_t)STORE_PARAMETERS);
        fill(want[1], 2U, (uint16_t)STORE_PARAMETERS);
        if (found == HAL_OK) {
            const bool is[2] = {memcmp(want[0], taken, P_WORDS * sizeof taken[0]) == 0,
                                memcmp(want[1], taken, P_WORDS * sizeof taken[0]) == 0};
            newest += is[1] ? 1U : 0U;
            never += (is[0] || is[1]) ? 0U : 1U;
        }
    }
    (void)printf("unsteady bit: %u of %u power-ups took a set that was never saved, %u the newest\n", never, all, newest);
    TEST_ASSERT_EQUAL_UINT32(0U, never);
    TEST_ASSERT_TRUE(newest > (all - (all / 5U)));
}

/* What is copied from the older set into the new one is checked, too. */
void test_store_an_unsteady_cell_of_the_other_part_is_not_copied_as_if_it_were_right(void)
{
    unsigned       wrong = 0U;
    const unsigned all = trials(500U, 5000U);
    for (unsigned k = 0U; k < all; k++) {
        setUp();
        flash.chance = k;
        TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_TABLE, 5U));
        power_up();
        flash.odd_page = 0U;
        flash.odd_word = (uint16_t)(4U + 8U + flash_pick(T_WORDS));
        flash.unsteady = (uint16_t)(1U << flash_pick(16U));
        (void)save(STORE_PARAMETERS, 7U);
        flash.unsteady = 0U;
        const hal_status_t found = load(STORE_TABLE);
        uint16_t           want[64];
        fill(want, 5U, (uint16_t)STORE_TABLE);
        wrong += ((found == HAL_OK) && (memcmp(want, taken, T_WORDS * sizeof want[0]) != 0)) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL_UINT32(0U, wrong);
}

void test_store_storage_that_refuses_ends_the_save_and_keeps_the_old_set(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
    for (int32_t n = 0; n < 11; n++) {
        flash.changes = 0U;
        flash.until_error = n;
        TEST_ASSERT_EQUAL_INT(HAL_BUSY, save(STORE_PARAMETERS, 2U));
        TEST_ASSERT_FALSE(store.active);
        TEST_ASSERT_EQUAL_UINT16(1U, stored(STORE_PARAMETERS, 1U, 2U));
    }
}

void test_store_a_step_writes_few_blocks(void)
{
    fill(given, 1U, 0U);
    TEST_ASSERT_EQUAL_INT(HAL_OK, store_begin(&store, STORE_PARAMETERS, TAG, P_WORDS, give, given));
    TEST_ASSERT_EQUAL_UINT32(0U, flash.changes);
    while (store.active) {
        const uint32_t before = flash.changes;
        TEST_ASSERT_EQUAL_INT(HAL_OK, store_step(&store));
        TEST_ASSERT_TRUE((flash.changes - before) <= STORE_BLOCKS_PER_STEP);
    }
}

/* ---- reads fail ------------------------------------------------------------------------------------------------------------- */

static void two_sets(void)
{
    setUp();
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_TABLE, 50U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 2U));
}

/* One read in the middle of everything that fails, with any words, and not again: each is tried again. */
void test_store_one_failed_read_anywhere_costs_no_set_when_loading(void)
{
    two_sets();
    const uint32_t before = flash.reads;
    TEST_ASSERT_EQUAL_UINT16(2U, stored(STORE_PARAMETERS, 1U, 2U));
    const uint32_t all = flash.reads - before;
    TEST_ASSERT_TRUE(all > 30U);
    for (uint32_t k = 0U; k < all; k++) {
        flash.bad_read = (int32_t)(flash.reads + k);
        TEST_ASSERT_EQUAL_UINT16(2U, stored(STORE_PARAMETERS, 1U, 2U));
        TEST_ASSERT_TRUE(flash.reads > (uint32_t)flash.bad_read);
    }
}

/* The save is done or says that it failed, and what is stored is then the new or the old set; the other part stays. */
void test_store_one_failed_read_anywhere_in_a_save_leaves_the_new_set_or_the_old_one_and_says_which(void)
{
    static flash_cells_t before;
    two_sets();
    before = flash.cells;
    const store_t  ready = store;
    const uint32_t from = flash.reads;
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 3U));
    const uint32_t all = flash.reads - from;
    unsigned       failed = 0U;
    for (uint32_t k = 0U; k < all; k++) {
        flash.cells = before;
        store = ready;
        flash.bad_read = (int32_t)(flash.reads + k);
        const hal_status_t done = save(STORE_PARAMETERS, 3U);
        failed += (done != HAL_OK) ? 1U : 0U;
        flash.bad_read = -1;
        power_up();
        const uint16_t now = stored(STORE_PARAMETERS, 2U, 3U);
        TEST_ASSERT_TRUE_MESSAGE(now != UINT16_MAX, "neither the old set nor the new one");
        TEST_ASSERT_TRUE_MESSAGE((done != HAL_OK) || (now == 3U), "a save that was said to be done is not there");
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(50U, stored(STORE_TABLE, 99U, 50U), "the other part");
        TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 4U));
        TEST_ASSERT_EQUAL_UINT16(4U, stored(STORE_PARAMETERS, 3U, 4U));
    }
    TEST_ASSERT_TRUE_MESSAGE(failed > 0U, "no read of a save counts");
}

/* A block that can never be read again, anywhere in the storage: the newest set that reads whole, or a refusal; never a mix. And a
 * save goes elsewhere. */
void test_store_a_block_that_cannot_be_read_any_more_costs_a_set_at_the_most(void)
{
    static flash_cells_t before;
    two_sets();
    before = flash.cells;
    for (int32_t block = 0; block < (int32_t)(FLASH_PAGES * FLASH_BLOCKS); block++) {
        flash.cells = before;
        power_up();
        flash.dead_block = block;
        const uint16_t now = stored(STORE_PARAMETERS, 1U, 2U);
        TEST_ASSERT_TRUE_MESSAGE(now != UINT16_MAX, "both sets lost with one block");
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(50U, stored(STORE_TABLE, 99U, 50U), "the other part stands in three sets");
        TEST_ASSERT_TRUE((save(STORE_PARAMETERS, 3U) == HAL_OK) || (save(STORE_PARAMETERS, 3U) == HAL_OK));
        TEST_ASSERT_EQUAL_UINT16(3U, stored(STORE_PARAMETERS, 2U, 3U));
        flash.dead_block = -1;
    }
}

/* ---- a commit with a bit that reads 0 or 1 ------------------------------------------------------------------------------------ */

/* In page 0: its block, a set of the table alone, one of both parts, and the one in whose commit the power went. */
#define COMMIT_AT (4U + (8U + 36U + 12U) + SET_WORDS + SET_WORDS - 8U)

/* The commit of set 2 has all but one cell, which reads 0 or 1. */
static void cut_in_the_commit(uint32_t seed)
{
    setUp();
    flash.chance = seed;
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_TABLE, 50U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
    flash.until_power_fails = SET_BLOCKS - 2; /* all but commit and confirm */
    flash.torn = true;
    (void)save(STORE_PARAMETERS, 2U);
    power_up();
    for (uint16_t i = 0U; i < 4U; i++) {
        flash.cells.word[0][COMMIT_AT + i] = flash.cells.meant[0][COMMIT_AT + i];
        flash.cells.unsure[0][COMMIT_AT + i] = 0U;
    }
    TEST_ASSERT_EQUAL_HEX16_MESSAGE(0xE5C3U, flash.cells.word[0][COMMIT_AT], "the magic number of a commit");
    flash.cells.unsure[0][COMMIT_AT] = 4U;
}

/* From now on it never reads as committed. */
static void lose_the_commit(void)
{
    for (uint16_t i = 0U; i < 4U; i++) {
        flash.cells.word[0][COMMIT_AT + i] = 0U;
        flash.cells.unsure[0][COMMIT_AT + i] = 0U;
    }
}

void test_store_a_set_that_was_loaded_is_the_one_at_the_next_power_up_whatever_its_commit_reads(void)
{
    unsigned seen = 0U;
    for (uint32_t seed = 1U; seed <= 60U; seed++) {
        cut_in_the_commit(seed);
        if (stored(STORE_PARAMETERS, 1U, 2U) == 2U) {
            seen++;
            lose_the_commit();
            power_up();
            TEST_ASSERT_EQUAL_UINT16(2U, stored(STORE_PARAMETERS, 1U, 2U));
        }
    }
    TEST_ASSERT_TRUE_MESSAGE(seen >= 20U, "a commit that was cut has to read as one now and then");
}

void test_store_a_set_that_a_save_has_copied_from_is_the_one_at_the_next_power_up(void)
{
    unsigned seen = 0U;
    for (uint32_t seed = 1U; seed <= 60U; seed++) {
        cut_in_the_commit(seed);
        fill(given, 51U, (uint16_t)STORE_TABLE);
        TEST_ASSERT_EQUAL_INT(HAL_OK, store_begin(&store, STORE_TABLE, 0U, T_WORDS, give, given));
        if (store.source.at == (uint16_t)(COMMIT_AT + 8U - SET_WORDS)) {
            seen++;
            lose_the_commit();
            power_up(); /* and the save never got any further */
            TEST_ASSERT_EQUAL_UINT16(2U, stored(STORE_PARAMETERS, 1U, 2U));
        }
    }
    TEST_ASSERT_TRUE_MESSAGE(seen >= 20U, "a commit that was cut has to read as one now and then");
}

/* Also where nothing is copied from it, since its table does not read any more. */
void test_store_the_newest_set_is_made_sure_of_before_a_save_begins(void)
{
    unsigned stays = 0U;
    for (uint32_t seed = 1U; seed <= 60U; seed++) {
        cut_in_the_commit(seed);
        flash.cells.word[0][COMMIT_AT - 4U - 36U] ^= 1U;
        fill(given, 3U, (uint16_t)STORE_PARAMETERS);
        TEST_ASSERT_EQUAL_INT(HAL_OK, store_begin(&store, STORE_PARAMETERS, TAG, P_WORDS, give, given));
        lose_the_commit();
        power_up();
        stays += (stored(STORE_PARAMETERS, 1U, 2U) == 2U) ? 1U : 0U;
    }
    TEST_ASSERT_TRUE_MESSAGE(stays >= 40U, "of 60, and one of eight did not read as committed to begin with");
}

/* A set of an older program has to be found by a newer one: every word, by the format that store.h tells, made with long division in
 * Python. Page, a set of 5 words of parameters, a set that adds a table of 6, and what is still erased. */
void test_store_words_in_the_flash_are_those_of_the_format(void)
{
    static const uint16_t WORDS[] = {
        0xE5A6U, 0x0001U, 0x0000U, 0x3B64U, 0xE5B1U, 0x0001U, 0x0000U, 0x0005U, 0x0000U, 0x5678U, 0x1234U, 0x4F2FU,
        0xDAA5U, 0xF994U, 0x1883U, 0x3772U, 0x5661U, 0x0000U, 0x0000U, 0x0000U, 0xD97BU, 0xE87DU, 0x0000U, 0x0000U,
        0xE5C3U, 0x0001U, 0xBB69U, 0x909FU, 0xE5C3U, 0x0001U, 0xBB69U, 0x909FU, 0xE5B1U, 0x0002U, 0x0000U, 0x0005U,
        0x0006U, 0x5678U, 0x1234U, 0xA4CBU, 0xDAA5U, 0xF994U, 0x1883U, 0x3772U, 0x5661U, 0x0000U, 0x0000U, 0x0000U,
        0x78DDU, 0x97CCU, 0xB6BBU, 0xD5AAU, 0xF499U, 0x1388U, 0x0000U, 0x0000U, 0xD97BU, 0xE87DU, 0x4A5EU, 0x75E4U,
        0xE5C3U, 0x0002U, 0x50A0U, 0xA4EEU, 0xE5C3U, 0x0002U, 0x50A0U, 0xA4EEU, 0xFFFFU, 0xFFFFU, 0xFFFFU, 0xFFFFU};
    fill(given, 3U, 0U);
    TEST_ASSERT_EQUAL_INT(HAL_OK, store_begin(&store, STORE_PARAMETERS, TAG, 5U, give, given));
    while (store.active) {
        TEST_ASSERT_EQUAL_INT(HAL_OK, store_step(&store));
    }
    fill(given, 4U, 1U);
    TEST_ASSERT_EQUAL_INT(HAL_OK, store_begin(&store, STORE_TABLE, TAG, 6U, give, given));
    while (store.active) {
        TEST_ASSERT_EQUAL_INT(HAL_OK, store_step(&store));
    }
    const uint16_t page = first_used_page();
    for (uint16_t i = 0U; i < (uint16_t)(sizeof WORDS / sizeof WORDS[0]); i++) {
        char where[32];
        (void)snprintf(where, sizeof where, "word %u", (unsigned)i);
        TEST_ASSERT_EQUAL_HEX16_MESSAGE(WORDS[i], flash.cells.word[page][i], where);
    }
    TEST_ASSERT_EQUAL_INT(HAL_OK, store_load(&store, STORE_TABLE, TAG, 6U, take, taken));
}

/* Head and end of a set are read three times before they count as lost: blocks 1 and 17 of the page, by the format. */
void test_store_head_and_end_that_fail_twice_are_read_and_three_times_are_not(void)
{
    static const int32_t BLOCK_OF[2] = {1, (int32_t)((4U + 8U + 24U) / 4U)};
    for (int k = 0; k < 2; k++) {
        for (int32_t fails = 1; fails <= 3; fails++) {
            flash_start();
            store_reset(&store);
            TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 3U));
            const int32_t page = (int32_t)first_used_page();
            power_up();
            flash.dead_block = (page * (int32_t)FLASH_BLOCKS) + BLOCK_OF[k];
            flash.dead_reads = fails;
            TEST_ASSERT_EQUAL_INT((fails < 3) ? HAL_OK : HAL_STALE, load(STORE_PARAMETERS));
        }
    }
}

/* Of a head whose first word reads right every other time three reads find 7 of 8, one read 4. */
void test_store_head_that_is_unsteady_is_read_again(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 3U));
    const uint16_t page = first_used_page();
    flash.odd_page = page;
    flash.odd_word = 4U;
    flash.unsteady = 0x0002U;
    int found = 0;
    for (int k = 0; k < 400; k++) {
        store_reset(&store);
        found += (load(STORE_PARAMETERS) == HAL_OK) ? 1 : 0;
    }
    TEST_ASSERT_INT_WITHIN(40, 350, found); /* 7 of 8, and six times the deviation of 6.6 */
}

/* The first words in the flash as the next save would make them with this number. */
static store_set_t renumbered(uint32_t sequence)
{
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 3U));
    store_set_t set;
    TEST_ASSERT_TRUE(store_find(UINT32_MAX, NULL, NULL, &set).found);
    uint16_t *const words = flash.cells.word[set.page];
    const uint16_t  end = store_end_at(&set);
    const uint32_t  crc[STORE_PARTS] = {store_long(words[end], words[end + 1U]), store_long(words[end + 2U], words[end + 3U])};
    set.sequence = sequence;
    store_make_head(&words[set.at], &set);
    store_make_commit(&words[end + BLOCK], &set, crc);
    store_make_commit(&words[end + (2U * BLOCK)], &set, crc);
    return set;
}

/* A number whose lower half is all ones is not mistaken for erased words: with an unsteady check sum 7 of 8 as above. */
void test_store_head_that_is_unsteady_is_read_again_whatever_its_number(void)
{
    const store_set_t set = renumbered(0xFFFFU);
    flash.odd_page = set.page;
    flash.odd_word = (uint16_t)(set.at + 7U);
    flash.unsteady = 0x0002U;
    int found = 0;
    for (int k = 0; k < 400; k++) {
        store_reset(&store);
        found += (load(STORE_PARAMETERS) == HAL_OK) ? 1 : 0;
    }
    TEST_ASSERT_INT_WITHIN(40, 350, found);
}

/* ---- the confirm of a set that was read as committed once: 20 times three reads of its end before it is given up --------------- */

/* A saved set as it would be without its confirm, or with another one. */
static store_set_t with_confirm(const uint16_t confirm[BLOCK])
{
    const store_set_t set = renumbered(7U);
    const uint16_t    at = (uint16_t)(store_end_at(&set) + (2U * BLOCK));
    (void)memcpy(&flash.cells.word[set.page][at], confirm, BLOCK * sizeof confirm[0]);
    flash.cells.state[set.page][at / BLOCK] = (confirm[0] == UINT16_MAX) ? 0U : 1U;
    return set;
}

static const uint16_t NO_CONFIRM[BLOCK] = {UINT16_MAX, UINT16_MAX, UINT16_MAX, UINT16_MAX};

void test_store_settle_confirms_a_set_whose_end_reads_at_the_sixtieth_time_and_gives_up_then(void)
{
    for (int32_t fails = 59; fails <= 60; fails++) {
        setUp();
        const store_set_t set = with_confirm(NO_CONFIRM);
        const uint16_t    end = store_end_at(&set);
        flash.dead_block = (int32_t)((set.page * FLASH_BLOCKS) + (end / BLOCK));
        flash.dead_reads = fails;
        const uint32_t before = flash.changes;
        TEST_ASSERT_EQUAL_INT(HAL_OK, store_settle(&set));
        TEST_ASSERT_EQUAL_UINT32(before + ((fails < 60) ? 1U : 0U), flash.changes);
        const uint16_t *const words = flash.cells.word[set.page];
        TEST_ASSERT_EQUAL_HEX16_ARRAY((fails < 60) ? &words[end + BLOCK] : NO_CONFIRM, &words[end + (2U * BLOCK)], BLOCK);
    }
}

void test_store_settle_confirms_no_set_that_is_not_committed_and_writes_over_no_words(void)
{
    static const uint16_t OTHER[BLOCK] = {0xE5C3U, 0x0007U, 0x0000U, 0x0000U};
    store_set_t           set = with_confirm(NO_CONFIRM);
    flash.cells.word[set.page][store_end_at(&set) + BLOCK] ^= 1U;
    uint32_t before = flash.changes;
    TEST_ASSERT_EQUAL_INT(HAL_OK, store_settle(&set));
    TEST_ASSERT_EQUAL_UINT32(before, flash.changes);
    setUp();
    set = with_confirm(OTHER);
    before = flash.changes;
    TEST_ASSERT_EQUAL_INT(HAL_OK, store_settle(&set));
    TEST_ASSERT_EQUAL_UINT32(before, flash.changes);
}

/* Wherever a set could begin, erased words show in one read that none does. */
void test_store_erased_storage_is_seen_in_few_reads(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_STALE, load(STORE_PARAMETERS));
    const uint32_t reads = flash.reads;
    TEST_ASSERT_TRUE_MESSAGE(reads <= (FLASH_PAGES * FLASH_BLOCKS), "more than one read of a block");
}

/* A part is read three times as well: block 3 is its first. */
void test_store_part_that_fails_twice_is_read_and_three_times_is_not(void)
{
    for (int32_t fails = 1; fails <= 3; fails++) {
        flash_start();
        store_reset(&store);
        TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 3U));
        const int32_t page = (int32_t)first_used_page();
        power_up();
        flash.dead_block = (page * (int32_t)FLASH_BLOCKS) + 3;
        flash.dead_reads = fails;
        TEST_ASSERT_EQUAL_INT((fails < 3) ? HAL_OK : HAL_SENSOR_FAULT, load(STORE_PARAMETERS));
    }
}

/* A page of exactly its block, head, 24 words and end; and one of two such sets. */
void test_store_set_that_just_fits_its_page_is_saved_and_loaded(void)
{
    static const store_part_t PART[2] = {STORE_PARAMETERS, STORE_TABLE};
    for (int k = 0; k < 2; k++) {
        for (uint16_t sets = 1U; sets <= 2U; sets++) {
            flash_start();
            store_reset(&store);
            flash.page_words = (uint16_t)(4U + (sets * (8U + 24U + 12U)));
            for (uint16_t n = 0U; n < sets; n++) {
                fill(given, n, 0U);
                TEST_ASSERT_EQUAL_INT(HAL_OK, store_begin(&store, PART[k], TAG, 24U, give, given));
                while (store.active) {
                    TEST_ASSERT_EQUAL_INT(HAL_OK, store_step(&store));
                }
            }
            TEST_ASSERT_EQUAL_UINT32(1U, flash.cells.erased[0] + flash.cells.erased[1] + flash.cells.erased[2]);
            TEST_ASSERT_EQUAL_INT(HAL_OK, store_load(&store, PART[k], TAG, 24U, take, taken));
            TEST_ASSERT_EQUAL_HEX16_ARRAY(given, taken, 24U);
        }
    }
}

/* Without parameters there is no tag, and no word of them. */
void test_store_table_saved_first_stands_beside_no_parameters(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_TABLE, 3U));
    const uint16_t        page = first_used_page();
    const uint16_t *const head = &flash.cells.word[page][4];
    TEST_ASSERT_EQUAL_UINT16(0U, head[3]);
    TEST_ASSERT_EQUAL_UINT16(T_WORDS, head[4]);
    TEST_ASSERT_EQUAL_UINT16(0U, head[5]);
    TEST_ASSERT_EQUAL_UINT16(0U, head[6]);
}

/* Each part fits a page of 64 words by itself, 48 and 60 of them, but not both, 84. */
void test_store_part_that_does_not_fit_beside_the_other_is_refused_and_nothing_is_touched(void)
{
    flash.page_words = 64U;
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
    const uint32_t changes = flash.changes;
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, save(STORE_TABLE, 2U));
    TEST_ASSERT_EQUAL_UINT32(changes, flash.changes);
    TEST_ASSERT_FALSE(store.active);
    TEST_ASSERT_EQUAL_UINT16(1U, stored(STORE_PARAMETERS, 9U, 1U));
}

void test_store_counts_each_save_that_fails(void)
{
    for (uint32_t k = 1U; k <= 3U; k++) {
        flash.until_error = 0;
        TEST_ASSERT_NOT_EQUAL(HAL_OK, save(STORE_PARAMETERS, 1U));
        TEST_ASSERT_EQUAL_UINT32(k, store.failures);
    }
    flash.until_error = -1;
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
    TEST_ASSERT_EQUAL_UINT32(3U, store.failures);
}

/* There is no table to copy then: a set with parameters alone is what can be saved. */
void test_store_saves_parameters_where_the_only_table_cannot_be_read_any_more(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_TABLE, 2U));
    const uint16_t page = first_used_page();
    flash.cells.word[page][4U + 8U + 5U] ^= 1U;
    TEST_ASSERT_EQUAL_INT(HAL_SENSOR_FAULT, load(STORE_TABLE));
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 3U));
    TEST_ASSERT_EQUAL_UINT16(3U, stored(STORE_PARAMETERS, 9U, 3U));
}

/* The confirm is the last block of a save: the set stands without it, but nothing more is written behind it. */
void test_store_without_its_confirm_is_saved_and_the_next_one_begins_a_fresh_page(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
    const uint32_t changes = flash.changes;
    for (int refused = 0; refused < 2; refused++) {
        flash_start();
        store_reset(&store);
        flash.until_error = (refused != 0) ? ((int32_t)changes - 1) : -1;
        TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 1U));
        flash.until_error = -1;
        TEST_ASSERT_EQUAL_INT(HAL_OK, save(STORE_PARAMETERS, 2U));
        uint32_t erased = 0U;
        for (uint16_t page = 0U; page < FLASH_PAGES; page++) {
            erased += flash.cells.erased[page];
        }
        TEST_ASSERT_EQUAL_UINT32((refused != 0) ? 2U : 1U, erased);
        TEST_ASSERT_EQUAL_UINT16(2U, stored(STORE_PARAMETERS, 1U, 2U));
    }
}
