# SPDX-License-Identifier: Apache-2.0
# The manual as a site: cmake --build build/release --target site
#
# Its tutorials are followed, and their pictures taken, whenever it is built. panelcal-doc has it where
# it was built before (tools/package.sh).
set(site "${PROJECT_BINARY_DIR}/site")
if(TARGET panelcal_python)
  add_custom_target(
    site
    COMMAND
      ${CMAKE_COMMAND} -E env "PYTHONPATH=${PROJECT_BINARY_DIR}/python" PYTHONDONTWRITEBYTECODE=1
      "${Python_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/tools/site/make.py" $<TARGET_FILE:panelcal>
      "${PROJECT_SOURCE_DIR}" "${site}"
    DEPENDS panelcal panelcal_python
    COMMENT "Following the tutorials, and building the manual"
    USES_TERMINAL VERBATIM)
else()
  add_custom_target(
    site
    COMMAND ${CMAKE_COMMAND} -E echo "the manual needs the Python module: pybind11-dev, python3-dev"
    COMMAND ${CMAKE_COMMAND} -E false
    VERBATIM)
endif()
install(
  DIRECTORY "${site}/html"
  DESTINATION share/doc/panelcal-doc
  COMPONENT documentation
  OPTIONAL)

# The reference of the libraries, by Doxygen; a docblock that it cannot read is an error:
# cmake --build build/release --target api
configure_file(cmake/Doxyfile.in Doxyfile @ONLY)
add_custom_target(
  api
  COMMAND doxygen "${PROJECT_BINARY_DIR}/Doxyfile"
  COMMAND ${CMAKE_COMMAND} -E echo "file://${PROJECT_BINARY_DIR}/api/html/index.html"
  COMMENT "Building the reference of the libraries"
  VERBATIM)
