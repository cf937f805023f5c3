/* Self test of RAM, program and processor: at the start, and slice by slice in the main loop. */
#include "fake_memory.h"
#include "tests/hal/support/started.h"

#define RAM FAKE_MEMORY_FIRST
#define RAM_WORDS 40U
#define FLASH (FAKE_MEMORY_FIRST + 100U)
#define COPY (FAKE_MEMORY_FIRST + 200U)
/* CRC-32/CKSUM of "123456789" is 0x765E7680, of the catalogue of CRCs; that inverts the result, this does not. */
#define CHECK UINT32_C(0x89A1897F)

static port_region_t region[1];
static port_copy_t   copy[1];
static CRC_TABLE     sums;

void setUp(void) { fake_memory_power_on(); }
void tearDown(void) { fake_memory_power_on(); }

static void start(void)
{
    fake_power_on();
    TEST_ASSERT_EQUAL(PORT_OK, port_init());
}

static void pass(uint32_t passes)
{
    for (uint32_t i = 0U; i < passes; i++) {
        port_self_test_slice();
    }
}

static void give_ram(bool fresh)
{
    region[0].first = RAM;
    region[0].words = RAM_WORDS;
    fake_places.fresh = region;
    fake_places.fresh_count = fresh ? 1U : 0U;
    fake_places.ram = region;
    fake_places.ram_count = 1U;
}

/* A zero octet before the text leaves a sum that begins with zero alone, and makes the octets even: the less significant first. */
static void give_program(void)
{
    static const uint16_t TEXT[5] = {0x3100U, 0x3332U, 0x3534U, 0x3736U, 0x3938U};
    for (uint32_t i = 0U; i < 5U; i++) {
        port_put(FLASH + i, TEXT[i]);
        port_put(COPY + i, TEXT[i]);
    }
    sums.rec_size = 8U;
    sums.num_recs = 1U;
    sums.recs[0].addr = FLASH;
    sums.recs[0].size = 5U;
    sums.recs[0].crc_value = CHECK;
    copy[0].run = COPY;
    copy[0].load = FLASH;
    copy[0].words = 5U;
    fake_places.sums = &sums;
    fake_places.copy = copy;
    fake_places.copy_count = 1U;
}

static void fails_for_good(hal_inverter_fault_t what)
{
    TEST_ASSERT_EQUAL(what, hal_inverter_fault());
    hal_inverter_clear_fault();
    TEST_ASSERT_EQUAL(what, hal_inverter_fault());
    TEST_ASSERT_EQUAL(HAL_SENSOR_FAULT, hal_inverter_arm());
}

static void spoil(fake_defect_t defect, uint32_t at, uint32_t by, uint16_t bit)
{
    fake_memory.defect = defect;
    fake_memory.at = at;
    fake_memory.by = by;
    fake_memory.bit = bit;
}

/* ---- RAM --------------------------------------------------------------------------------------------------------------- */

void test_ram_that_works_passes_and_is_left_at_zero_by_the_start(void)
{
    give_ram(true);
    give_program();
    port_put(RAM + 3U, 0x1234U);

    start();

    TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, hal_inverter_fault());
    for (uint32_t i = 0U; i < RAM_WORDS; i++) {
        TEST_ASSERT_EQUAL_HEX16(0U, port_take(RAM + i));
    }
}

/* Every kind of defect, in the first word, the last and one between, of every bit. */
void test_ram_with_a_defect_is_found_at_the_start_and_never_arms(void)
{
    static const uint32_t AT[3] = {0U, 17U, RAM_WORDS - 1U};
    for (int defect = FAKE_MEMORY_STUCK_LOW; defect <= FAKE_MEMORY_SAME_ADDRESS; defect++) {
        for (int k = 0; k < 3; k++) {
            for (uint16_t bit = 0U; bit < 16U; bit++) {
                fake_memory_power_on();
                give_ram(true);
                spoil((fake_defect_t)defect, AT[k], (AT[k] == 5U) ? 6U : 5U, (uint16_t)(1U << bit));
                port_self_test_start();
                TEST_ASSERT_EQUAL(HAL_INVERTER_RAM_TEST, port_self_test_found());
            }
        }
    }
    start();
    fails_for_good(HAL_INVERTER_RAM_TEST);
}

