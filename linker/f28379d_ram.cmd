/* linker/f28379d_ram.cmd: everything in RAM, for the debugger: loads in a second and wears no flash. TMS320F28379D, CPU1.
 *
 * The program is lost at power-off and does not start by itself. Nothing is copied, so load and run addresses are the
 * same and _FLASH is not defined. Code lies in LS0..GS11 and half of GS12, data elsewhere, for the reasons in f28379d_flash.cmd. Capture and
 * black box have 32 rows of 8 signals each, and the observer's memory is a seventh of that in flash (firmware/CMakeLists.txt):
 * ro learns down to 1014 r/min instead of 98, and aro with large tables beside those of the position loop is refused, as are more than 296
 * position_cells. */

MEMORY
{
    BEGIN       : origin = 0x000000, length = 0x000002
    RESET       : origin = 0x3FFFC0, length = 0x000002

    BOOT_RSVD   : origin = 0x000002, length = 0x000121
    RAM_STACK   : origin = 0x000124, length = 0x0006D4   /* M0 above the boot ROM's, M1 without its last 8 words (errata) */
    RAM_PROGRAM : origin = 0x008000, length = 0x010980   /* LS0..LS5, D0, D1, GS0..GS11, half of GS12: 66.375 k words */
    RAM_DRIVE   : origin = 0x018980, length = 0x001B80   /* the rest of GS12, GS13, a third of GS14 */
    RAM_CAPTURE : origin = 0x01A500, length = 0x000200   /* GS14 */
    RAM_BOX     : origin = 0x01A700, length = 0x000200   /* GS14 */
    RAM_DATA    : origin = 0x01A900, length = 0x0016F8   /* the rest of GS14, GS15 without its last 8 words (errata) */
}

SECTIONS
{
    codestart    : > BEGIN
    .TI.ramfunc  : > RAM_PROGRAM                         /* first: the interrupts */
    .switch      : > RAM_PROGRAM
    .text        : > RAM_PROGRAM
    .cinit       : > RAM_PROGRAM
    .init_array  : > RAM_PROGRAM
    .const       : > RAM_PROGRAM

    .stack       : > RAM_STACK, RUN_START(StackRunStart), RUN_SIZE(StackRunSize)
    .bss         : > RAM_DATA
    .data        : > RAM_DATA
    .bss:output  : > RAM_DATA
    drive_memory : > RAM_DRIVE
    capture_memory   : > RAM_CAPTURE
    black_box_memory : > RAM_BOX, TYPE = NOINIT          /* kept over a reset */
    kept_memory  : > RAM_DATA, TYPE = NOINIT

    .reset       : > RESET, TYPE = DSECT
}
