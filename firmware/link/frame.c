#include "firmware/link/frame.h"

#include "firmware/link/crc.h"

#define DELIMITER 0U
#define OCTET 0xFFU

void frame_begin(frame_t *f, uint16_t type, uint16_t seq)
{
    f->octets[0] = type & OCTET;
    f->octets[1] = seq & OCTET;
    f->payload = codec_writer(&f->octets[FRAME_HEAD], FRAME_PAYLOAD_MAX);
}

static void append_check(frame_t *f, uint16_t count)
{
    uint32_t c = CRC_START;
    for (uint16_t i = 0U; i < count; i++) {
        c = crc_octet(c, f->octets[i]);
    }
    codec_writer_t w = codec_writer(&f->octets[count], FRAME_CHECK);
    codec_put_u32(&w, crc_value(c));
}

/* Each zero becomes the distance to the next one; at most 254 octets, so no distance is longer than a code. */
static uint16_t stuff(const uint16_t *octets, uint16_t count, uint16_t *wire)
{
    uint16_t code_at = 0U;
    uint16_t n = 1U;
    for (uint16_t i = 0U; i < count; i++) {
        if (octets[i] == DELIMITER) {
            wire[code_at] = (uint16_t)(n - code_at);
            code_at = n;
        } else {
            wire[n] = octets[i];
        }
        n++;
    }
    wire[code_at] = (uint16_t)(n - code_at);
    wire[n] = DELIMITER;
    return (uint16_t)(n + 1U);
}

uint16_t frame_end(frame_t *f, uint16_t *wire)
{
    if (f->payload.over) {
        return 0U;
    }
    const uint16_t count = (uint16_t)(FRAME_HEAD + f->payload.at);
    append_check(f, count);
    return stuff(f->octets, (uint16_t)(count + FRAME_CHECK), wire);
}

void frame_decoder_reset(frame_decoder_t *d)
{
    d->count = 0U;
    d->left = 0U;
    d->crc = CRC_START;
    d->zero = false;
    d->begun = false;
    d->bad = false;
}

static void append(frame_decoder_t *d, uint16_t octet)
{
    if (d->count < FRAME_MAX) {
        d->octets[d->count] = octet;
        d->count++;
        d->crc = crc_octet(d->crc, octet);
    } else {
        d->bad = true;
    }
}

static frame_event_t end_of_frame(const frame_decoder_t *d)
{
    if (!d->begun) {
        return FRAME_NOTHING;
    }
    const bool good = !d->bad && (d->left == 0U) && (d->count >= FRAME_MIN) && (d->crc == CRC_RESIDUE);
    return good ? FRAME_GOOD : FRAME_DROPPED;
}

frame_event_t frame_decode(frame_decoder_t *d, uint16_t octet)
{
    const uint16_t x = octet & OCTET;
    if (x == DELIMITER) {
        const frame_event_t event = end_of_frame(d);
        const uint16_t      count = d->count;
        frame_decoder_reset(d);
        d->count = (event == FRAME_GOOD) ? count : 0U; /* for frame_payload; the next octet starts a new frame */
        return event;
    }
    if (!d->begun) {
        d->count = 0U;
        d->begun = true;
    }
    if (d->left > 0U) {
        append(d, x);
        d->left--;
        return FRAME_NOTHING;
    }
    if (d->zero) {
        append(d, DELIMITER);
    }
    d->left = (uint16_t)(x - 1U);
    d->zero = x < OCTET;
    return FRAME_NOTHING;
}

uint16_t frame_type(const frame_decoder_t *d) { return d->octets[0]; }
uint16_t frame_seq(const frame_decoder_t *d) { return d->octets[1]; }

codec_reader_t frame_payload(const frame_decoder_t *d)
{
    const uint16_t count = (d->count > FRAME_MIN) ? (uint16_t)(d->count - FRAME_MIN) : 0U;
    return codec_reader(&d->octets[FRAME_HEAD], count);
}