/* A bit that is always what another bit of the same word is: only a background in which the two differ shows it. */
void test_ram_with_a_bit_that_follows_another_of_its_word_is_found_within_five_rounds(void)
{
    for (uint16_t bit = 0U; bit < 16U; bit++) {
        for (uint16_t other = 0U; other < 16U; other++) {
            if (bit != other) {
                fake_memory_power_on();
                give_ram(false);
                port_self_test_start();
                spoil(FAKE_MEMORY_BIT_FOLLOWS, 9U, (uint32_t)1U << other, (uint16_t)(1U << bit));
                pass(5U * 3U * (RAM_WORDS / PORT_RAM_SLICE_WORDS + 1U));
                TEST_ASSERT_EQUAL(HAL_INVERTER_RAM_TEST, port_self_test_found());
            }
        }
    }
}

void test_ram_slices_find_a_defect_in_every_word_within_one_round(void)
{
    for (uint32_t at = 0U; at < RAM_WORDS; at++) {
        fake_memory_power_on();
        give_ram(false);
        port_self_test_start();
        pass(7U); /* somewhere in a round */
        spoil((at % 2U == 0U) ? FAKE_MEMORY_STUCK_LOW : FAKE_MEMORY_NO_RISE, at, 0U, 0x0100U);
        pass(3U * (RAM_WORDS / PORT_RAM_SLICE_WORDS + 1U));
        TEST_ASSERT_EQUAL(HAL_INVERTER_RAM_TEST, port_self_test_found());
        TEST_ASSERT_EQUAL_HEX32(RAM + at, port_self_test_address());
    }
}

/* An odd number of words: the last slice is one earlier. */
void test_ram_slices_reach_the_last_of_an_odd_number_of_words_and_none_beyond(void)
{
    give_ram(false);
    region[0].words = RAM_WORDS - 1U;
    port_self_test_start();
    fake_memory.unmasked_writes = 0U;
    port_put(RAM + RAM_WORDS - 1U, 0xBEEFU);
    spoil(FAKE_MEMORY_STUCK_LOW, RAM_WORDS - 1U, 0U, 0xFFFFU); /* not its own */
    pass(200U);
    TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, port_self_test_found());
    spoil(FAKE_MEMORY_STUCK_LOW, RAM_WORDS - 2U, 0U, 0x8000U);
    pass(200U);
    TEST_ASSERT_EQUAL(HAL_INVERTER_RAM_TEST, port_self_test_found());
}

/* 2 words: read, the first write of the march, and five times read and written, the last time with what was there. */
void test_ram_slices_keep_every_word_and_mask_interrupts_for_few_accesses_only(void)
{
    give_ram(false);
    port_self_test_start();
    for (uint32_t i = 0U; i < RAM_WORDS; i++) {
        port_put(RAM + i, (uint16_t)(0x9E37U * (i + 1U)));
    }
    fake_memory.unmasked_writes = 0U;
    fake_memory.masked_accesses = 0U;
    fake_memory.longest_masked = 0U;
    chip.intm = false;

    for (int k = 0; k < 700; k++) { /* all backgrounds, all words */
        pass(1U);
        TEST_ASSERT_FALSE(chip.intm);
        (void)port_take(FLASH); /* a slice begins its count again */
    }

    for (uint32_t i = 0U; i < RAM_WORDS; i++) {
        TEST_ASSERT_EQUAL_HEX16((uint16_t)(0x9E37U * (i + 1U)), port_take(RAM + i));
    }
    TEST_ASSERT_EQUAL_UINT32(0U, fake_memory.unmasked_writes);
    TEST_ASSERT_EQUAL_UINT32(2U * (1U + 1U + (2U * 5U)), fake_memory.longest_masked);
    chip.intm = true;
    pass(3U); /* who had them masked finds them masked */
    TEST_ASSERT_TRUE(chip.intm);
}

/* ---- program ------------------------------------------------------------------------------------------------------------ */

void test_program_with_any_bit_changed_is_found_at_the_start(void)
{
    for (uint32_t word = 0U; word < 5U; word++) {
        for (uint16_t bit = 0U; bit < 16U; bit++) {
            fake_memory_power_on();
            give_program();
            fake_memory.word[FLASH - FAKE_MEMORY_FIRST + word] ^= (uint16_t)(1U << bit);
            port_self_test_start();
            TEST_ASSERT_EQUAL(HAL_INVERTER_PROGRAM_TEST, port_self_test_found());
            TEST_ASSERT_EQUAL_HEX32(FLASH, port_self_test_address());
        }
    }
    start();
    fails_for_good(HAL_INVERTER_PROGRAM_TEST);
}

