/* firmware/link/frame.c: frames against an independent reference (tests/vectors), and every small damage. */
#include "firmware/link/frame.h"
#include "protocol_vectors.h"
#include "unity.h"

#define COUNT(list) (sizeof(list) / sizeof((list)[0]))

static frame_t         frame;
static frame_decoder_t decoder;
static uint16_t        wire[FRAME_WIRE_MAX];
static uint16_t        good, dropped;

void setUp(void) { frame_decoder_reset(&decoder); }
void tearDown(void) {}

static void feed(const uint16_t *octets, uint16_t count)
{
    good = 0U;
    dropped = 0U;
    for (uint16_t i = 0U; i < count; i++) {
        const frame_event_t e = frame_decode(&decoder, octets[i]);
        good += (e == FRAME_GOOD) ? 1U : 0U;
        dropped += (e == FRAME_DROPPED) ? 1U : 0U;
    }
}

static const vector_frame_t *vector(const char *name)
{
    for (uint16_t i = 0U; i < COUNT(VECTOR_FRAMES); i++) {
        const char *a = name;
        const char *b = VECTOR_FRAMES[i].name;
        while ((*a != '\0') && (*a == *b)) {
            a++;
            b++;
        }
        if (*a == *b) {
            return &VECTOR_FRAMES[i];
        }
    }
    TEST_FAIL_MESSAGE(name);
    return NULL;
}

void test_frame_is_on_the_wire_what_the_reference_makes(void)
{
    for (uint16_t i = 0U; i < COUNT(VECTOR_FRAMES); i++) {
        const vector_frame_t *const v = &VECTOR_FRAMES[i];
        frame_begin(&frame, v->type, v->seq);
        for (uint16_t k = 0U; k < v->payload_count; k++) {
            codec_put_u8(&frame.payload, v->payload[k]);
        }
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(v->wire_count, frame_end(&frame, wire), v->name);
        TEST_ASSERT_EQUAL_HEX16_ARRAY_MESSAGE(v->wire, wire, v->wire_count, v->name);
    }
}

void test_frame_of_the_reference_comes_back_whole(void)
{
    for (uint16_t i = 0U; i < COUNT(VECTOR_FRAMES); i++) {
        const vector_frame_t *const v = &VECTOR_FRAMES[i];
        feed(v->wire, v->wire_count);
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(1U, good, v->name);
        TEST_ASSERT_EQUAL_HEX16(v->type, frame_type(&decoder));
        TEST_ASSERT_EQUAL_HEX16(v->seq, frame_seq(&decoder));
        codec_reader_t r = frame_payload(&decoder);
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(v->payload_count, r.count, v->name);
        for (uint16_t k = 0U; k < v->payload_count; k++) {
            TEST_ASSERT_EQUAL_HEX16(v->payload[k], codec_get_u8(&r));
        }
    }
}

void test_frame_that_is_none_is_dropped_once_and_the_next_one_is_good(void)
{
    const vector_frame_t *const next = vector("alive");
    for (uint16_t i = 0U; i < COUNT(VECTOR_DROPPED); i++) {
        feed(VECTOR_DROPPED[i].octets, VECTOR_DROPPED[i].count);
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(0U, good, VECTOR_DROPPED[i].name);
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(1U, dropped, VECTOR_DROPPED[i].name);
        feed(next->wire, next->wire_count);
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(1U, good, VECTOR_DROPPED[i].name);
    }
}

void test_frame_delimiters_alone_mean_nothing(void)
{
    static const uint16_t zeros[5] = {0U, 0U, 0U, 0U, 0U};

    feed(zeros, 5U);

    TEST_ASSERT_EQUAL_UINT16(0U, good);
    TEST_ASSERT_EQUAL_UINT16(0U, dropped);
}

void test_frame_too_long_to_send_is_not_sent(void)
{
    frame_begin(&frame, 1U, 1U);
    for (uint16_t i = 0U; i < FRAME_PAYLOAD_MAX + 1U; i++) {
        codec_put_u8(&frame.payload, i);
    }
    TEST_ASSERT_EQUAL_UINT16(0U, frame_end(&frame, wire));
}

