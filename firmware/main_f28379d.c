/* The drive on LAUNCHXL-F28379D with BOOSTXL-DRV8305EVM: order of start-up, two interrupts, main loop.
 *
 * Nothing but this file and hal/f28379d knows the board. The same file runs on the host in tests/hal, on a fake of the
 * driver library with the simulated motor behind it. */
#include "firmware/app/drive.h"
#include "hal/f28379d/port.h"

#if PORT_PWM_HZ != DRIVE_PWM_HZ
#error "the port and the drive disagree about the PWM frequency"
#endif

/* 13 k words of learned waveforms and about 3 k words of state: RAM blocks GS8..GS12, see linker/. */
#define DRIVE_REGION_WORDS 0x5000U
#ifdef __TMS320C28XX__
#pragma DATA_SECTION(drive, "drive_memory")
#endif
static drive_t drive;
typedef char drive_fits_its_region[((sizeof(drive_t) / sizeof(uint16_t)) <= DRIVE_REGION_WORDS) ? 1 : -1];

int           main(void);
PORT_ISR void main_current_isr(void);
PORT_ISR void main_speed_isr(void);
port_status_t main_start(void);
void          main_pass(void);
drive_t      *main_drive(void);

PORT_RAM_CODE PORT_ISR void main_current_isr(void)
{
    port_current_begin();
    drive_current_isr(&drive);
    port_current_end();
}

PORT_RAM_CODE PORT_ISR void main_speed_isr(void)
{
    port_speed_begin(); /* from here on the current interrupt preempts this one */
    drive_speed_isr(&drive);
    port_speed_end();
}

/** The drive of this program, for tests and debuggers. */
drive_t *main_drive(void) { return &drive; }

/** Everything up to the first interrupt. The bridge is off, and stays off until a start command. */
port_status_t main_start(void)
{
    const port_status_t status = port_init();
    if (status != PORT_OK) {
        return status;
    }
    static drive_params_t params; /* 260 words: the stack has 1016 */
    port_limits_t  limits;
    params_default(&params);
    port_limits(&limits);
    params.encoder_counts = limits.encoder_counts;
    params.offset_limit_a = limits.offset_limit_a;
    params.over_current_a = limits.over_current_a;
    params.over_voltage_v = limits.over_voltage_v;
    drive_init(&drive, &params);
    port_start(&main_current_isr, &main_speed_isr);
    return PORT_OK;
}

/** One pass of the main loop. */
void main_pass(void)
{
    drive_background(&drive);
    port_background();
}

int main(void)
{
    const port_status_t status = main_start();
    while (status == PORT_OK) {
        main_pass();
    }
    for (;;) { /* no clock or no trip: the gates were never connected, and nothing else is safe to do */
    }
}
