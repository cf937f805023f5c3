/* libFuzzer: the frame decoder on anything, and any payload there and back. What must hold is checked here; the sanitizers
 * watch the memory. */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include "firmware/link/frame.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void must(bool holds)
{
    if (!holds) {
        abort();
    }
}

static void anything(const uint8_t *data, size_t size)
{
    frame_decoder_t d;
    frame_decoder_reset(&d);
    for (size_t i = 0; i < size; i++) {
        if (frame_decode(&d, data[i]) == FRAME_GOOD) {
            must(data[i] == 0U);
            must(frame_payload(&d).count <= FRAME_PAYLOAD_MAX);
        }
    }
}

static void there_and_back(const uint8_t *data, size_t size)
{
    static frame_t         f;
    static frame_decoder_t d;
    static uint16_t        wire[FRAME_WIRE_MAX];
    const size_t           n = (size < FRAME_PAYLOAD_MAX) ? size : FRAME_PAYLOAD_MAX;
    frame_begin(&f, 0x11U, 0x22U);
    for (size_t i = 0; i < n; i++) {
        codec_put_u8(&f.payload, data[i]);
    }
    const uint16_t count = frame_end(&f, wire);
    must(count == n + 8U);
    frame_decoder_reset(&d);
    for (uint16_t i = 0U; i < count; i++) {
        const frame_event_t e = frame_decode(&d, wire[i]);
        must(e == ((i + 1U < count) ? FRAME_NOTHING : FRAME_GOOD));
    }
    codec_reader_t r = frame_payload(&d);
    must(r.count == n);
    for (size_t i = 0; i < n; i++) {
        must(codec_get_u8(&r) == data[i]);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    anything(data, size);
    there_and_back(data, size);
    return 0;
}
