/**
 * @file  tests/firmware/support/line.h
 * @brief The client's end of the bench link, for tests of the services: asks, waits, and keeps what came by itself.
 *
 * Stands on support/bench (the board) and support/flash (the storage); octets travel through stubs of hal_link.
 */
#ifndef TESTS_FIRMWARE_SUPPORT_LINE_H
#define TESTS_FIRMWARE_SUPPORT_LINE_H

#include "firmware/link/protocol.h"
#include "firmware/services/services.h"
#include "tests/firmware/support/bench.h"
#include "tests/firmware/support/flash.h"

#define LINE_CAPTURE_VALUES 512U
#define LINE_BOX_VALUES 256U
#define LINE_OCTETS 4096U
#define LINE_FRAMES 64U

typedef struct {
    uint16_t type, seq, count;
    uint16_t octet[FRAME_PAYLOAD_MAX];
} line_frame_t;

typedef struct {
    uint16_t       to_drive[LINE_OCTETS];
    uint32_t       sent, read; /* octets, free-running */
    uint16_t       room;       /* octets that a call of hal_link_write takes at most */
    uint16_t       reads_per_pass, most_reads_per_pass;
    line_frame_t   frame[LINE_FRAMES]; /* everything the drive sent */
    uint16_t       frames;
    uint16_t       dropped;
    uint16_t       seq;
    frame_t        request; /* line_begin, then put into its payload, then line_ask */
    line_frame_t   answer;
    codec_reader_t in; /* payload of the answer */
} line_t;

extern line_t         line;
extern services_t     services;
extern drive_params_t line_defaults; /* of the board; changed before line_start */
extern hal_reset_t    line_reset;    /* why the board starts; power-up after line_start, for line_restart */

/** Board, storage, services; the drive is ready and does not run by itself. */
void line_start(void);
/** Power off and on: everything but the storage starts again. */
void line_restart(void);
/** The processor starts again; services and black box are as they were. */
void line_reset_by(hal_reset_t cause);
/** Periods with a pass of the main loop after each. */
void line_run(uint32_t periods);

codec_writer_t *line_begin(uint16_t type);
/** Send the request and wait for its answer. @return type of the answer, LINK_refused or 0: none came in 100 periods. */
uint16_t line_ask(void);
/** Octets as they are. */
void line_send(const uint16_t *octets, uint16_t count);

/** Whole requests, answered as they should be. */
void line_hello(uint32_t schema);
void line_command(uint16_t command);
void line_set(uint16_t param, float value);
/** The last frame of a type, or NULL. */
const line_frame_t *line_last(uint16_t type);
uint16_t            line_count(uint16_t type);
/** The code of the refusal, with its details in line.in behind it; fails when it was no refusal of this request. */
uint16_t line_refusal(uint16_t type);

#endif
