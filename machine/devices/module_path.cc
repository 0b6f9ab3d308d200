// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/module_path.h"

#include <filesystem>
#include <system_error>

namespace panelcal::internal {

namespace fs = std::filesystem;

std::string module_path(std::string_view file) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();
  const fs::path beside = (program / PANELCAL_MODULES_FROM_PROGRAM).lexically_normal() / file;
  for (const fs::path& path : {program / file, beside, fs::path(PANELCAL_MODULE_FOLDER) / file}) {
    if (path.is_absolute() && fs::exists(path, error)) return path.string();
  }
  // Without /proc the program does not know where it lies.
  return (program.empty() ? fs::path(PANELCAL_MODULE_FOLDER) / file : beside).string();
}

}  // namespace panelcal::internal
