# SPDX-License-Identifier: Apache-2.0
# One library target per folder, included everywhere as "panelcal/<folder>/<file>.h".
#
# The build tree holds a link panelcal/<folder> to each source folder, so that the
# include path is the same inside the tree and after installation.

include(panelcal_precompile)

set(PANELCAL_INCLUDE_ROOT "${PROJECT_BINARY_DIR}/include")

function(panelcal_library name)
  cmake_parse_arguments(arg "" "FOLDER" "SOURCES;HEADERS;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  if(NOT arg_FOLDER)
    set(arg_FOLDER ${name})
  endif()

  # calib/base is seen through the link of calib.
  string(REGEX REPLACE "/.*" "" top "${arg_FOLDER}")
  file(MAKE_DIRECTORY "${PANELCAL_INCLUDE_ROOT}/panelcal")
  file(CREATE_LINK "${PROJECT_SOURCE_DIR}/${top}" "${PANELCAL_INCLUDE_ROOT}/panelcal/${top}" SYMBOLIC)

  set(headers)
  foreach(header IN LISTS arg_HEADERS)
    list(APPEND headers "${PANELCAL_INCLUDE_ROOT}/panelcal/${arg_FOLDER}/${header}")
  endforeach()

  add_library(panelcal_${name} STATIC ${arg_SOURCES})
  add_library(panelcal::${name} ALIAS panelcal_${name})
  set_target_properties(panelcal_${name} PROPERTIES EXPORT_NAME ${name}
                                                    VERIFY_INTERFACE_HEADER_SETS ON)
  target_compile_features(panelcal_${name} PUBLIC cxx_std_20)
  panelcal_precompile(panelcal_${name})
  target_sources(panelcal_${name} PUBLIC FILE_SET HEADERS BASE_DIRS "${PANELCAL_INCLUDE_ROOT}"
                                         FILES ${headers})
  target_link_libraries(
    panelcal_${name}
    PUBLIC ${arg_DEPENDS}
    PRIVATE ${arg_PRIVATE_DEPENDS} $<BUILD_INTERFACE:panelcal_warnings>)
  install(
    TARGETS panelcal_${name}
    EXPORT panelcalTargets
    FILE_SET HEADERS)
endfunction()
