/* The drive on LAUNCHXL-F28379D with BOOSTXL-DRV8305EVM: order of start-up, two interrupts, main loop.
 *
 * Nothing but this file and hal/f28379d knows the board. The same file runs on the host in tests/hal, on a fake of the
 * driver library with the simulated motor behind it. */
#include "firmware/app/status.h"
#include "firmware/services/services.h"
#include "hal/f28379d/port.h"

#if PORT_PWM_HZ != DRIVE_PWM_HZ
#error "the port and the drive disagree about the PWM frequency"
#endif

/* 13 k words of learned waveforms and about 4 k words of state: RAM blocks GS8..GS12, see linker/; less in the RAM build, where
 * the program ends in GS10 and the observer's memory is smaller. */
#ifndef MAIN_DRIVE_REGION_WORDS
#define MAIN_DRIVE_REGION_WORDS 0x5000U
#endif
#ifdef __TMS320C28XX__
#pragma DATA_SECTION(drive, "drive_memory")
#endif
static drive_t drive;
typedef char   drive_fits_its_region[((sizeof(drive_t) / sizeof(uint16_t)) <= MAIN_DRIVE_REGION_WORDS) ? 1 : -1];

/* Recorders: the capture takes GS13..GS15, the black box GS7; both less in the RAM build, where code and data live there. */
#ifndef MAIN_CAPTURE_VALUES
#define MAIN_CAPTURE_VALUES 6140U
#endif
#ifndef MAIN_BLACK_BOX_VALUES
#define MAIN_BLACK_BOX_VALUES 2048U
#endif
#ifdef __TMS320C28XX__
#pragma DATA_SECTION(capture, "capture_memory")
#pragma DATA_SECTION(black_box, "black_box_memory")
#endif
static float capture[MAIN_CAPTURE_VALUES];
static float black_box[MAIN_BLACK_BOX_VALUES];

/* Neither is cleared by the C start-up (TYPE = NOINIT in linker/): after a reset without a loss of power they hold what was before. */
#ifdef __TMS320C28XX__
#pragma DATA_SECTION(services, "kept_memory")
#endif
static services_t     services;
static drive_params_t defaults; /* of this board */

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
    drive_watch_isr(&drive);
    services_sample(&services);
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

/** Everything up to the first interrupt. The bridge is off, and stays off until a start: by a client, or by auto_run in a stored
 *  set, which this board does not have. Alignment is part of the first start. */
port_status_t main_start(void)
{
    const port_status_t status = port_init();
    if (status == PORT_NO_CLOCK) {
        return status;
    }
    port_limits_t limits;
    params_default(&defaults);
    port_limits(&limits);
    defaults.encoder_counts = limits.encoder_counts;
    defaults.offset_limit_a = limits.offset_limit_a;
    defaults.over_current_a = limits.over_current_a;
    defaults.over_voltage_v = limits.over_voltage_v;
    defaults.over_speed_rad_s = limits.over_speed_rad_s;
    const services_setup_t setup = {&drive,    &defaults,           "LAUNCHXL-F28379D",    capture,
                                    black_box, MAIN_CAPTURE_VALUES, MAIN_BLACK_BOX_VALUES, hal_reset_cause()};
    services_start(&services, &setup);
    port_start(&main_current_isr, &main_speed_isr);
    return status;
}

/** One pass of the main loop. */
void main_pass(void)
{
    drive_background(&drive);
    services_pass(&services);
    port_background();
    drive_note_stack(&drive, port_stack_used());
}

int main(void)
{
    const port_status_t status = main_start();
    if (status == PORT_NO_CLOCK) { /* no link at this speed, and the gates were never connected */
        port_stop_with_code(status);
    }
    for (;;) { /* without a working trip as well: the bridge stays off for good, and the link reports why */
        main_pass();
    }
}