void test_frame_ignores_what_is_above_an_octet(void)
{
    const vector_frame_t *const v = vector("set");
    good = 0U;
    for (uint16_t i = 0U; i < v->wire_count; i++) {
        good += (frame_decode(&decoder, v->wire[i] | 0xAB00U) == FRAME_GOOD) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL_UINT16(1U, good);
}

/* ---- damage ---------------------------------------------------------------------------------------------------------- */

static void flip(uint16_t *octets, uint16_t bit) { octets[bit >> 3] ^= (uint16_t)(1U << (bit & 7U)); }

/* Everything from octet `from` on, behind a decoder state; a frame that is good is an error nobody saw. */
static uint16_t accepted(const frame_decoder_t *state, const uint16_t *octets, uint16_t from, uint16_t count)
{
    uint16_t n = 0U;
    decoder = *state;
    for (uint16_t i = from; i < count; i++) {
        n += (frame_decode(&decoder, octets[i]) == FRAME_GOOD) ? 1U : 0U;
    }
    return n;
}

/* @param step  1: every second bit; more: one of so many */
static void every_two_bits(const char *name, uint16_t step)
{
    const vector_frame_t *const v = vector(name);
    const uint16_t              bits = (uint16_t)(8U * v->wire_count);
    frame_decoder_t             before;
    for (uint16_t i = 0U; i < v->wire_count; i++) {
        wire[i] = v->wire[i];
    }
    for (uint16_t a = 0U; a < bits; a++) {
        const uint16_t first = a >> 3;
        flip(wire, a);
        frame_decoder_reset(&before);
        for (uint16_t i = 0U; i < first; i++) {
            (void)frame_decode(&before, wire[i]);
        }
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(0U, accepted(&before, wire, first, v->wire_count), name);
        for (uint16_t b = (uint16_t)(a + 1U); b < bits; b = (uint16_t)(b + step)) {
            flip(wire, b);
            TEST_ASSERT_EQUAL_UINT16_MESSAGE(0U, accepted(&before, wire, first, v->wire_count), name);
            flip(wire, b);
        }
        flip(wire, a);
    }
}

/* All pairs of bits, delimiter and COBS codes included: 328 bits, 53 thousand pairs. On an emulated AVR a seventh of them. */
#ifdef __AVR__
#define SHORT_STEP 7U
#else
#define SHORT_STEP 1U
#endif
void test_frame_with_any_one_or_two_bits_wrong_is_dropped(void) { every_two_bits("stream", SHORT_STEP); }

/* The longest frame there is: 2048 bits, 2.1 million pairs. With sanitizers, which look at accesses, a ninth of them. */
#ifdef __SANITIZE_ADDRESS__
#define LONG_STEP 9U
#else
#define LONG_STEP 1U
#endif
void test_frame_of_full_length_with_any_one_or_two_bits_wrong_is_dropped(void) { every_two_bits("longest_random", LONG_STEP); }

void test_frame_with_any_one_bit_wrong_is_dropped_and_the_next_delimiter_resynchronises(void)
{
    const vector_frame_t *const next = vector("alive");
    for (uint16_t i = 0U; i < COUNT(VECTOR_FRAMES); i++) {
        const vector_frame_t *const v = &VECTOR_FRAMES[i];
        for (uint16_t k = 0U; k < v->wire_count; k++) {
            wire[k] = v->wire[k];
        }
        for (uint16_t bit = 0U; bit < 8U * v->wire_count; bit++) {
            flip(wire, bit);
            feed(wire, v->wire_count);
            TEST_ASSERT_EQUAL_UINT16_MESSAGE(0U, good, v->name);
            flip(wire, bit);
            const bool delimited = bit < 8U * (v->wire_count - 1U);
            feed(next->wire, next->wire_count);
            TEST_ASSERT_EQUAL_UINT16_MESSAGE(delimited ? 1U : 0U, good, v->name); /* no delimiter: both are one, and wrong */
            feed(next->wire, next->wire_count);
            TEST_ASSERT_EQUAL_UINT16_MESSAGE(1U, good, v->name);
        }
    }
}

void test_frame_cut_anywhere_is_dropped(void)
{
    const vector_frame_t *const v = vector("longest_random");
    static const uint16_t       end[1] = {0U};
    for (uint16_t n = 1U; n < v->wire_count - 1U; n++) {
        feed(v->wire, n);
        TEST_ASSERT_EQUAL_UINT16(0U, good);
        feed(end, 1U);
        TEST_ASSERT_EQUAL_UINT16(0U, good);
        TEST_ASSERT_EQUAL_UINT16(1U, dropped);
    }
}
