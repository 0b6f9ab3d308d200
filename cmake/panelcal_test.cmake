# SPDX-License-Identifier: Apache-2.0
# panelcal_test(folder SOURCES ... DEPENDS ...): one test program per folder, each
# TEST registered with CTest on its own so that they run in parallel.
#
# LABELS slow: statistics over many trials, for which CI has no time; not made with sanitizers, nor
# without PANELCAL_SLOW_TESTS.

include(GoogleTest)
include(panelcal_unity)

option(PANELCAL_SLOW_TESTS "Build the tests that are labelled slow as well" ON)

set(PANELCAL_TEST_HEADERS <algorithm> <functional> <map> <optional> <string> <vector> <Eigen/Dense>
                          <gmock/gmock.h> <gtest/gtest.h>)

# What all tests are compiled with: they share a precompiled header.
function(panelcal_test_options target)
  target_link_libraries(${target} PRIVATE panelcal_test_support panelcal_warnings GTest::gtest_main)
  # In headers that were precompiled g++ 12 sees faults of std::string and std::optional that are not
  # there (as GCC bug 105651).
  target_compile_options(
    ${target}
    PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds -Wno-stringop-overflow
            -Wno-stringop-overread -Wno-maybe-uninitialized>)
  # A third of the time that building takes; the tested code is optimised as ever.
  if(PANELCAL_SANITIZE)
    target_compile_options(${target} PRIVATE -O0)
  else()
    target_compile_options(${target} PRIVATE $<$<CONFIG:RelWithDebInfo>:-O1>)
  endif()
endfunction()

function(panelcal_test folder)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPENDS;LABELS;PROPERTIES" ${ARGN})
  if(arg_LABELS MATCHES slow AND (PANELCAL_SANITIZE OR NOT PANELCAL_SLOW_TESTS))
    return()
  endif()
  add_executable(${folder}_test ${arg_SOURCES})
  target_link_libraries(${folder}_test PRIVATE ${arg_DEPENDS})
  panelcal_test_options(${folder}_test)
  # g++ takes a precompiled header only where the same macros are defined; Ceres brings its own.
  if("Ceres::ceres" IN_LIST arg_DEPENDS)
    target_precompile_headers(${folder}_test PRIVATE ${PANELCAL_TEST_HEADERS})
  else()
    target_precompile_headers(${folder}_test REUSE_FROM panelcal_test_headers)
  endif()
  panelcal_unity(${folder}_test MAX 8)
  # An empty value would be lost on the way, and the next key be taken for it.
  if(arg_LABELS)
    list(APPEND arg_PROPERTIES LABELS "${arg_LABELS}")
  endif()
  gtest_discover_tests(
    ${folder}_test
    TEST_PREFIX ${folder}.
    PROPERTIES ${arg_PROPERTIES}
    DISCOVERY_TIMEOUT 60)
endfunction()
