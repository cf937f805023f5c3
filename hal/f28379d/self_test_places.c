/* Where the linker has put what is tested: linker/f28379d_flash.cmd. */
#include "hal/f28379d/self_test.h"

#if defined(_FLASH)

/* Addresses; a size is the address of its symbol. */
extern uint16_t RamfuncsLoadStart, RamfuncsLoadSize, RamfuncsRunStart;
extern uint16_t SwitchLoadStart, SwitchLoadSize, SwitchRunStart;
extern uint16_t DriveRunStart, DriveRunSize;
extern uint16_t CaptureRunStart, CaptureRunSize;
extern uint16_t BoxRunStart, BoxRunSize;
extern uint16_t DataRunStart, DataRunSize;
extern uint16_t KeptRunStart, KeptRunSize;

extern CRC_TABLE program_sums;

#define ADDRESS(symbol) ((uint32_t)(uintptr_t)&(symbol))

const port_places_t *port_self_test_places(void)
{
    static port_region_t ram[5];
    static port_copy_t   copy[2];
    static port_places_t places;
    ram[0].first = ADDRESS(DriveRunStart);
    ram[0].words = ADDRESS(DriveRunSize);
    ram[1].first = ADDRESS(CaptureRunStart);
    ram[1].words = ADDRESS(CaptureRunSize);
    ram[2].first = ADDRESS(BoxRunStart);
    ram[2].words = ADDRESS(BoxRunSize);
    ram[3].first = ADDRESS(DataRunStart);
    ram[3].words = ADDRESS(DataRunSize);
    ram[4].first = ADDRESS(KeptRunStart);
    ram[4].words = ADDRESS(KeptRunSize);
    copy[0].run = ADDRESS(RamfuncsRunStart);
    copy[0].load = ADDRESS(RamfuncsLoadStart);
    copy[0].words = ADDRESS(RamfuncsLoadSize);
    copy[1].run = ADDRESS(SwitchRunStart);
    copy[1].load = ADDRESS(SwitchLoadStart);
    copy[1].words = ADDRESS(SwitchLoadSize);
    places.fresh = ram; /* drive and capture: set up after the test */
    places.fresh_count = 2U;
    places.ram = ram;
    places.ram_count = 5U;
    places.copy = copy;
    places.copy_count = 2U;
    places.sums = &program_sums;
    places.operands = &port_operands;
    return &places;
}

#endif
