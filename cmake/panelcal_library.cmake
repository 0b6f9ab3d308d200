# SPDX-License-Identifier: Apache-2.0
# One library target per folder, or per room of calib. A file is included by its path in the
# repository ("calib/base/frames.h"); installed headers lie below include/panelcal, and what links
# an installed library sees both roots: <panelcal/calib/base/frames.h> works too.

include(panelcal_precompile)
include(panelcal_unity)

function(panelcal_library name)
  cmake_parse_arguments(arg "" "BYTES" "SOURCES;HEADERS;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  add_library(panelcal_${name} STATIC ${arg_SOURCES})
  add_library(panelcal::${name} ALIAS panelcal_${name})
  set_target_properties(panelcal_${name} PROPERTIES EXPORT_NAME ${name}
                                                    VERIFY_INTERFACE_HEADER_SETS ON)
  target_compile_features(panelcal_${name} PUBLIC cxx_std_20)
  panelcal_precompile(panelcal_${name})
  panelcal_unity(panelcal_${name} BYTES ${arg_BYTES})
  target_sources(panelcal_${name} PUBLIC FILE_SET HEADERS BASE_DIRS "${PROJECT_SOURCE_DIR}"
                                         FILES ${arg_HEADERS})
  target_include_directories(panelcal_${name}
                             INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(
    panelcal_${name}
    PUBLIC ${arg_DEPENDS}
    PRIVATE ${arg_PRIVATE_DEPENDS} $<BUILD_INTERFACE:panelcal_warnings>)
  install(
    TARGETS panelcal_${name}
    EXPORT panelcalTargets
    ARCHIVE COMPONENT development
    FILE_SET HEADERS DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/panelcal" COMPONENT development)
endfunction()
