/**
 * @file  tests/target/avr/run_avr.c
 * @brief Runs one AVR program to its end: prints what it writes, exits with its status.
 *
 *     run_avr <mcu> <program.elf> [<million cycles>]
 *
 * The program writes characters to GPIOR0 and its exit status to GPIOR1 (tests/target/avr/target.c). Data memory is 64 KiB,
 * as on a part with external memory: the tests need more than the 8 KiB inside, and what is tried here is the compiler.
 * Exit status: that of the program; 124 when it did not end in time, 125 when it could not run or crashed.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <simavr/avr_ioport.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>

#define GPIOR0_ADDRESS 0x3e
#define GPIOR1_ADDRESS 0x4a
#define DATA_END 0xffff

static int  status = -1;
static void write_char(struct avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    (void)avr;
    (void)address;
    (void)param;
    (void)putchar(value);
}

static void write_exit(struct avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    (void)address;
    (void)param;
    status = value;
    avr->state = cpu_Done;
}

static void quiet(avr_t *avr, const int level, const char *format, va_list arguments)
{
    (void)avr;
    if (level <= LOG_ERROR) {
        (void)vfprintf(stderr, format, arguments);
    }
}

int main(int argc, char **argv)
{
    if (argc < 3) {
        (void)fprintf(stderr, "run_avr <mcu> <program.elf> [<million cycles>]\n");
        return 125;
    }
    const unsigned long long limit = ((argc > 3) ? strtoull(argv[3], NULL, 10) : 20000ULL) * 1000000ULL;
    elf_firmware_t           firmware;
    (void)memset(&firmware, 0, sizeof firmware);
    avr_global_logger_set(quiet);
    avr_t *const avr = avr_make_mcu_by_name(argv[1]);
    if ((avr == NULL) || (elf_read_firmware(argv[2], &firmware) != 0)) {
        (void)fprintf(stderr, "run_avr: no part %s, or %s is not a program\n", argv[1], argv[2]);
        return 125;
    }
    avr->ramend = DATA_END;
    (void)avr_init(avr);
    avr->run_cycle_limit = 1000U; /* cycles between two looks at the timers, which nothing here uses */
    avr->frequency = 16000000U;
    avr_load_firmware(avr, &firmware);
    avr_register_io_write(avr, GPIOR0_ADDRESS, write_char, NULL);
    avr_register_io_write(avr, GPIOR1_ADDRESS, write_exit, NULL);

    int state = cpu_Running;
    while ((status < 0) && (state != cpu_Done) && (state != cpu_Crashed) && (avr->cycle < limit)) {
        state = avr_run(avr);
    }
    (void)fflush(stdout);
    if (status >= 0) {
        return status;
    }
    (void)fprintf(stderr, "run_avr: %s after %llu cycles\n", (state == cpu_Crashed) ? "crashed" : "did not end",
                  (unsigned long long)avr->cycle);
    return (state == cpu_Crashed) ? 125 : 124;
}