void test_program_in_ram_that_differs_from_its_flash_is_found_at_the_start(void)
{
    for (uint32_t word = 0U; word < 5U; word++) {
        fake_memory_power_on();
        give_program();
        fake_memory.word[COPY - FAKE_MEMORY_FIRST + word] ^= 0x0400U;
        port_self_test_start();
        TEST_ASSERT_EQUAL(HAL_INVERTER_PROGRAM_TEST, port_self_test_found());
        TEST_ASSERT_EQUAL_HEX32(COPY, port_self_test_address());
    }
}

void test_program_without_a_sum_is_not_believed(void)
{
    give_program();
    sums.num_recs = 0U;
    port_self_test_start();
    TEST_ASSERT_EQUAL(HAL_INVERTER_PROGRAM_TEST, port_self_test_found());
}

/* Sections of several slices, of a slice and of a word less, and a round over all of them: a slice of the program comes in every third
 * pass. */
void test_program_changed_while_it_runs_is_found_within_one_round(void)
{
    static const uint32_t WORDS[4] = {1U, PORT_PROGRAM_SLICE_WORDS - 1U, PORT_PROGRAM_SLICE_WORDS, 3U * PORT_PROGRAM_SLICE_WORDS};
    for (int k = 0; k < 4; k++) {
        fake_memory_power_on();
        give_program();
        for (uint32_t i = 0U; i < WORDS[k]; i++) {
            port_put(COPY + i, (uint16_t)(i + 1U));
            port_put(COPY + 100U + i, (uint16_t)(i + 1U));
        }
        copy[0].load = COPY + 100U;
        copy[0].words = WORDS[k];
        port_self_test_start();
        pass(100U);
        TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, port_self_test_found());
        fake_memory.word[COPY - FAKE_MEMORY_FIRST + WORDS[k] - 1U] ^= 1U;
        pass(3U * 2U * 6U); /* the slices of two rounds */
        TEST_ASSERT_EQUAL(HAL_INVERTER_PROGRAM_TEST, port_self_test_found());
    }
}

/* ---- processor ---------------------------------------------------------------------------------------------------------- */

/* The signature in the header was calculated in exact numbers; each operand reaches it. */
void test_processor_gives_the_signature_and_every_operand_counts(void)
{
    TEST_ASSERT_EQUAL_HEX32(UINT32_C(0xF4F34017), port_processor_signature(&port_operands));
    const port_operands_t right = port_operands;
    for (int k = 0; k < 16; k++) {
        port_operands_t wrong = right;
        if (k < 4) {
            wrong.word[k] ^= 1U;
        } else if (k < 8) {
            wrong.dword[k - 4] ^= 1U;
        } else if (k < 10) {
            wrong.number[k - 8] ^= 1;
        } else {
            wrong.real[k - 10] -= 1.0f; /* of 16777216 one less is another number, one more is not */
        }
        TEST_ASSERT_NOT_EQUAL_UINT32(PORT_PROCESSOR_SIGNATURE, port_processor_signature(&wrong));
    }
}

void test_processor_that_calculates_wrongly_never_arms(void)
{
    static port_operands_t wrong;
    wrong = port_operands;
    wrong.dword[2] ^= UINT32_C(0x10000);
    fake_places.operands = &wrong;

    start();

    fails_for_good(HAL_INVERTER_PROCESSOR_TEST);
    TEST_ASSERT_EQUAL_HEX32(0U, port_self_test_address());
}

/* ---- while it runs --------------------------------------------------------------------------------------------------------- */

void test_failure_while_the_bridge_is_on_switches_it_off_in_the_pass_that_finds_it(void)
{
    static port_operands_t wrong;
    wrong = port_operands;
    started();
    arm();
    pass(9U);
    TEST_ASSERT_TRUE(all_gates_follow());
    wrong.word[0] ^= 0x8000U;
    fake_places.operands = &wrong;

    port_background();
    port_background();
    port_background();

    TEST_ASSERT_TRUE(all_gates_low());
    fails_for_good(HAL_INVERTER_PROCESSOR_TEST);
    fake_places.operands = &port_operands; /* it works again: it may not be relied on */
    pass(9U);
    fails_for_good(HAL_INVERTER_PROCESSOR_TEST);
}

