/**
 * @file  firmware/link/frame.h
 * @brief Frames of the bench link: type, sequence, payload, check sum; COBS; a zero between frames (docs/protocol.md).
 *
 * Work per received octet is bounded and small: decoding, check sum and length are followed octet by octet.
 */
#ifndef FIRMWARE_LINK_FRAME_H
#define FIRMWARE_LINK_FRAME_H

#include <stdbool.h>
#include <stdint.h>

#include "firmware/link/codec.h"

#define FRAME_PAYLOAD_MAX 248U
#define FRAME_HEAD 2U  /**< Type and sequence. */
#define FRAME_CHECK 4U /**< Check sum. */
#define FRAME_MIN (FRAME_HEAD + FRAME_CHECK)
#define FRAME_MAX (FRAME_MIN + FRAME_PAYLOAD_MAX) /**< 254: COBS never needs a second code of 0xFF. */
#define FRAME_WIRE_MAX (FRAME_MAX + 2U)           /**< With COBS and the delimiter. */

/** A frame under construction. */
typedef struct {
    uint16_t       octets[FRAME_MAX];
    codec_writer_t payload; /**< Put the payload here; its room ends where the check sum begins. */
} frame_t;

void frame_begin(frame_t *f, uint16_t type, uint16_t seq);
/** Close and stuff. @p wire has room for FRAME_WIRE_MAX. @return octets to send; 0 when the payload did not fit. */
uint16_t frame_end(frame_t *f, uint16_t *wire);

typedef enum {
    FRAME_NOTHING = 0, /**< Go on. */
    FRAME_GOOD,        /**< A frame stands in the decoder until the next octet. */
    FRAME_DROPPED      /**< Something ended here that is no frame. */
} frame_event_t;

typedef struct {
    uint16_t octets[FRAME_MAX];
    uint16_t count;
    uint16_t left; /**< Octets until the next COBS code. */
    uint32_t crc;
    bool     zero;  /**< The block that ends stands for a zero, if another follows. */
    bool     begun; /**< Something came since the last delimiter. */
    bool     bad;   /**< Too long: wait for the delimiter. */
} frame_decoder_t;

void          frame_decoder_reset(frame_decoder_t *d);
frame_event_t frame_decode(frame_decoder_t *d, uint16_t octet);

/** Of the frame that FRAME_GOOD announced. */
uint16_t       frame_type(const frame_decoder_t *d);
uint16_t       frame_seq(const frame_decoder_t *d);
codec_reader_t frame_payload(const frame_decoder_t *d);

#endif
