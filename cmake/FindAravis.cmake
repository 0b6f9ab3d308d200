# SPDX-License-Identifier: Apache-2.0
# GigE Vision through Aravis, which has no CMake package of its own. Its pkg-config file asks for
# libusb-1.0 as well, which libaravis-dev does not bring.
#
# Defines Aravis::aravis.

find_package(PkgConfig QUIET)
if(PkgConfig_FOUND)
  # Debian 12 has 0.8.26.
  pkg_check_modules(Aravis_PC QUIET IMPORTED_TARGET aravis-0.8>=0.8.26)
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(
  Aravis
  REQUIRED_VARS Aravis_PC_LINK_LIBRARIES Aravis_PC_INCLUDE_DIRS
  VERSION_VAR Aravis_PC_VERSION
  REASON_FAILURE_MESSAGE "needs pkg-config, libaravis-dev and libusb-1.0-0-dev")

if(Aravis_FOUND AND NOT TARGET Aravis::aravis)
  add_library(Aravis::aravis INTERFACE IMPORTED)
  target_link_libraries(Aravis::aravis INTERFACE PkgConfig::Aravis_PC)
endif()
