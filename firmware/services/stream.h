/**
 * @file  firmware/services/stream.h
 * @brief Decimated rows of chosen signals, from the current interrupt to the link: a ring between the two.
 *
 * The interrupt writes rows and `written`, the main loop takes them and writes `taken`; the configuration changes while `on`
 * is 0. A full ring drops the newest row and counts it; the counter in the rows shows the gap.
 * Cost in the interrupt: a comparison, and at a row one telemetry_read per signal.
 */
#ifndef FIRMWARE_SERVICES_STREAM_H
#define FIRMWARE_SERVICES_STREAM_H

#include "firmware/app/status.h"
#include "firmware/link/codec.h"

#define STREAM_SIGNALS 12U
#define STREAM_VALUES 1024U /**< Room of the ring: 128 ms of eight signals at 1 kHz. */
#define STREAM_ROWS 256U
#define STREAM_FRAME_OCTETS 240U /**< Of the values in a frame. */
#define STREAM_PATIENCE 200U     /**< Periods that a row waits for others: 20 ms. */

typedef struct {
    uint16_t signal[STREAM_SIGNALS];
    uint16_t count, decimation;
    uint16_t frame_rows; /**< Most rows of a frame. */
    uint16_t rows;       /**< Room of the ring. */
    uint16_t config;     /**< Number of this configuration, 8 bits. */
    uint16_t frame;      /**< Frames since. */

    volatile uint16_t on;
    bool              fresh;          /**< The interrupt has not seen this configuration yet. */
    uint16_t          wait;           /**< Periods until the next row. */
    volatile uint16_t written, taken; /**< Rows, free-running. */
    uint16_t          write_slot, read_slot;
    volatile uint32_t lost;

    uint32_t counter[STREAM_ROWS];
    float    value[STREAM_VALUES];
} stream_t;

/** Nothing is streamed. */
void stream_init(stream_t *s);
/** Main loop. @p count 0 stops; at most STREAM_SIGNALS; @p rows 0: as many rows in a frame as fit. */
void stream_configure(stream_t *s, const uint16_t *signals, uint16_t count, uint16_t decimation, uint16_t rows);
/** Current interrupt, every period. */
void stream_sample(stream_t *s, const drive_t *d, uint32_t counter);
/** Main loop: the payload of the next frame, if one is due. */
bool stream_take(stream_t *s, uint32_t counter, codec_writer_t *w);

#endif
