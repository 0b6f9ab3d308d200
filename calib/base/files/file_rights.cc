// SPDX-License-Identifier: Apache-2.0
#include "calib/base/files/file_rights.h"

#include <charconv>
#include <fstream>
#include <string>
#include <string_view>

namespace panelcal {

mode_t usual_file_rights() {
  constexpr std::string_view kKey = "Umask:\t";
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (!line.starts_with(kKey)) continue;
    const char* const end = line.data() + line.size();
    mode_t mask = 0;
    if (std::from_chars(line.data() + kKey.size(), end, mask, 8).ptr == end) return 0666 & ~mask;
  }
  return 0600;
}

}  // namespace panelcal
