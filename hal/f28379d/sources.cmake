# The files of the port, for the chip (hal/f28379d/CMakeLists.txt) and for the tests on the host (tests/hal).
set(F28379D_SOURCES assertion.c clock.c encoder.c gate_driver.c guard.c health.c interrupts.c led.c limits.c link.c order.c pins.c pwm.c
    sampling.c self_test.c self_test_places.c self_test_processor.c self_test_program.c self_test_ram.c stack.c storage.c system.c trip.c watchdog.c)
list(TRANSFORM F28379D_SOURCES PREPEND ${CMAKE_CURRENT_LIST_DIR}/)
