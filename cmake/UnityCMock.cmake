# Unit tests with Unity and CMock.
#
#   drive_test(<name> [UNDER_TEST <base target>...] [MOCKS <header>...] [SOURCES <file>...])
#
#   <name>       <name>.c, in this folder or below it, holds the tests: void test_<module>_<situation>_<outcome>(void).
#   UNDER_TEST   Base names of the libraries under test. Where a library exists once per numeric (control_float,
#                control_fixed), so does the test: <name>_float and <name>_fixed. A test of libraries without a numeric
#                is built once, as <name>.
#   MOCKS        Headers of hal/include/hal/ to replace; the test includes "mock_<header>".
#   SOURCES      More C files, relative to this folder.
#
# Every executable is one ctest test, labelled with its folder below tests/ ("control", "firmware", ...); the target tests_<folder>
# builds those of a folder.
# Tests include what they need relative to the root of the repository, "control/repetitive/fal.h", and the HAL
# as "hal/hal_sample.h".
# Ruby without its packages starts in less than half the time, and it starts a hundred times.
include_guard(GLOBAL)

set(CMOCK_DIR /usr/share/cmock CACHE PATH "CMock with its Unity; fetched when it is not there")
include(TestRunners)

if(NOT EXISTS ${CMOCK_DIR}/lib/cmock.rb)
  message(STATUS "CMock is not in ${CMOCK_DIR}: fetching release 2.6.0")
  include(FetchContent)
  FetchContent_Declare(cmock_upstream
    GIT_REPOSITORY https://github.com/ThrowTheSwitch/CMock.git
    GIT_TAG 49435d9f3313abb3422252d3d2dc12a7542332ca # v2.6.0; names the commit of Unity as well
    GIT_SUBMODULES vendor/unity
    SOURCE_SUBDIR this-project-needs-no-build-of-its-own)
  FetchContent_MakeAvailable(cmock_upstream)
  set(cmock_dir ${cmock_upstream_SOURCE_DIR})
else()
  set(cmock_dir ${CMOCK_DIR})
endif()
set_property(GLOBAL PROPERTY drive_test_cmock_dir ${cmock_dir})

add_library(unity STATIC ${cmock_dir}/vendor/unity/src/unity.c)
target_include_directories(unity SYSTEM PUBLIC ${cmock_dir}/vendor/unity/src)
target_compile_definitions(unity PUBLIC UNITY_INCLUDE_DOUBLE)

add_library(cmock STATIC ${cmock_dir}/src/cmock.c)
target_include_directories(cmock SYSTEM PUBLIC ${cmock_dir}/src)
target_link_libraries(cmock PUBLIC unity)

# What the tests are compiled with.
add_library(drive_test_flags INTERFACE)
target_link_libraries(drive_test_flags INTERFACE host_warnings cmock m)
target_compile_features(drive_test_flags INTERFACE c_std_99)
target_include_directories(drive_test_flags INTERFACE
  ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/hal/include ${PROJECT_SOURCE_DIR}/hal/include/hal)

# The library of the mock of one HAL header, made once for all tests that ask for it.
function(drive_mock header out_target)
  get_property(cmock_dir GLOBAL PROPERTY drive_test_cmock_dir)
  get_filename_component(base ${header} NAME_WE)
  set(target mock_${base})
  set(${out_target} ${target} PARENT_SCOPE)
  if(TARGET ${target})
    return()
  endif()

  set(source ${PROJECT_SOURCE_DIR}/hal/include/hal/${base}.h)
  if(NOT EXISTS ${source})
    message(FATAL_ERROR "drive_test: MOCKS ${header}: there is no ${source}")
  endif()
  set(config ${PROJECT_SOURCE_DIR}/tests/cmock.yml)
  set(dir ${PROJECT_BINARY_DIR}/mocks)
  file(MAKE_DIRECTORY ${dir})
  add_custom_command(OUTPUT ${dir}/${target}.c ${dir}/${target}.h
    COMMAND ${RUBY} --disable=gems -W0 ${cmock_dir}/lib/cmock.rb -o${config} --mock_path=${dir} ${source}
    DEPENDS ${source} ${config}
    COMMENT "Mocking hal/${base}.h"
    VERBATIM)
  # Objects, not an archive: a mock replaces its HAL function wherever it stands in the link.
  add_library(${target} OBJECT ${dir}/${target}.c ${dir}/${target}.h)
  target_include_directories(${target} PUBLIC ${dir}
    PRIVATE ${PROJECT_SOURCE_DIR}/hal/include ${PROJECT_SOURCE_DIR}/hal/include/hal)
  target_link_libraries(${target} PUBLIC cmock)
endfunction()

