# SPDX-License-Identifier: Apache-2.0
file(REMOVE_RECURSE "${WORK}")
file(MAKE_DIRECTORY "${WORK}")

function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "failed (${result}): ${ARGV}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install "${BUILD}" --prefix "${WORK}/prefix")
if(SANITIZE)
  set(flags "-DCMAKE_CXX_FLAGS=-fsanitize=${SANITIZE}")
endif()
run(${CMAKE_COMMAND} -S "${CONSUMER}" -B "${WORK}/build" -G "${GENERATOR}"
    "-DCMAKE_PREFIX_PATH=${WORK}/prefix" "-DCMAKE_CXX_COMPILER=${COMPILER}" ${flags})
run(${CMAKE_COMMAND} --build "${WORK}/build")
# The README's example, on the demo's pictures.
execute_process(COMMAND "${WORK}/build/consumer" panel.exc machine.toml images
                WORKING_DIRECTORY "${CONSUMER}/../../../datasets/demo"
                OUTPUT_VARIABLE holes RESULT_VARIABLE result)
string(REGEX MATCHALL "T[0-9]+ X[-0-9.]+ Y[-0-9.]+\n" holes "${holes}")
list(LENGTH holes n_holes)
if(NOT result EQUAL 0 OR NOT n_holes EQUAL 990)
  message(FATAL_ERROR "the example failed (${result}): ${n_holes} holes")
endif()
run("${WORK}/prefix/bin/panelcal" --version)
