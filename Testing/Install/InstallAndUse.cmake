# Installs the build, moves the prefix, builds and runs the project in Consumer against it; a part that no InnerGS has must
# be refused by name.
cmake_policy(SET CMP0057 NEW)
function(run what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  set(output "${output}" PARENT_SCOPE)
  set(code "${code}" PARENT_SCOPE)
  if(NOT code EQUAL 0 AND NOT what STREQUAL "")
    message(FATAL_ERROR "${what} failed (${code}):\n${output}")
  endif()
endfunction()

unset(ENV{DESTDIR})
file(REMOVE_RECURSE "${WORK}")
file(MAKE_DIRECTORY "${WORK}")
set(prefix "${WORK}/moved")
run("The installation" ${CMAKE_COMMAND} --install "${INNERGS_BINARY_DIR}" --config "${CONFIG}" --prefix "${WORK}/prefix")
file(RENAME "${WORK}/prefix" "${prefix}")

set(configure ${CMAKE_COMMAND} -S "${SOURCE}" -G "${GENERATOR}" "-DCMAKE_BUILD_TYPE=${CONFIG}" "-DCMAKE_CXX_COMPILER=${COMPILER}"
  "-DCMAKE_C_COMPILER=${C_COMPILER}" "-DCMAKE_CXX_FLAGS=${FLAGS}" "-DInnerGS_DIR=${prefix}/${CMAKE_DIR}" "-DITK_DIR=${ITK_DIR}"
  "-Dhwy_DIR=${hwy_DIR}")
run("The consumer's configuration" ${configure} -B "${WORK}/build" "-DCOMPONENTS=${COMPONENTS}")
run("The consumer's build" ${CMAKE_COMMAND} --build "${WORK}/build" --config "${CONFIG}")
find_program(program Consumer PATHS "${WORK}/build" "${WORK}/build/${CONFIG}" NO_DEFAULT_PATH)
run("The consumer" "${program}" "${WORK}/scan.nrrd")
message("${output}")
if(NOT output MATCHES "mean 7\\.5 of 64 voxels")
  message(FATAL_ERROR "The consumer printed something else than it should.")
endif()

run("" ${configure} -B "${WORK}/refused" "-DCOMPONENTS=Sonography")
if(code EQUAL 0 OR NOT output MATCHES "no component Sonography")
  message(FATAL_ERROR "An unknown component was not refused:\n${output}")
endif()