# The runners of the test files in the property drive_test_files of this folder.
function(drive_runners folder)
  get_property(cmock_dir GLOBAL PROPERTY drive_test_cmock_dir)
  get_property(files DIRECTORY PROPERTY drive_test_files)
  make_runners(${folder} ${cmock_dir}/vendor/unity ${files})
endfunction()

function(drive_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "UNDER_TEST;MOCKS;SOURCES")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "drive_test(${name}): unknown arguments: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  get_filename_component(name ${name} NAME_WE)

  file(GLOB_RECURSE test_file ${CMAKE_CURRENT_SOURCE_DIR}/${name}.c)
  list(LENGTH test_file count)
  if(NOT count EQUAL 1)
    message(FATAL_ERROR "drive_test(${name}): one ${name}.c is wanted below ${CMAKE_CURRENT_SOURCE_DIR}, not ${count}")
  endif()
  list(TRANSFORM arg_SOURCES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ OUTPUT_VARIABLE sources)
  list(REMOVE_ITEM sources ${test_file})

  set(folder_of_runners ${CMAKE_CURRENT_BINARY_DIR}/runners)
  set(runner ${folder_of_runners}/${name}_runner.c)
  get_property(files DIRECTORY PROPERTY drive_test_files)
  if(NOT files) # once all tests of this CMakeLists.txt are known
    cmake_language(EVAL CODE "cmake_language(DEFER CALL drive_runners [[${folder_of_runners}]])")
  endif()
  set_property(DIRECTORY APPEND PROPERTY drive_test_files ${test_file})
  # The runner is compiled at the end of the test, in one go: by itself it takes as long again. Nobody but the runner calls a test,
  # so no header declares it.
  # -O0: the code under test is optimised as the preset says; the test around it would take twice as long to compile.
  set(whole ${folder_of_runners}/${name}_with_runner.c)
  file(CONFIGURE OUTPUT ${whole} CONTENT "#include \"${test_file}\"\n#include \"${runner}\"\n" @ONLY)
  set_source_files_properties(${runner} PROPERTIES HEADER_FILE_ONLY ON)
  set_source_files_properties(${whole} ${sources} PROPERTIES
    COMPILE_OPTIONS "-Wno-missing-prototypes;$<$<CONFIG:RelWithDebInfo>:-O0>")

  set(mocks "")
  foreach(header IN LISTS arg_MOCKS)
    drive_mock(${header} mock)
    list(APPEND mocks ${mock})
  endforeach()

  # The variants of the test: one per numeric if anything under test has one.
  set(variants "plain")
  foreach(base IN LISTS arg_UNDER_TEST)
    foreach(numeric IN LISTS EVENSPIN_NUMERICS)
      if(TARGET ${base}_${numeric})
        set(variants ${EVENSPIN_NUMERICS})
      endif()
    endforeach()
  endforeach()

  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR}/tests ${CMAKE_CURRENT_SOURCE_DIR})
  string(REGEX REPLACE "/.*" "" folder "${folder}")

  if(NOT TARGET tests_${folder})
    add_custom_target(tests_${folder})
  endif()
  foreach(variant IN LISTS variants)
    if(variant STREQUAL "plain")
      set(target ${name})
    else()
      set(target ${name}_${variant})
    endif()

    set(libraries "")
    foreach(base IN LISTS arg_UNDER_TEST)
      if(TARGET ${base}_${variant})
        list(APPEND libraries ${base}_${variant})
      elseif(TARGET ${base})
        list(APPEND libraries ${base})
      else()
        message(FATAL_ERROR "drive_test(${name}): UNDER_TEST ${base}: there is neither ${base}_${variant} nor ${base}")
      endif()
    endforeach()

    # What tests share is compiled once for all that have the same under test, and the same mocks.
    set(shared "")
    foreach(source IN LISTS sources)
      string(MD5 same "${source};${libraries};${mocks}")
      get_filename_component(base ${source} NAME_WE)
      string(SUBSTRING ${same} 0 8 same)
      set(objects ${base}_${same})
      if(NOT TARGET ${objects})
        add_library(${objects} OBJECT ${source})
        target_link_libraries(${objects} PRIVATE ${mocks} ${libraries} drive_test_flags)
      endif()
      list(APPEND shared $<TARGET_OBJECTS:${objects}>)
    endforeach()

    add_executable(${target} ${whole} ${runner} ${shared})
    target_link_libraries(${target} PRIVATE ${mocks} ${libraries} drive_test_flags)
    add_dependencies(tests_${folder} ${target})
    add_test(NAME ${target} COMMAND ${target})
    set_tests_properties(${target} PROPERTIES LABELS "${folder}")
  endforeach()
endfunction()
