# Warnings, which are errors for everybody who works on the code. A library takes them with target_link_libraries(<name> PRIVATE <set>):
#
#   project_warnings   code that runs on the chip: every conversion is written out, nothing becomes a double
#   host_warnings      host-only code, which calculates in double
include_guard(GLOBAL)

option(EVENSPIN_WERROR "Warnings are errors; off when a package is built by a compiler that nobody here has tried" ON)

set(common -Wall -Wextra -Wpedantic -Wshadow -Wundef -Wcast-qual -Wstrict-prototypes -Wmissing-prototypes)
if(EVENSPIN_WERROR)
  list(APPEND common -Werror)
endif()

add_library(project_warnings INTERFACE)
target_compile_options(project_warnings INTERFACE
  ${common} -Wconversion -Wdouble-promotion -Wfloat-conversion)

add_library(host_warnings INTERFACE)
target_compile_options(host_warnings INTERFACE ${common})

unset(common)
