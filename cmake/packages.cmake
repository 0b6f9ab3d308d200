# SPDX-License-Identifier: Apache-2.0
# Debian packages: `tools/package.sh` builds them with CPack, one a component of the installation.
#
#   panelcal          the program with the modules that every job needs
#   panelcal-cameras  the modules of GigE Vision cameras and of video (Aravis, FFmpeg by OpenCV)
#   panelcal-serve    the module of `panelcal serve` (HTTP and TLS), its unit
#   python3-panelcal  the Python module
#   libpanelcal-dev   headers, static libraries, find_package(panelcal)
#   panelcal-doc      docs, examples and the demo's job
#
# The program loads a module when it is needed and names the package that has it, so that the core
# depends on neither Aravis nor FFmpeg.

set(doc "share/doc")
install(DIRECTORY docs/ DESTINATION ${doc}/panelcal-doc/docs COMPONENT documentation)
install(DIRECTORY examples/ datasets/demo DESTINATION ${doc}/panelcal-doc/examples
        COMPONENT documentation)
install(FILES README.md DESTINATION ${doc}/panelcal-doc COMPONENT documentation)

set(CPACK_GENERATOR DEB)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_PACKAGE_VENDOR "panelcal")
set(CPACK_PACKAGE_CONTACT "panelcal maintainers <maintainers@panelcal.example>")
set(CPACK_PACKAGE_VERSION "${PROJECT_VERSION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_OUTPUT_FILE_PREFIX packages)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION electronics)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_HOMEPAGE "https://panelcal.example")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

# package(component name summary [ARCHITECTURE_ALL] [SECTION ...] [DEPENDS ...] [SUGGESTS ...]
#         DESCRIPTION line...)
function(package component name summary)
  cmake_parse_arguments(arg "ARCHITECTURE_ALL" "SECTION;DEPENDS;SUGGESTS" "DESCRIPTION" ${ARGN})
  string(TOUPPER ${component} key)
  list(JOIN arg_DESCRIPTION "\n" description)
  foreach(setting "PACKAGE_NAME;${name}" "PACKAGE_SECTION;${arg_SECTION}"
                  "PACKAGE_DEPENDS;${arg_DEPENDS}" "PACKAGE_SUGGESTS;${arg_SUGGESTS}"
                  "DESCRIPTION;${summary}\n${description}")
    list(POP_FRONT setting variable)
    if(NOT "${setting}" STREQUAL "")
      set(CPACK_DEBIAN_${key}_${variable} "${setting}" PARENT_SCOPE)
    endif()
  endforeach()
  if(arg_ARCHITECTURE_ALL)
    set(CPACK_DEBIAN_${key}_PACKAGE_ARCHITECTURE all PARENT_SCOPE)
  else()
    set(CPACK_DEBIAN_${key}_PACKAGE_SHLIBDEPS ON PARENT_SCOPE)
  endif()
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${component} PARENT_SCOPE)
  # What Debian asks of every package: where it comes from, and what changed.
  set(folder "${PROJECT_BINARY_DIR}/package/${name}")
  configure_file(share/package/copyright "${folder}/copyright" COPYONLY)
  install(FILES "${folder}/copyright" DESTINATION ${doc}/${name} COMPONENT ${component})
  set(package ${name})
  configure_file(share/package/changelog.in "${folder}/changelog")
  execute_process(COMMAND gzip -9nkf "${folder}/changelog" COMMAND_ERROR_IS_FATAL ANY)
  install(FILES "${folder}/changelog.gz" DESTINATION ${doc}/${name} COMPONENT ${component})
  if(EXISTS "${PROJECT_SOURCE_DIR}/share/package/${name}.lintian-overrides")
    install(FILES share/package/${name}.lintian-overrides DESTINATION share/lintian/overrides
            RENAME ${name} COMPONENT ${component})
  endif()
endfunction()

set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")
set(CPACK_COMPONENTS_ALL "")
package(program panelcal "make a drilling machine hit the panel on the table"
  SUGGESTS "panelcal-cameras, panelcal-serve, panelcal-postgresql, panelcal-doc"
  DESCRIPTION
  "panelcal reads part programs for printed-circuit drilling and routing"
  "machines (Excellon, SIEB & MEYER), measures fiducials in pictures, fits"
  "offset, rotation and stretch with their uncertainty, refuses what does not"
  "fit, and writes every hole where it has to go. It calibrates the offset"
  "between spindle and camera, the camera and the table, by night as well.")
package(cameras panelcal-cameras "live cameras for panelcal"
  DEPENDS "panelcal (= ${PROJECT_VERSION})"
  DESCRIPTION
  "The modules by which panelcal takes pictures from GigE Vision cameras,"
  "Video4Linux devices, network streams and video files, and a udev rule"
  "that keeps USB cameras awake.")
package(serve panelcal-serve "screen at the machine for panelcal"
  DEPENDS "panelcal (= ${PROJECT_VERSION})"
  DESCRIPTION
  "The module by which \"panelcal serve\" shows a drilling machine in a"
  "browser and lets one person operate it, and its systemd unit.")
package(postgresql panelcal-postgresql "PostgreSQL for panelcal"
  DEPENDS "panelcal (= ${PROJECT_VERSION})"
  DESCRIPTION
  "The module by which \"panelcal batch --store\" and \"panelcal history push\""
  "gather batches and ledgers of many machines in a PostgreSQL database.")
# As panelcalConfig.cmake finds them.
if(Aravis_FOUND)
  set(cameras_of_library ", libaravis-dev, libusb-1.0-0-dev, pkg-config")
endif()
package(development libpanelcal-dev "panelcal as a C++ library"
  SECTION libdevel
  DEPENDS
  "libapriltag-dev, libceres-dev, libdeflate-dev, libeigen3-dev, libexpected-dev, libfmt-dev, libjpeg-dev, libmd-dev, libopencv-core-dev, libopencv-imgproc-dev, libopencv-videoio-dev, libpng-dev, libsqlite3-dev, libtiff-dev, libtomlplusplus-dev, nlohmann-json3-dev, zlib1g-dev${cameras_of_library}"
  DESCRIPTION
  "Headers, static libraries and find_package(panelcal) of the libraries that"
  "panelcal is made of: part programs, fits with covariance, fiducials,"
  "surfaces and the machine.")
if(TARGET panelcal_python)
  # Where Debian's Python looks for what packages bring, in whatever version.
  set(PANELCAL_PYTHON_FROM "${PANELCAL_PYTHON_DIR}")
  math(EXPR panelcal_next_python "${Python_VERSION_MINOR} + 1")
  configure_file(cmake/debian_python.cmake.in debian_python.cmake @ONLY)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
      "${PROJECT_SOURCE_DIR}/share/package/python/prerm")
  set(CPACK_PRE_BUILD_SCRIPTS "${PROJECT_BINARY_DIR}/debian_python.cmake")
  package(python python3-panelcal "panelcal as a Python module"
    SECTION python
    DEPENDS "python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${panelcal_next_python}), python3-numpy"
    DESCRIPTION
    "Fiducials located in numpy arrays, part programs read, jobs corrected,"
    "panels and surfaces fitted, machines calibrated: the code of panelcal's"
    "command line with the same results, from Python.")
endif()
package(documentation panelcal-doc "documentation and examples of panelcal"
  ARCHITECTURE_ALL SECTION doc
  DESCRIPTION
  "How to set up a job, a night and a camera; every command of both languages;"
  "every key of the machine file; the formats of all files; and a demo job"
  "with its pictures.")

include(CPack)
