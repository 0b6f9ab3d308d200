// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

/// The face of every module: one exported object, `panelcal_module`.
///
/// Modules keep start-up cheap: OpenCV, the picture formats, Ceres, SQLite and Aravis are linked to
/// modules, not to the program. Beside each (vision_module.cc) stands a file of the program
/// (vision_on_demand.cc) that defines the module's functions under their ordinary names: the first
/// call loads the module, this and all others pass through. The linker takes these definitions
/// before those of the static libraries. Who links the static libraries to another program has the
/// functions themselves, and no module.
///
/// See    docs/decisions/modules.md
struct PanelcalModule {
  const char* version;    ///< the program's: both are made by one build
  const void* functions;  ///< a struct that both know, such as VisionFunctions
  void (*begin)();        ///< called once, before any function; may be null
};

namespace panelcal::modules {

/// A module is not there, or of another version: the installation is damaged.
class ModuleError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Loads a module, for good. Throws ModuleError.
const void* load_functions(const char* file);

/// The functions of a module.
template <class Functions>
const Functions& load(const char* file) {
  return *static_cast<const Functions*>(load_functions(file));
}

}  // namespace panelcal::modules
