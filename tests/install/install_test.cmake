# SPDX-License-Identifier: Apache-2.0
file(REMOVE_RECURSE "${WORK}")
file(MAKE_DIRECTORY "${WORK}")

function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "failed (${result}): ${ARGV}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install "${BUILD}" --prefix "${WORK}/prefix" --strip)

# What a release takes on a disk, MB.
set(max_program 20)
# With headers and static libraries, of which a package of the program has neither.
set(max_tree 46)
# The Python module, which has the libraries once more: a package of its own.
set(max_python 12)
if(HAS_LIMITS)
  file(SIZE "${WORK}/prefix/bin/panelcal" program)
  set(tree 0)
  set(python 0)
  file(GLOB_RECURSE files "${WORK}/prefix/*")
  list(FILTER files EXCLUDE REGEX "/share/doc/")
  foreach(file IN LISTS files)
    file(SIZE "${file}" size)
    if(file MATCHES "/site-packages/")
      math(EXPR python "${python} + ${size}")
    else()
      math(EXPR tree "${tree} + ${size}")
    endif()
  endforeach()
  message("installed: ${program} bytes of program, ${tree} bytes in all, ${python} bytes of Python")
  if(program GREATER ${max_program}000000 OR tree GREATER ${max_tree}000000 OR
     python GREATER ${max_python}000000)
    message(FATAL_ERROR "expected at most ${max_program} MB, ${max_tree} MB and ${max_python} MB")
  endif()
endif()

if(SANITIZE)
  set(flags "-DCMAKE_CXX_FLAGS=-fsanitize=${SANITIZE}")
endif()
foreach(project consumer program_alone)
  run(${CMAKE_COMMAND} -S "${CONSUMERS}/${project}" -B "${WORK}/${project}" -G "${GENERATOR}"
      "-DCMAKE_PREFIX_PATH=${WORK}/prefix" "-DCMAKE_CXX_COMPILER=${COMPILER}" ${flags})
  run(${CMAKE_COMMAND} --build "${WORK}/${project}")
endforeach()
run("${WORK}/program_alone/program_alone")
# The library's example (docs/howto/library.md), on the demo's pictures.
execute_process(COMMAND "${WORK}/consumer/consumer" panel.exc machine.toml images
                WORKING_DIRECTORY "${CONSUMERS}/../../datasets/demo"
                OUTPUT_VARIABLE holes RESULT_VARIABLE result)
string(REGEX MATCHALL "T[0-9]+ X[-0-9.]+ Y[-0-9.]+\n" holes "${holes}")
list(LENGTH holes n_holes)
if(NOT result EQUAL 0 OR NOT n_holes EQUAL 990)
  message(FATAL_ERROR "the example failed (${result}): ${n_holes} holes")
endif()
run("${WORK}/prefix/bin/panelcal" --version)
foreach(file man/man1/panelcal.1.gz man/man1/panelcal-surface-fit.1.gz bash-completion/completions/panelcal
             fish/vendor_completions.d/panelcal.fish zsh/vendor-completions/_panelcal)
  if(NOT EXISTS "${WORK}/prefix/share/${file}")
    message(FATAL_ERROR "the installation lacks share/${file}")
  endif()
endforeach()
# Its modules are found wherever the tree lies.
set(demo "${CONSUMERS}/../../datasets/demo")
run("${WORK}/prefix/bin/panelcal" locate "${demo}/images/0000.png" --tool 1 -m
    "${demo}/machine.toml")
if(PYTHON)
  file(GLOB site_packages "${WORK}/prefix/lib/python3*/site-packages")
  run(${CMAKE_COMMAND} -E env "PYTHONPATH=${site_packages}" PYTHONDONTWRITEBYTECODE=1 "${PYTHON}"
      "${CONSUMERS}/../../examples/python/job.py" --small)
endif()
