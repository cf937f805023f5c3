; The first two words that run: the boot ROM jumps here. The watchdog goes off before the C start-up, because clearing
; the memory of the drive can outlast it.
        .global code_start
        .global _c_int00

        .sect   "codestart"
        .retain
code_start:
        LB      watchdog_off

        .sect   ".text"
watchdog_off:
        SETC    OBJMODE                 ; C28x object mode
        EALLOW
        MOVZ    DP, #7029h>>6           ; WDCR at 0x7029
        MOV     @7029h, #0068h          ; disabled, with the check bits
        EDIS
        LB      _c_int00
        .end
