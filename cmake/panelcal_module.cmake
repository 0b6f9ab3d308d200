# SPDX-License-Identifier: Apache-2.0
# panelcal_module(name SOURCES ... DEPENDS ... [COMPONENT component]): libpanelcal_<name>.so, a library
# that the program loads when it needs it; of the program's own component unless another is named. Modules lie in one folder of their own, as far from the program in the
# build tree as after installation: ../lib/panelcal/modules.
#
# panelcal_module_folders(source): tells this source where the modules are.

set(PANELCAL_MODULE_DIR "${CMAKE_INSTALL_LIBDIR}/panelcal/modules")
file(RELATIVE_PATH PANELCAL_MODULES_FROM_PROGRAM "/${CMAKE_INSTALL_BINDIR}" "/${PANELCAL_MODULE_DIR}")

function(panelcal_module name)
  cmake_parse_arguments(arg "" "COMPONENT" "SOURCES;DEPENDS" ${ARGN})
  if(NOT arg_COMPONENT)
    set(arg_COMPONENT program)
  endif()
  set(target panelcal_${name}_module)
  add_library(${target} MODULE ${arg_SOURCES})
  set_target_properties(
    ${target} PROPERTIES OUTPUT_NAME panelcal_${name}
                         LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/${PANELCAL_MODULE_DIR}")
  target_include_directories(${target} PRIVATE "${PROJECT_SOURCE_DIR}")
  target_compile_definitions(${target} PRIVATE PANELCAL_VERSION="${PROJECT_VERSION}")
  # Nothing of a static library is exported: the program and each module keep to their own.
  target_link_options(${target} PRIVATE -Wl,--as-needed -Wl,--exclude-libs,ALL)
  target_link_libraries(${target} PRIVATE ${arg_DEPENDS} panelcal_warnings)
  install(TARGETS ${target} LIBRARY DESTINATION "${PANELCAL_MODULE_DIR}" COMPONENT ${arg_COMPONENT})
endfunction()

function(panelcal_module_folders source)
  set_source_files_properties(
    ${source}
    PROPERTIES
      SKIP_UNITY_BUILD_INCLUSION ON
      COMPILE_DEFINITIONS
      "PANELCAL_MODULES_FROM_PROGRAM=\"${PANELCAL_MODULES_FROM_PROGRAM}\";PANELCAL_MODULE_FOLDER=\"${CMAKE_INSTALL_PREFIX}/${PANELCAL_MODULE_DIR}\"")
endfunction()
