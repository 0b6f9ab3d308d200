# SPDX-License-Identifier: Apache-2.0
# The few OpenCV modules panelcal uses, from the narrow -dev packages (libopencv-core-dev and
# so on), which do not bring OpenCVConfig.cmake: that one comes with all of OpenCV, 600 MB.
#
# Defines NarrowOpenCV::core, NarrowOpenCV::imgproc and so on: the COMPONENTS asked for.

find_path(NarrowOpenCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
mark_as_advanced(NarrowOpenCV_INCLUDE_DIR)
set(_narrow_opencv_required NarrowOpenCV_INCLUDE_DIR)
foreach(_module IN LISTS NarrowOpenCV_FIND_COMPONENTS)
  find_library(NarrowOpenCV_${_module}_LIBRARY opencv_${_module})
  mark_as_advanced(NarrowOpenCV_${_module}_LIBRARY)
  list(APPEND _narrow_opencv_required NarrowOpenCV_${_module}_LIBRARY)
endforeach()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(NarrowOpenCV REQUIRED_VARS ${_narrow_opencv_required})

if(NarrowOpenCV_FOUND)
  foreach(_module IN LISTS NarrowOpenCV_FIND_COMPONENTS)
    if(NOT TARGET NarrowOpenCV::${_module})
      add_library(NarrowOpenCV::${_module} UNKNOWN IMPORTED)
      set_target_properties(
        NarrowOpenCV::${_module}
        PROPERTIES IMPORTED_LOCATION "${NarrowOpenCV_${_module}_LIBRARY}"
                   INTERFACE_INCLUDE_DIRECTORIES "${NarrowOpenCV_INCLUDE_DIR}"
                   INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${NarrowOpenCV_INCLUDE_DIR}")
    endif()
  endforeach()
endif()
