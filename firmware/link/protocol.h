/**
 * @file  firmware/link/protocol.h
 * @brief Numbers of the bench link, from protocol.def. docs/protocol.md has the payloads.
 */
#ifndef FIRMWARE_LINK_PROTOCOL_H
#define FIRMWARE_LINK_PROTOCOL_H

#define LINK_VERSION 1U
#define LINK_ANSWER 0x80U /**< An answer has the type of its request plus this. */

/** Types of frames. */
enum {
#define MESSAGE(name, type, shortest, longest) LINK_##name = (type),
#define REPORT(name, type) LINK_##name = (type),
#include "firmware/link/protocol.def"
    LINK_TYPES_END
};

/** Why a request was refused. */
typedef enum {
    LINK_FINE = 0,
#define REFUSAL(name, code) LINK_NO_##name = (code),
#include "firmware/link/protocol.def"
    LINK_LATER = 100 /**< Not refused: the answer comes when the work is done. Never on the wire. */
} link_refusal_t;

/** Positions of the commands. */
enum {
#define COMMAND(name, doc) LINK_CMD_##name,
#include "firmware/link/protocol.def"
    LINK_COMMANDS
};

#endif
