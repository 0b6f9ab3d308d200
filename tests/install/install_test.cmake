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
foreach(project consumer program_alone)
  run(${CMAKE_COMMAND} -S "${CONSUMERS}/${project}" -B "${WORK}/${project}" -G "${GENERATOR}"
      "-DCMAKE_PREFIX_PATH=${WORK}/prefix" "-DCMAKE_CXX_COMPILER=${COMPILER}" ${flags})
  run(${CMAKE_COMMAND} --build "${WORK}/${project}")
endforeach()
run("${WORK}/program_alone/program_alone")
# The README's example, on the demo's pictures.
execute_process(COMMAND "${WORK}/consumer/consumer" panel.exc machine.toml images
                WORKING_DIRECTORY "${CONSUMERS}/../../datasets/demo"
                OUTPUT_VARIABLE holes RESULT_VARIABLE result)
string(REGEX MATCHALL "T[0-9]+ X[-0-9.]+ Y[-0-9.]+\n" holes "${holes}")
list(LENGTH holes n_holes)
if(NOT result EQUAL 0 OR NOT n_holes EQUAL 990)
  message(FATAL_ERROR "the example failed (${result}): ${n_holes} holes")
endif()
run("${WORK}/prefix/bin/panelcal" --version)
