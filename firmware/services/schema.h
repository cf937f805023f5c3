/**
 * @file  firmware/services/schema.h
 * @brief What the drive is made of, as records on the link, and their hash: parameters, signals, faults, commands.
 */
#ifndef FIRMWARE_SERVICES_SCHEMA_H
#define FIRMWARE_SERVICES_SCHEMA_H

#include "firmware/link/codec.h"

enum { SCHEMA_PARAMETERS = 0, SCHEMA_SIGNALS, SCHEMA_FAULTS, SCHEMA_COMMANDS, SCHEMA_KINDS };

#define SCHEMA_AT_REST 1U      /**< Flag of a parameter: it only changes while the bridge is off. */
#define SCHEMA_RECORD_MAX 200U /**< Octets of the longest record. */

/** Entries of a kind; 0 beyond the kinds. */
uint16_t schema_count(uint16_t kind);
/** Append the record of an entry. @p index below schema_count. */
void        schema_record(uint16_t kind, uint16_t index, codec_writer_t *w);
const char *schema_name(uint16_t kind, uint16_t index);
/** Documentation (part 0), for a fault also its first check (part 1). */
const char *schema_text(uint16_t kind, uint16_t index, uint16_t part);
/** CRC-32/ISCSI over all records, see docs/protocol.md. About 10 thousand octets: once, at start-up. */
uint32_t schema_hash(void);

#endif