void test_first_failure_stands_and_its_address_is_in_the_health(void)
{
    give_ram(false);
    give_program();
    started();
    spoil(FAKE_MEMORY_STUCK_LOW, 12U, 0U, 0x0001U);
    pass(100U);
    fake_memory.word[FLASH - FAKE_MEMORY_FIRST] ^= 1U;
    pass(100U);
    port_background();

    TEST_ASSERT_EQUAL(HAL_INVERTER_RAM_TEST, port_self_test_found());
    TEST_ASSERT_EQUAL_HEX32(RAM + 12U, port_health()->failed_address);
}

/* ---- several regions, and the turns -------------------------------------------------------------------------------------- */

/* A long one, one without a whole slice, one of exactly a slice; behind each lies memory of nobody, which is bad. */
static void give_regions(void)
{
    static const port_region_t REGIONS[3] = {{RAM, 10U}, {RAM + 20U, 1U}, {RAM + 30U, PORT_RAM_SLICE_WORDS}};
    fake_places.fresh = REGIONS;
    fake_places.fresh_count = 3U;
    fake_places.ram = REGIONS;
    fake_places.ram_count = 3U;
}

void test_ram_of_every_region_is_tested_at_the_start_and_none_beyond(void)
{
    static const struct {
        uint32_t at;
        bool     ours;
    } ROW[] = {{0U, true},   {9U, true},   {10U, false}, {19U, false}, {20U, true},
               {21U, false}, {29U, false}, {30U, true},  {31U, true},  {32U, false}};
    for (size_t k = 0U; k < sizeof ROW / sizeof ROW[0]; k++) {
        fake_memory_power_on();
        give_regions();
        spoil(FAKE_MEMORY_STUCK_HIGH, ROW[k].at, 0U, 0x0040U);
        port_put(RAM + ROW[k].at, 0x1234U);
        port_self_test_start();
        TEST_ASSERT_EQUAL(ROW[k].ours ? HAL_INVERTER_RAM_TEST : HAL_INVERTER_FINE, port_self_test_found());
        TEST_ASSERT_EQUAL_HEX32(ROW[k].ours ? (RAM + ROW[k].at) : 0U, port_self_test_address());
        TEST_ASSERT_EQUAL_HEX16(ROW[k].ours ? 0U : 0x1234U, fake_memory.word[ROW[k].at]); /* only ours are cleared */
    }
}

/* A round: five slices, one pass for the region that has none, one slice, and the pass that ends it; every third pass is of the RAM. */
void test_ram_slices_go_through_every_region_in_one_round(void)
{
    static const uint32_t AT[] = {0U, 9U, 30U, 31U};
    for (size_t k = 0U; k < sizeof AT / sizeof AT[0]; k++) {
        for (uint32_t round = 1U; round <= 2U; round++) {
            fake_memory_power_on();
            give_regions();
            port_self_test_start();
            pass((round - 1U) * 3U * 8U);
            spoil(FAKE_MEMORY_STUCK_LOW, AT[k], 0U, 0xFFFFU);
            pass(3U * 7U);
            TEST_ASSERT_EQUAL(HAL_INVERTER_RAM_TEST, port_self_test_found());
            TEST_ASSERT_EQUAL_HEX32(RAM + AT[k], port_self_test_address());
        }
    }
}

/* From the start on RAM, program and processor come one after the other. */
void test_turns_begin_with_the_ram_and_each_comes_in_three_passes(void)
{
    static port_operands_t wrong;
    wrong = port_operands;
    wrong.word[1] ^= 1U;
    for (uint32_t before = 0U; before < 3U; before++) {
        fake_memory_power_on();
        give_ram(false);
        give_program();
        port_self_test_start();
        pass(before);
        port_self_test_start(); /* forgets where the turns were */
        fake_memory.longest_masked = 0U;
        chip.intm = false;
        pass(1U);
        TEST_ASSERT_TRUE(fake_memory.longest_masked > 0U);
        fake_memory.word[FLASH - FAKE_MEMORY_FIRST] ^= 1U;
        fake_places.operands = &wrong;
        pass(1U);
        TEST_ASSERT_EQUAL(HAL_INVERTER_PROGRAM_TEST, port_self_test_found());
        chip.intm = true;
    }
    fake_memory_power_on();
    port_self_test_start();
    fake_places.operands = &wrong;
    pass(2U);
    TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, port_self_test_found());
    pass(1U);
    TEST_ASSERT_EQUAL(HAL_INVERTER_PROCESSOR_TEST, port_self_test_found());
}
