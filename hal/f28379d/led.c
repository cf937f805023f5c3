/* Two diodes of the LaunchPad. Red flashes a number and pauses; blue is on while the bridge is armed. */
#include "hal/f28379d/parts.h"
#include "hal/hal_clock.h"

#define FLASH_CYC UINT32_C(60000000) /* 0.3 s a step, on and off; the pause is four steps */
#define FLASH_US UINT32_C(15000)     /* the same at the 10 MHz that are left without a PLL */
#define PAUSE_STEPS 4U
#define LED_ON 0U
#define LED_OFF 1U

static uint32_t stepped_cyc;
static uint16_t step;

void port_led_init(void)
{
    GPIO_writePin(BOARD_PIN_LED_RED, LED_OFF);
    GPIO_writePin(BOARD_PIN_LED_BLUE, LED_OFF);
    GPIO_setPinConfig(GPIO_34_GPIO34);
    GPIO_setPinConfig(GPIO_31_GPIO31);
    GPIO_setDirectionMode(BOARD_PIN_LED_RED, GPIO_DIR_MODE_OUT);
    GPIO_setDirectionMode(BOARD_PIN_LED_BLUE, GPIO_DIR_MODE_OUT);
    stepped_cyc = hal_clock_cyc();
    step = 0U;
}

/* Step 0, 2, 4, ... of a code are on. */
static uint32_t level_of(uint16_t code, uint16_t at) { return ((at < (2U * code)) && ((at & 1U) == 0U)) ? LED_ON : LED_OFF; }

static uint16_t after(uint16_t code, uint16_t at) { return ((at + 1U) < ((2U * code) + PAUSE_STEPS)) ? (uint16_t)(at + 1U) : 0U; }

void port_led_show(uint16_t code, bool on)
{
    if ((hal_clock_cyc() - stepped_cyc) >= FLASH_CYC) {
        stepped_cyc += FLASH_CYC;
        step = after(code, step);
    }
    GPIO_writePin(BOARD_PIN_LED_RED, level_of(code, step));
    GPIO_writePin(BOARD_PIN_LED_BLUE, on ? LED_ON : LED_OFF);
}

void port_stop_with_code(port_status_t status)
{
    port_led_init();
    for (uint16_t at = 0U;; at = after((uint16_t)status, at)) {
        GPIO_writePin(BOARD_PIN_LED_RED, level_of((uint16_t)status, at));
        SysCtl_delay(BOARD_US(FLASH_US));
        NOP;
    }
}
