# TMS320F28379D with TI's compiler cl2000 (EABI, FPU32, TMU0): `cmake --preset c2000`.
#
#   C2000ROOT        folder of the compiler, with bin/cl2000 in it
#   C2000WARE_ROOT   folder of C2000Ware (or of the C2000Ware core SDK), with driverlib/f2837xd and device_support/f2837xd in it
#
# Both may be environment variables or -D options. Neither is part of this repository. No build with TI's tools has been
# made by the authors: options marked [mem] are from memory of the compiler guide.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR c28x)

foreach(name IN ITEMS C2000ROOT C2000WARE_ROOT)
  if(NOT DEFINED ${name} AND DEFINED ENV{${name}})
    set(${name} "$ENV{${name}}")
  endif()
  set(${name} "${${name}}" CACHE PATH "See cmake/ti-c2000.cmake")
endforeach()
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES C2000ROOT C2000WARE_ROOT)

set(c2000_help "
  1. Compiler: install TI C2000 code generation tools 22.6 LTS or newer (free, from ti.com; also inside Code Composer
     Studio, ccs/tools/compiler/ti-cgt-c2000_*), and set C2000ROOT to its folder, the one that holds bin/cl2000.
  2. Library: install C2000Ware, or clone the C2000Ware core SDK, and set C2000WARE_ROOT to its folder, the one that
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

string(JOIN " " CMAKE_C_FLAGS_INIT
  "-v28 -ml -mt"             # C28x, large model, unified memory
  "--abi=eabi"               # ELF; without it the tool makes COFF
  "--float_support=fpu32"
  "--tmu_support=tmu0"
  "--fp_mode=relaxed"        # lets / and sqrtf become TMU instructions; in strict mode they are library calls
  "--rpt_threshold=16"       # a repeated instruction cannot be interrupted: a copied structure would delay the latch of the angle
  "--cla_support=cla1 --vcu_support=vcu2" # what the silicon has
  "--gen_func_subsections=on"
  "--diag_warning=225 --display_error_number --diag_suppress=10063"
  "--define=CPU1 --define=_LAUNCHXL_F28379D" # without the second the SDK assumes another crystal
  "--include_path=${C2000ROOT}/include")
set(CMAKE_C_FLAGS_DEBUG_INIT "--opt_level=off -g --define=DEBUG")
set(CMAKE_C_FLAGS_RELEASE_INIT "--opt_level=2 --opt_for_speed=4")
set(CMAKE_C_FLAGS_RELWITHDEBINFO_INIT "--opt_level=2 --opt_for_speed=4 -g")

set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
