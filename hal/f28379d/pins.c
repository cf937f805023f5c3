/* Pins. Latches are written before directions, so that no output starts with the wrong level. */
#include "hal/f28379d/parts.h"

static void output(uint32_t config, uint32_t pin, uint32_t level)
{
    GPIO_setControllerCore(pin, GPIO_CORE_CPU1);
    GPIO_setPadConfig(pin, GPIO_PIN_TYPE_STD);
    GPIO_writePin(pin, level);
    GPIO_setPinConfig(config);
    GPIO_setDirectionMode(pin, GPIO_DIR_MODE_OUT);
}

static void input(uint32_t config, uint32_t pin, uint32_t type, GPIO_QualificationMode qualification)
{
    GPIO_setControllerCore(pin, GPIO_CORE_CPU1);
    GPIO_setDirectionMode(pin, GPIO_DIR_MODE_IN);
    GPIO_setPadConfig(pin, type);
    GPIO_setQualificationMode(pin, qualification);
    GPIO_setPinConfig(config);
}

void port_pins_init(void)
{
    output(GPIO_124_GPIO124, BOARD_PIN_EN_GATE, 0U);
    output(GPIO_125_GPIO125, BOARD_PIN_WAKE, 0U);
    output(GPIO_61_GPIO61, BOARD_PIN_CHIP_SELECT, 1U);
    output(GPIO_67_GPIO67, BOARD_PIN_PROBE, 0U);
    input(GPIO_19_GPIO19, BOARD_PIN_NFAULT, GPIO_PIN_TYPE_PULLUP, GPIO_QUAL_ASYNC); /* to the trip zone without a clock */

    GPIO_setPinConfig(GPIO_58_SPISIMOA);
    GPIO_setPinConfig(GPIO_59_SPISOMIA);
    GPIO_setPinConfig(GPIO_60_SPICLKA);
    GPIO_setQualificationMode(58U, GPIO_QUAL_ASYNC);
    GPIO_setQualificationMode(59U, GPIO_QUAL_ASYNC);
    GPIO_setQualificationMode(60U, GPIO_QUAL_ASYNC);

    input(GPIO_43_SCIRXDA, BOARD_PIN_SCI_RX, GPIO_PIN_TYPE_PULLUP, GPIO_QUAL_ASYNC);
    GPIO_setPinConfig(GPIO_42_SCITXDA);

    /* no pull-ups: the level shifter of the LaunchPad drives through some kilohms and wants more than 50 kohm behind it [check] */
    input(GPIO_20_EQEP1A, BOARD_PIN_QEP_A, GPIO_PIN_TYPE_STD, GPIO_QUAL_6SAMPLE);
    input(GPIO_21_EQEP1B, BOARD_PIN_QEP_B, GPIO_PIN_TYPE_STD, GPIO_QUAL_6SAMPLE);
    input(GPIO_99_EQEP1I, BOARD_PIN_QEP_I, GPIO_PIN_TYPE_STD, GPIO_QUAL_6SAMPLE);
    GPIO_setQualificationPeriod(BOARD_PIN_QEP_A, BOARD_QEP_FILTER_SYSCLK);
    GPIO_setQualificationPeriod(BOARD_PIN_QEP_B, BOARD_QEP_FILTER_SYSCLK);
    GPIO_setQualificationPeriod(BOARD_PIN_QEP_I, BOARD_QEP_FILTER_SYSCLK);
}

void port_pins_connect_gates(void)
{
    static const uint32_t CONFIG[] = BOARD_PWM_PIN_CONFIGS;
    for (uint16_t pin = BOARD_PIN_PWM_FIRST; pin <= BOARD_PIN_PWM_LAST; pin++) {
        GPIO_setPadConfig(pin, GPIO_PIN_TYPE_STD); /* no pull-up: a pull-up would switch the gate on */
        GPIO_setPinConfig(CONFIG[pin - BOARD_PIN_PWM_FIRST]);
    }
}
