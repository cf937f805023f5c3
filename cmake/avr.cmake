# AVR: int of 16 bits, as on the C28x. What control/ and firmware/ get wrong with it shows here; nothing runs on a real one.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR avr)

set(CMAKE_C_COMPILER avr-gcc)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)

# -O2: the optimiser uses what is undefined. The part with the most flash; its data memory is extended by tests/target/avr.
# drive_t with its whole memory is larger than an object may be for this compiler, where a size is an int of 16 bits.
set(CMAKE_C_FLAGS_INIT "-mmcu=atmega2560 -O2 -ffunction-sections -fdata-sections -DDRIVE_OBSERVER_CAPACITY=5120U")

set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
