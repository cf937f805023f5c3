/**
 * @file  hal/include/hal/hal_link.h
 * @brief Octets to and from the bench. An octet travels in the low 8 bits of a uint16_t: char has 16 bits on the chip.
 */
#ifndef HAL_HAL_LINK_H
#define HAL_HAL_LINK_H

#include "hal/hal_types.h"

/** Take up to @p limit octets that have arrived. Never waits. @return how many. From the main loop. */
uint16_t hal_link_read(uint16_t *octets, uint16_t limit);
/** Octets, or runs of them, that arrived and found no room, since the start. From the main loop. */
uint32_t hal_link_lost(void);
/** Hand over up to @p count octets for sending. Never waits. @return how many were taken. From the main loop. */
uint16_t hal_link_write(const uint16_t *octets, uint16_t count);

#endif
