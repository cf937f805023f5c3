# TMS320F28379D with TI's compiler cl2000 (EABI, FPU32, TMU0): `cmake --preset c2000`.
#
#   C2000ROOT        folder of the compiler, with bin/cl2000 in it
#   C2000WARE_ROOT   folder of C2000Ware (or of the C2000Ware core SDK), with driverlib/f2837xd and device_support/f2837xd in it
#
# Both may be environment variables or -D options, with blanks or backslashes in them. Neither is part of this repository.
# No build with TI's tools has been made by the authors. C2000Ware must be 5.00 or newer, see hal/f28379d/CMakeLists.txt.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR c28x)

foreach(name IN ITEMS C2000ROOT C2000WARE_ROOT)
  if(NOT DEFINED ${name} AND DEFINED ENV{${name}})
    set(${name} "$ENV{${name}}")
  endif()
  string(REPLACE "\\" "/" ${name} "${${name}}") # as Windows writes them; in a flag a backslash would be eaten
  set(${name} "${${name}}" CACHE PATH "See cmake/ti-c2000.cmake" FORCE)
endforeach()
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES C2000ROOT C2000WARE_ROOT)

set(c2000_help "
  1. Compiler: install TI C2000 code generation tools 22.6 LTS or newer (free, from ti.com; also inside Code Composer
     Studio, ccs/tools/compiler/ti-cgt-c2000_*), and set C2000ROOT to its folder, the one that holds bin/cl2000.
  2. Library: install C2000Ware 5.00 or newer, or clone the C2000Ware core SDK, and set C2000WARE_ROOT to its folder, the one that
     holds driverlib/f2837xd and device_support/f2837xd.
  3. cmake --preset c2000 && cmake --build --preset c2000
  The tests of the port need neither: cmake --preset host.")

if(NOT EXISTS "${C2000ROOT}/bin/cl2000" AND NOT EXISTS "${C2000ROOT}/bin/cl2000.exe")
  message(FATAL_ERROR "C2000ROOT = \"${C2000ROOT}\": there is no bin/cl2000.${c2000_help}")
endif()
foreach(part IN ITEMS driverlib/f2837xd device_support/f2837xd)
  if(NOT EXISTS "${C2000WARE_ROOT}/${part}")
    message(FATAL_ERROR "C2000WARE_ROOT = \"${C2000WARE_ROOT}\": there is no ${part}.${c2000_help}")
  endif()
endforeach()

find_program(CMAKE_C_COMPILER NAMES cl2000 PATHS "${C2000ROOT}/bin" NO_DEFAULT_PATH REQUIRED)
find_program(CMAKE_AR NAMES ar2000 PATHS "${C2000ROOT}/bin" NO_DEFAULT_PATH REQUIRED)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)

# Every call of the tools needs these, the assembler and the linker, too: without --abi=eabi the versions before 25.11 make
# COFF, and a link of both is an error.
string(JOIN " " c2000_machine
  "-v28 -ml -mt"             # C28x, large model, unified memory
  "--abi=eabi"               # ELF
  "--float_support=fpu32"
  "--tmu_support=tmu0"
  "--cla_support=cla1 --vcu_support=vcu2") # what the silicon has
set(CMAKE_ASM_FLAGS_INIT "${c2000_machine}")
string(JOIN " " CMAKE_C_FLAGS_INIT
  "${c2000_machine}"
  "--fp_mode=relaxed"        # lets / and sqrtf become TMU instructions; in strict mode they are library calls
  "--rpt_threshold=16"       # a repeated instruction cannot be interrupted: a copied structure would delay the latch of the angle
  "--gen_func_subsections=on"
  "--diag_warning=225 --display_error_number --diag_suppress=10063"
  "--define=CPU1 --define=_LAUNCHXL_F28379D" # without the second the SDK assumes another crystal
  "\"--include_path=${C2000ROOT}/include\"")
set(CMAKE_C_FLAGS_DEBUG_INIT "--opt_level=off -g --define=DEBUG") # DEBUG: the assertions of driverlib, hal/f28379d/assertion.c
set(CMAKE_C_FLAGS_RELEASE_INIT "--opt_level=2 --opt_for_speed=4")
set(CMAKE_C_FLAGS_RELWITHDEBINFO_INIT "--opt_level=2 --opt_for_speed=4 -g")

set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
