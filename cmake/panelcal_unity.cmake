# SPDX-License-Identifier: Apache-2.0
# panelcal_unity(target [MAX n]): with CMAKE_UNITY_BUILD, the files of each room of a target are
# compiled as one, so that what they all include is read once. A file with options of its own stays
# alone. MAX is for tests, whose names may clash: at most n files at a time, none that clash.
#
# CMake's own unity files name absolute paths, with which a compiler cache never hits in another
# clone; these name the paths in the repository.

include_guard(GLOBAL)
set(PANELCAL_UNITY_BUILD ${CMAKE_UNITY_BUILD})
set(CMAKE_UNITY_BUILD OFF)

function(panelcal_unity target)
  cmake_parse_arguments(arg "" "MAX" "" ${ARGN})
  if(NOT PANELCAL_UNITY_BUILD)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    get_source_file_property(options "${source}" COMPILE_OPTIONS)
    get_source_file_property(is_alone "${source}" SKIP_UNITY_BUILD_INCLUSION)
    get_filename_component(room "${source}" DIRECTORY)
    if(arg_MAX)
      set(room all)
    endif()
    if(room AND NOT options AND NOT is_alone)
      string(MAKE_C_IDENTIFIER "${room}" room)
      list(APPEND rooms ${room})
      list(APPEND sources_of_${room} "${source}")
    endif()
  endforeach()
  list(REMOVE_DUPLICATES rooms)
  foreach(room IN LISTS rooms)
    if(arg_MAX)
      _panelcal_unity_groups(groups ${arg_MAX} ${sources_of_${room}})
      foreach(group IN LISTS groups)
        string(REPLACE "|" ";" group "${group}")
        _panelcal_unity_file(${target} ${room} ${group})
      endforeach()
    else()
      _panelcal_unity_file(${target} ${room} ${sources_of_${room}})
    endif()
  endforeach()
endfunction()

# Sets a list of groups, the files of each joined by |.
function(_panelcal_unity_groups groups max)
  set(script "${PROJECT_SOURCE_DIR}/tests/tools/unity_groups.py")
  execute_process(
    COMMAND "${Python3_EXECUTABLE}" "${script}" ${max} ${ARGN}
    WORKING_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}"
    OUTPUT_VARIABLE lines OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${script}" ${ARGN})
  string(REPLACE ";" "|" lines "${lines}")
  string(REPLACE "\n" ";" lines "${lines}")
  set(${groups} "${lines}" PARENT_SCOPE)
endfunction()

# One file that includes the given ones, named after the first of them.
function(_panelcal_unity_file target room)
  list(LENGTH ARGN n_sources)
  if(n_sources EQUAL 1)
    return()
  endif()
  cmake_path(RELATIVE_PATH CMAKE_CURRENT_SOURCE_DIR BASE_DIRECTORY "${PROJECT_SOURCE_DIR}"
             OUTPUT_VARIABLE folder)
  set(text "")
  foreach(source IN LISTS ARGN)
    string(APPEND text "#include \"${folder}/${source}\"\n")
  endforeach()
  list(GET ARGN 0 first)
  get_filename_component(first "${first}" NAME_WE)
  set(unit "${CMAKE_CURRENT_BINARY_DIR}/${target}_${room}_${first}.cc")
  file(CONFIGURE OUTPUT "${unit}" CONTENT "${text}" @ONLY)
  set_source_files_properties(${ARGN} PROPERTIES HEADER_FILE_ONLY ON)
  target_sources(${target} PRIVATE "${unit}")
endfunction()
