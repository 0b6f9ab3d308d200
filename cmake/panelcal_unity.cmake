# SPDX-License-Identifier: Apache-2.0
# panelcal_unity(target [MAX n] [BYTES n]): with CMAKE_UNITY_BUILD, the files of a room are compiled as one, and
# small rooms together, so that what they all include is read once. A file with options of its own
# stays alone. MAX is for tests, whose names may clash: at most n files at a time, none that clash.
# BYTES is the most that small rooms together may have.
#
# CMake's own unity files name absolute paths, with which a compiler cache never hits in another
# clone; these name the paths in the repository.

include_guard(GLOBAL)
set(PANELCAL_UNITY_BUILD ${CMAKE_UNITY_BUILD})
set(CMAKE_UNITY_BUILD OFF)

function(panelcal_unity target)
  cmake_parse_arguments(arg "" "MAX;BYTES" "" ${ARGN})
  if(NOT PANELCAL_UNITY_BUILD)
    return()
  endif()
  set(enough 320000) # bytes; more take long in one piece, and more memory
  if(arg_BYTES)
    set(enough ${arg_BYTES})
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    get_source_file_property(options "${source}" COMPILE_OPTIONS)
    get_source_file_property(is_alone "${source}" SKIP_UNITY_BUILD_INCLUSION)
    if(NOT options AND NOT is_alone)
      # A room inside a room goes with it: types of neighbours may share the names of enumerators.
      string(REGEX REPLACE "/.*" "" room "${source}")
      string(MAKE_C_IDENTIFIER "room_${room}" room)
      file(SIZE "${CMAKE_CURRENT_SOURCE_DIR}/${source}" size)
      if(NOT room IN_LIST rooms)
        list(APPEND rooms ${room})
        set(size_of_${room} 0)
      endif()
      math(EXPR size_of_${room} "${size_of_${room}} + ${size}")
      list(APPEND sources_of_${room} "${source}")
    endif()
  endforeach()
  if(arg_MAX)
    foreach(room IN LISTS rooms)
      list(APPEND files ${sources_of_${room}})
    endforeach()
    _panelcal_unity_groups(groups ${arg_MAX} ${files})
    foreach(group IN LISTS groups)
      string(REPLACE "|" ";" group "${group}")
      _panelcal_unity_file(${target} ${group})
    endforeach()
    return()
  endif()
  set(size 0)
  foreach(room IN LISTS rooms)
    math(EXPR size_with "${size} + ${size_of_${room}}")
    if(size_with GREATER enough)
      _panelcal_unity_file(${target} ${files})
      set(files "")
      set(size_with ${size_of_${room}})
    endif()
    list(APPEND files ${sources_of_${room}})
    set(size ${size_with})
  endforeach()
  _panelcal_unity_file(${target} ${files})
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
function(_panelcal_unity_file target)
  list(LENGTH ARGN n_sources)
  if(n_sources LESS 2)
    return()
  endif()
  cmake_path(RELATIVE_PATH CMAKE_CURRENT_SOURCE_DIR BASE_DIRECTORY "${PROJECT_SOURCE_DIR}"
             OUTPUT_VARIABLE folder)
  set(text "")
  foreach(source IN LISTS ARGN)
    string(APPEND text "#include \"${folder}/${source}\"\n")
  endforeach()
  list(GET ARGN 0 first)
  string(REGEX REPLACE "\\.cc$" "" first "${first}")
  string(MAKE_C_IDENTIFIER "${first}" first)
  set(unit "${CMAKE_CURRENT_BINARY_DIR}/${target}_${first}.cc")
  file(CONFIGURE OUTPUT "${unit}" CONTENT "${text}" @ONLY)
  # Taken out of this target alone: a property of the file would hold for all targets of the folder.
  get_target_property(sources ${target} SOURCES)
  list(REMOVE_ITEM sources ${ARGN})
  set_property(TARGET ${target} PROPERTY SOURCES ${sources} "${unit}")
endfunction()
