/**
 * @file  firmware/app/storage_map.h
 * @brief Who keeps what in which pages of the non-volatile storage.
 */
#ifndef FIRMWARE_APP_STORAGE_MAP_H
#define FIRMWARE_APP_STORAGE_MAP_H

/** The last pages hold the parameters, one page a slot; those before them what the angle observer has learned. */
#define STORAGE_PARAMETER_PAGES 2U

#endif
