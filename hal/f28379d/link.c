/* SCI A. The current interrupt moves octets between the FIFOs of 16 and two rings: at 625000 baud 6.25 octets come in a
 * period, and the main loop may be away for 8 ms before one is lost. */
#include "hal/hal_link.h"

#include "hal/f28379d/parts.h"
#include "hal/hal_order.h"

#define RING 512U /* octets; a power of 2 */
#define PUMP 8U   /* octets a period in each direction: more than the line carries */

/* One side writes `written`, the other `taken`; both run freely. */
typedef struct {
    uint16_t          octet[RING];
    volatile uint16_t written, taken;
} ring_t;

static ring_t            in, out;
static volatile uint32_t lost;

static uint16_t filled(const ring_t *r) { return (uint16_t)(r->written - r->taken); }

void port_link_init(void)
{
    in.written = 0U;
    in.taken = 0U;
    out.written = 0U;
    out.taken = 0U;
    lost = 0U;
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

/* ---- current interrupt ----------------------------------------------------------------------------------------------- */

/* An unplugged terminal is a break, and a break locks the receiver until a reset. */
BOARD_RAM_CODE static void recover(void)
{
    if ((SCI_getRxStatus(BOARD_SCI_BASE) & (SCI_RXSTATUS_ERROR | SCI_RXSTATUS_BREAK)) != 0U) {
        SCI_performSoftwareReset(BOARD_SCI_BASE);
    }
    if (SCI_getOverflowStatus(BOARD_SCI_BASE)) {
        SCI_clearOverflowStatus(BOARD_SCI_BASE);
        SCI_resetRxFIFO(BOARD_SCI_BASE); /* what is left has a hole: the frame check would refuse it anyway */
        lost++;
    }
}

BOARD_RAM_CODE void port_link_pump(void)
{
    recover();
    for (uint16_t i = 0U; (i < PUMP) && (SCI_getRxFIFOStatus(BOARD_SCI_BASE) != SCI_FIFO_RX0); i++) {
        const uint16_t octet = SCI_readCharNonBlocking(BOARD_SCI_BASE) & 0xFFU;
        if (filled(&in) < RING) {
            in.octet[in.written & (RING - 1U)] = octet;
            in.written++;
        } else {
            lost++;
        }
    }
    for (uint16_t i = 0U; (i < PUMP) && (filled(&out) > 0U) && ((uint16_t)SCI_getTxFIFOStatus(BOARD_SCI_BASE) < BOARD_LINK_FIFO);
         i++) {
        SCI_writeCharNonBlocking(BOARD_SCI_BASE, out.octet[out.taken & (RING - 1U)]);
        out.taken++;
    }
}

/* ---- main loop ------------------------------------------------------------------------------------------------------- */

uint16_t hal_link_read(uint16_t *octets, uint16_t limit)
{
    uint16_t n = 0U;
    while ((n < limit) && (filled(&in) > 0U)) {
        hal_order();
        octets[n] = in.octet[in.taken & (RING - 1U)];
        hal_order();
        in.taken++;
        n++;
    }
    return n;
}

uint32_t hal_link_lost(void) { return lost; }

uint16_t hal_link_write(const uint16_t *octets, uint16_t count)
{
    uint16_t n = 0U;
    while ((n < count) && (filled(&out) < RING)) {
        out.octet[out.written & (RING - 1U)] = octets[n] & 0xFFU;
        hal_order();
        out.written++;
        n++;
    }
    return n;
}
