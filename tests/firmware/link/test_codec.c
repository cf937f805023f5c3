/* firmware/link/codec.c, crc.c: octets, and what guards them. Expected values: tests/vectors. */
#include "firmware/link/codec.h"
#include "firmware/link/crc.h"
#include "protocol_vectors.h"
#include "unity.h"

#define COUNT(list) (sizeof(list) / sizeof((list)[0]))

static uint16_t memory[300];

void setUp(void)
{
    for (uint16_t i = 0U; i < COUNT(memory); i++) {
        memory[i] = 0xA5A5U;
    }
}

void tearDown(void) {}

void test_codec_puts_the_least_octet_first(void)
{
    static const uint16_t expected[] = {0x12U, 0x34U, 0x12U, 0x78U, 0x56U, 0x34U, 0x12U};
    codec_writer_t        w = codec_writer(memory, 7U);

    codec_put_u8(&w, 0xFF12U); /* the high half of a cell is not sent */
    codec_put_u16(&w, 0x1234U);
    codec_put_u32(&w, UINT32_C(0x12345678));

    TEST_ASSERT_EQUAL_HEX16_ARRAY(expected, memory, 7);
    TEST_ASSERT_EQUAL_UINT16(7U, w.at);
    TEST_ASSERT_FALSE(w.over);
}

void test_codec_gets_what_was_put_at_the_ends_of_every_range(void)
{
    static const uint32_t bits[] = {
        0U, 1U, UINT32_C(0x7FFFFFFF), UINT32_C(0x80000000), UINT32_C(0xFFFFFFFF), UINT32_C(0x00FF8000)};
    for (uint16_t i = 0U; i < COUNT(bits); i++) {
        codec_writer_t w = codec_writer(memory, 16U);
        codec_put_u32(&w, bits[i]);
        codec_put_u16(&w, (uint16_t)(bits[i] & UINT32_C(0xFFFF)));
        codec_put_u8(&w, (uint16_t)(bits[i] & 0xFFU));
        codec_reader_t r = codec_reader(memory, w.at);
        TEST_ASSERT_EQUAL_HEX32(bits[i], codec_get_u32(&r));
        TEST_ASSERT_EQUAL_HEX16(bits[i] & UINT32_C(0xFFFF), codec_get_u16(&r));
        TEST_ASSERT_EQUAL_HEX16(bits[i] & 0xFFU, codec_get_u8(&r));
        TEST_ASSERT_FALSE(r.over);
    }
}

void test_codec_gets_signed_numbers_of_both_signs(void)
{
    static const int32_t numbers[] = {0, 1, -1, INT32_MAX, INT32_MIN, INT32_MIN + 1, -65536};
    for (uint16_t i = 0U; i < COUNT(numbers); i++) {
        codec_writer_t w = codec_writer(memory, 4U);
        codec_put_u32(&w, (uint32_t)numbers[i]);
        codec_reader_t r = codec_reader(memory, 4U);
        TEST_ASSERT_EQUAL_INT32(numbers[i], codec_get_i32(&r));
    }
}

void test_codec_sends_floats_by_their_bits(void)
{
    for (uint16_t i = 0U; i < COUNT(VECTOR_FLOATS); i++) {
        TEST_ASSERT_EQUAL_HEX32(VECTOR_FLOATS[i].bits, codec_bits(VECTOR_FLOATS[i].value));
        TEST_ASSERT_EQUAL_HEX32(VECTOR_FLOATS[i].bits, codec_bits(codec_float(VECTOR_FLOATS[i].bits)));
    }
    codec_writer_t w = codec_writer(memory, 4U);
    codec_put_f32(&w, codec_float(UINT32_C(0x7FC00001))); /* a NaN keeps its bits */
    codec_reader_t r = codec_reader(memory, 4U);
    TEST_ASSERT_EQUAL_HEX32(UINT32_C(0x7FC00001), codec_bits(codec_get_f32(&r)));
}

void test_codec_writes_nothing_beyond_its_room_and_says_so(void)
{
    codec_writer_t w = codec_writer(memory, 3U);

    codec_put_u32(&w, UINT32_C(0xFFFFFFFF));

    TEST_ASSERT_TRUE(w.over);
    TEST_ASSERT_EQUAL_UINT16(3U, w.at);
    TEST_ASSERT_EQUAL_HEX16(0xA5A5U, memory[3]);
}

void test_codec_reads_zero_beyond_the_end_and_says_so(void)
{
    codec_reader_t r = codec_reader(memory, 1U);

    TEST_ASSERT_EQUAL_HEX16(0xA5U, codec_get_u8(&r));
    TEST_ASSERT_FALSE(r.over);
    TEST_ASSERT_EQUAL_HEX32(0U, codec_get_u32(&r));
    TEST_ASSERT_TRUE(r.over);
}

void test_codec_puts_text_with_its_length_and_cuts_at_255(void)
{
    static char    text[301];
    codec_writer_t w = codec_writer(memory, 300U);

    codec_put_str(&w, "A/V");
    TEST_ASSERT_EQUAL_HEX16(3U, memory[0]);
    TEST_ASSERT_EQUAL_HEX16('V', memory[3]);
    TEST_ASSERT_EQUAL_UINT16(4U, w.at);

    for (uint16_t i = 0U; i < 300U; i++) {
        text[i] = 'x';
    }
    w = codec_writer(memory, 300U);
    codec_put_str(&w, text);
    TEST_ASSERT_EQUAL_HEX16(255U, memory[0]);
    TEST_ASSERT_EQUAL_UINT16(256U, w.at);
    TEST_ASSERT_FALSE(w.over);
}

void test_crc_agrees_with_the_reference(void)
{
    for (uint16_t i = 0U; i < COUNT(VECTOR_CRCS); i++) {
        uint32_t c = CRC_START;
        for (uint16_t k = 0U; k < VECTOR_CRCS[i].count; k++) {
            c = crc_octet(c, VECTOR_CRCS[i].octets[k]);
        }
        TEST_ASSERT_EQUAL_HEX32(VECTOR_CRCS[i].value, crc_value(c));
        for (uint16_t shift = 0U; shift < 32U; shift += 8U) {
            c = crc_octet(c, (uint16_t)((VECTOR_CRCS[i].value >> shift) & 0xFFU));
        }
        TEST_ASSERT_EQUAL_HEX32(CRC_RESIDUE, c); /* behind its own check sum every message looks the same */
    }
}
