/* eQEP1: position, index, and the time of the newest edge.
 *
 * Reading the position latches the capture timer, which every edge sets to zero: the edge was passed that many steps ago.
 * It is read 10000 times a second, long before the 16 bits of the capture timer wrap, so it counts at full resolution and
 * the edge time has the resolution of the CPU timer at every speed. An edge passed forth and back between two reads is
 * not seen; its position is the same. */
#include "hal/hal_encoder.h"

#include "hal/f28379d/parts.h"
#include "hal/hal_clock.h"

#define RAD_PER_COUNT (6.28318531f / (float)BOARD_ENCODER_COUNTS)

port_encoder_t            port_encoder;
static int32_t            unwrapped;
static hal_encoder_edge_t edge;
static uint32_t           errors_since_cyc; /* time of the first of the last few phase errors */
static uint16_t           errors;           /* number of these phase errors */
volatile uint32_t         port_encoder_errors;

void port_encoder_init(void)
{
    EQEP_setDecoderConfig(BOARD_EQEP_BASE, EQEP_CONFIG_QUADRATURE | EQEP_CONFIG_2X_RESOLUTION | EQEP_CONFIG_NO_SWAP);
    EQEP_setEmulationMode(BOARD_EQEP_BASE, EQEP_EMULATIONMODE_RUNFREE);
    EQEP_setPositionCounterConfig(BOARD_EQEP_BASE, EQEP_POSITION_RESET_MAX_POS, BOARD_ENCODER_COUNTS - 1U);
    EQEP_setPosition(BOARD_EQEP_BASE, 0U);
    EQEP_setLatchMode(BOARD_EQEP_BASE, EQEP_LATCH_CNT_READ_BY_CPU | EQEP_LATCH_RISING_INDEX);
    EQEP_setCaptureConfig(BOARD_EQEP_BASE, BOARD_CAPTURE_DIVIDER, EQEP_UNIT_POS_EVNT_DIV_1);
    EQEP_enableCapture(BOARD_EQEP_BASE);
    EQEP_clearInterruptStatus(BOARD_EQEP_BASE, EQEP_INT_PHASE_ERROR | EQEP_INT_INDEX_EVNT_LATCH);
    EQEP_enableModule(BOARD_EQEP_BASE);

    const hal_encoder_edge_t none = {0, 0U, 0U, 0.0f};
    edge = none;
    edge.edge_cyc = hal_clock_cyc();
    port_encoder.position = 0U;
    port_encoder.at_cyc = edge.edge_cyc;
    port_encoder.failed = false;
    unwrapped = 0;
    errors = 0U;
    port_encoder_errors = 0U;
}

/* Whether this phase error is one too many. */
BOARD_RAM_CODE static bool too_many(uint32_t now_cyc)
{
    port_encoder_errors++;
    if ((errors == 0U) || ((now_cyc - errors_since_cyc) > BOARD_PHASE_ERROR_CYC)) {
        errors_since_cyc = now_cyc;
        errors = 0U;
    }
    errors++;
    if (errors < BOARD_PHASE_ERRORS) {
        return false;
    }
    errors = 0U;
    return true;
}

/* Counts from one position to another, by the shorter arc. */
BOARD_RAM_CODE static int32_t shortest_travel(uint32_t from, uint32_t to)
{
    int32_t travel = (int32_t)to - (int32_t)from;
    if (travel > (int32_t)(BOARD_ENCODER_COUNTS / 2U)) {
        travel -= (int32_t)BOARD_ENCODER_COUNTS;
    } else if (travel < -(int32_t)(BOARD_ENCODER_COUNTS / 2U)) {
        travel += (int32_t)BOARD_ENCODER_COUNTS;
    }
    return travel;
}

BOARD_RAM_CODE void port_encoder_latch(void)
{
    const uint32_t now_cyc = hal_clock_cyc();
    const uint32_t read = EQEP_getPosition(BOARD_EQEP_BASE); /* latches the capture timer */
    const uint16_t since = EQEP_getCaptureTimerLatch(BOARD_EQEP_BASE);
    const int32_t  moved = shortest_travel(port_encoder.position, read);

    port_encoder.position = read;
    port_encoder.at_cyc = now_cyc;
    if (moved != 0) {
        unwrapped = (int32_t)((uint32_t)unwrapped + (uint32_t)moved); /* wraps at 2^32 */
        /* upwards the edge lies at the count it leads to, downwards at the one it came from */
        const uint32_t down = (EQEP_getDirection(BOARD_EQEP_BASE) < 0) ? 1U : 0U;
        edge.edge_count = (int32_t)((uint32_t)unwrapped + down);
        edge.edge_cyc = now_cyc - ((uint32_t)since * BOARD_CAPTURE_CYC);
    }

    const uint16_t events = EQEP_getInterruptStatus(BOARD_EQEP_BASE);
    if ((events & EQEP_INT_INDEX_EVNT_LATCH) != 0U) {
        edge.index_rad = (float)EQEP_getIndexPositionLatch(BOARD_EQEP_BASE) * RAD_PER_COUNT;
        edge.index_passes = (uint16_t)((edge.index_passes < UINT16_MAX) ? (edge.index_passes + 1U) : 1U);
        EQEP_clearInterruptStatus(BOARD_EQEP_BASE, EQEP_INT_INDEX_EVNT_LATCH);
    }
    port_encoder.failed = false;
    if ((events & EQEP_INT_PHASE_ERROR) != 0U) {
        EQEP_clearInterruptStatus(BOARD_EQEP_BASE, EQEP_INT_PHASE_ERROR);
        port_encoder.failed = too_many(now_cyc);
    }
}

BOARD_RAM_CODE hal_status_t hal_encoder_edge(hal_encoder_edge_t *out)
{
    const bool were_off = Interrupt_disableGlobal(); /* the current interrupt latches a newer one */
    *out = edge;
    if (!were_off) {
        (void)Interrupt_enableGlobal();
    }
    return port_encoder.failed ? HAL_SENSOR_FAULT : HAL_OK;
}
