/* linker/f28379d_ram.cmd: everything in RAM, for the debugger: loads in a second and wears no flash. TMS320F28379D, CPU1.
 *
 * The program is lost at power-off and does not start by itself. Nothing is copied, so load and run addresses are the
 * same and _FLASH is not defined. Code lies in LS0..GS6, data elsewhere, for the reasons in f28379d_flash.cmd; the capture has
 * one block, 256 rows of 8 signals. */

MEMORY
{
    BEGIN       : origin = 0x000000, length = 0x000002
    RESET       : origin = 0x3FFFC0, length = 0x000002

    BOOT_RSVD   : origin = 0x000002, length = 0x000121
    RAMM0       : origin = 0x000123, length = 0x0002DD
    RAMM1       : origin = 0x000400, length = 0x0003F8
    RAM_PROGRAM : origin = 0x008000, length = 0x00B000   /* LS0..LS5, D0, D1, GS0..GS6: 44 k words */
    RAM_BOX     : origin = 0x013000, length = 0x001000   /* GS7 */
    RAM_DRIVE   : origin = 0x014000, length = 0x005000   /* GS8..GS12 */
    RAM_CAPTURE : origin = 0x019000, length = 0x001000   /* GS13 */
    RAM_DATA    : origin = 0x01A000, length = 0x001FF8   /* GS14, GS15 without its last 8 words (errata) */
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

    .stack       : > RAMM1
    .bss         : > RAM_DATA
    .data        : > RAM_DATA
    .bss:output  : > RAM_DATA
    drive_memory : > RAM_DRIVE
    capture_memory   : > RAM_CAPTURE
    black_box_memory : > RAM_BOX

    .reset       : > RESET, TYPE = DSECT
}
