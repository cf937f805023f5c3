# cmake -D ROOT=... -D OUT=FILE.c -P FirmwareId.cmake: a number of 48 bits that changes with every source of the firmware.
file(GLOB_RECURSE sources RELATIVE ${ROOT} ${ROOT}/control/*.[ch] ${ROOT}/control/*.def ${ROOT}/firmware/*.[ch] ${ROOT}/firmware/*.def
  ${ROOT}/hal/include/*.h)
list(FILTER sources EXCLUDE REGEX "^firmware/main_") # of a board
list(SORT sources)
set(all "")
foreach(file IN LISTS sources)
  file(SHA256 ${ROOT}/${file} hash)
  string(APPEND all "${file} ${hash}\n")
endforeach()
string(SHA256 all "${all}")
string(SUBSTRING "${all}" 0 12 id)
file(CONFIGURE OUTPUT ${OUT} @ONLY CONTENT "/* Made by the build from control/, firmware/ and hal/include. */
extern const char sim_firmware_id[];
const char sim_firmware_id[] = \"@id@\";
")
