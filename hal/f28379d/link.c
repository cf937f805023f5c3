/* SCI A, polled: the main loop comes by more often than the 16 octets of the FIFO last (1.4 ms at 115200 baud). */
#include "hal/hal_link.h"

#include "hal/f28379d/parts.h"

void port_link_init(void)
{
    SCI_performSoftwareReset(BOARD_SCI_BASE);
    SCI_setConfig(BOARD_SCI_BASE, BOARD_LSPCLK_HZ, BOARD_LINK_BAUD,
                  (uint32_t)SCI_CONFIG_WLEN_8 | (uint32_t)SCI_CONFIG_STOP_ONE | (uint32_t)SCI_CONFIG_PAR_NONE);
    SCI_resetChannels(BOARD_SCI_BASE);
    SCI_enableFIFO(BOARD_SCI_BASE);
    SCI_resetRxFIFO(BOARD_SCI_BASE);
    SCI_resetTxFIFO(BOARD_SCI_BASE);
    SCI_enableModule(BOARD_SCI_BASE);
    SCI_performSoftwareReset(BOARD_SCI_BASE);
}

/* An unplugged terminal is a break, and a break locks the receiver until a reset. */
static void recover(void)
{
    if ((SCI_getRxStatus(BOARD_SCI_BASE) & (SCI_RXSTATUS_ERROR | SCI_RXSTATUS_BREAK)) != 0U) {
        SCI_performSoftwareReset(BOARD_SCI_BASE);
    }
    if (SCI_getOverflowStatus(BOARD_SCI_BASE)) {
        SCI_clearOverflowStatus(BOARD_SCI_BASE);
        SCI_resetRxFIFO(BOARD_SCI_BASE); /* what is left has a hole: the frame check would refuse it anyway */
    }
}

uint16_t hal_link_read(uint16_t *octets, uint16_t limit)
{
    uint16_t n = 0U;
    recover();
    while ((n < limit) && (SCI_getRxFIFOStatus(BOARD_SCI_BASE) != SCI_FIFO_RX0)) {
        octets[n] = SCI_readCharNonBlocking(BOARD_SCI_BASE) & 0xFFU;
        n++;
    }
    return n;
}

uint16_t hal_link_write(const uint16_t *octets, uint16_t count)
{
    uint16_t n = 0U;
    while ((n < count) && ((uint16_t)SCI_getTxFIFOStatus(BOARD_SCI_BASE) < BOARD_LINK_FIFO)) {
        SCI_writeCharNonBlocking(BOARD_SCI_BASE, octets[n] & 0xFFU);
        n++;
    }
    return n;
}
