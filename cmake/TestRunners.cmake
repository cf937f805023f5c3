# make_runners(FOLDER UNITY TEST.c...): Unity's generator makes FOLDER/TEST_runner.c of every test file, in one go.
include_guard(GLOBAL)
find_program(RUBY ruby REQUIRED DOC "Ruby, which generates mocks and test runners")
set(make_runners_script ${CMAKE_CURRENT_LIST_DIR}/make_runners.rb)
set(make_runners_config ${CMAKE_CURRENT_LIST_DIR}/../tests/cmock.yml)

function(make_runners folder unity)
  set(runners "")
  foreach(file IN LISTS ARGN)
    get_filename_component(name ${file} NAME_WE)
    list(APPEND runners ${folder}/${name}_runner.c)
  endforeach()
  file(MAKE_DIRECTORY ${folder})
  file(RELATIVE_PATH here ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  add_custom_command(OUTPUT ${runners}
    COMMAND ${RUBY} --disable=gems -W0 ${make_runners_script} ${unity}/auto/generate_test_runner.rb ${make_runners_config} ${folder} ${ARGN}
    DEPENDS ${ARGN} ${make_runners_script} ${make_runners_config}
    COMMENT "Listing the tests of ${here}"
    VERBATIM)
endfunction()
