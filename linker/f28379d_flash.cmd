/* linker/f28379d_flash.cmd: the drive in flash, its interrupts in RAM. TMS320F28379D, CPU1, EABI; word addresses.
 *
 * Who lives where, and why:
 *
 *   M0, M1        stack, above what the boot ROM uses. The stack pointer has 16 bits, so the stack must lie below
 *                 0x10000. tests/target/memory counts how deep it can get.
 *   LS0 .. GS4    code of the interrupts and of all control blocks, 36 k words in one piece, because .TI.ramfunc is copied
 *                 with one memcpy. RAM has no wait states; a branch in flash costs up to 3 cycles and makes timing
 *                 depend on alignment.
 *   GS5, GS6      data of port and library; in the last quarter of GS6 the jump tables, which interrupts read. Not in the blocks
 *                 of the code: fetch and data access to one block in the same cycle cost a stall.
 *   GS8 .. GS12   the drive: 6144 + 512 learned numbers of 2 words, and its state. Alone in its blocks, so that
 *                 its size shows in the map file, and neither code nor stack ever waits for it.
 *   GS7           black box: 256 rows of 8 signals before and at the first fault.
 *   GS13 .. GS15  capture: 767 rows of 8 signals, 77 ms at 10 kHz.
 *
 * CPU2 is left in its boot loop; CPU1 owns all GS blocks from reset on. The CLA is not used; LS belongs to the CPU.
 * Never linked by the authors: no TI linker at hand. The first thing to read is the map file, see docs/bring-up.md. */

MEMORY
{
    BEGIN       : origin = 0x080000, length = 0x000002   /* the boot ROM jumps here */
    FLASH       : origin = 0x080002, length = 0x037FFE   /* A..J */
    STORAGE     : origin = 0x0B8000, length = 0x006000   /* K, L, M: nothing is linked here, hal/f28379d/storage.c erases them */
    FLASH_N     : origin = 0x0BE000, length = 0x001FF0   /* free; the last 16 words of flash stay empty (errata: prefetch) */
    RESET       : origin = 0x3FFFC0, length = 0x000002

    BOOT_RSVD   : origin = 0x000002, length = 0x000121   /* boot ROM: stack and data */
    RAM_STACK   : origin = 0x000124, length = 0x0006D4   /* M0 and M1 in one piece; the last 8 words stay free (errata) */
    RAM_CODE    : origin = 0x008000, length = 0x009000   /* LS0..LS5, D0, D1, GS0..GS4 */
    RAM_DATA    : origin = 0x011000, length = 0x001C00   /* GS5, three quarters of GS6 */
    RAM_TABLES  : origin = 0x012C00, length = 0x000400   /* the rest of GS6 */
    RAM_BOX     : origin = 0x013000, length = 0x001000   /* GS7 */
    RAM_DRIVE   : origin = 0x014000, length = 0x005000   /* GS8..GS12 */
    RAM_CAPTURE : origin = 0x019000, length = 0x002FF8   /* GS13..GS15 without its last 8 words (errata) */
}

SECTIONS
{
    codestart    : > BEGIN

    /* ALIGN(8): flash is programmed and checked in units of 128 bits. crc_table: the linker leaves a check sum of each section in
     * program_sums, which hal/f28379d/self_test_program.c holds against the flash. */
    .text        : > FLASH, ALIGN(8), crc_table(program_sums, algorithm=CRC32_PRIME)   /* main loop, start-up, library: not in a hurry */
    .cinit       : > FLASH, ALIGN(8), crc_table(program_sums, algorithm=CRC32_PRIME)
    .init_array  : > FLASH, ALIGN(8)
    .const       : > FLASH, ALIGN(8), crc_table(program_sums, algorithm=CRC32_PRIME)   /* parameter and fault tables: main loop only */
    .TI.crctab   : > FLASH, ALIGN(8)

#ifdef EVENSPIN_FLASH_API                                /* the flash API runs from RAM, and nothing of it is called before the copy */
    .TI.ramfunc  : { *(.TI.ramfunc) -l F021_API_F2837xD_FPU32_EABI.lib } LOAD = FLASH, RUN = RAM_CODE, ALIGN(8),
#else
    .TI.ramfunc  : LOAD = FLASH, RUN = RAM_CODE, ALIGN(8),
#endif
                   LOAD_START(RamfuncsLoadStart), LOAD_SIZE(RamfuncsLoadSize), RUN_START(RamfuncsRunStart),
                   crc_table(program_sums, algorithm=CRC32_PRIME)
    .switch      : LOAD = FLASH, RUN = RAM_TABLES, ALIGN(8),
                   LOAD_START(SwitchLoadStart), LOAD_SIZE(SwitchLoadSize), RUN_START(SwitchRunStart)

    .stack       : > RAM_STACK, RUN_START(StackRunStart), RUN_SIZE(StackRunSize)
    .bss         : > RAM_DATA, RUN_START(DataRunStart), RUN_SIZE(DataRunSize)   /* this and the next that have a name: tested slice by slice */
    .data        : > RAM_DATA
    .bss:output  : > RAM_DATA
    drive_memory : > RAM_DRIVE, RUN_START(DriveRunStart), RUN_SIZE(DriveRunSize)
    capture_memory   : > RAM_CAPTURE, RUN_START(CaptureRunStart), RUN_SIZE(CaptureRunSize)
    black_box_memory : > RAM_BOX, TYPE = NOINIT, RUN_START(BoxRunStart), RUN_SIZE(BoxRunSize)   /* kept over a reset */
    kept_memory  : > RAM_DATA, TYPE = NOINIT, RUN_START(KeptRunStart), RUN_SIZE(KeptRunSize)

    .reset       : > RESET, TYPE = DSECT                 /* in the boot ROM; not loaded */
}
