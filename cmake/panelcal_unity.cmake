# SPDX-License-Identifier: Apache-2.0
# panelcal_unity(target): with CMAKE_UNITY_BUILD, the files of each room of a target are compiled as
# one, so that what they all include is read once. A file with options of its own stays alone.
#
# CMake's own unity files name absolute paths, with which a compiler cache never hits in another
# clone; these name the paths in the repository.

function(panelcal_unity target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD OFF)
  if(NOT CMAKE_UNITY_BUILD)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    get_source_file_property(options "${source}" COMPILE_OPTIONS)
    get_source_file_property(is_alone "${source}" SKIP_UNITY_BUILD_INCLUSION)
    get_filename_component(room "${source}" DIRECTORY)
    if(room AND NOT options AND NOT is_alone)
      string(MAKE_C_IDENTIFIER "${room}" room)
      list(APPEND rooms ${room})
      list(APPEND sources_of_${room} "${source}")
    endif()
  endforeach()
  list(REMOVE_DUPLICATES rooms)
  cmake_path(RELATIVE_PATH CMAKE_CURRENT_SOURCE_DIR BASE_DIRECTORY "${PROJECT_SOURCE_DIR}"
             OUTPUT_VARIABLE folder)
  foreach(room IN LISTS rooms)
    list(LENGTH sources_of_${room} n_sources)
    if(n_sources GREATER 1)
      list(TRANSFORM sources_of_${room} REPLACE "(.+)" "#include \"${folder}/\\1\"\n"
           OUTPUT_VARIABLE includes)
      list(JOIN includes "" text)
      set(unit "${CMAKE_CURRENT_BINARY_DIR}/${target}_${room}.cc")
      file(CONFIGURE OUTPUT "${unit}" CONTENT "${text}" @ONLY)
      set_source_files_properties(${sources_of_${room}} PROPERTIES HEADER_FILE_ONLY ON)
      target_sources(${target} PRIVATE "${unit}")
    endif()
  endforeach()
endfunction()
