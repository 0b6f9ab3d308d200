// SPDX-License-Identifier: Apache-2.0
#include "program/model/pattern_file.h"

#include <cstddef>

#include "calib/base/diagnostic.h"

namespace panelcal {
std::string_view without_folders(std::string_view path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string_view::npos ? path : path.substr(slash + 1);
}

bool is_same_pattern(const PatternFile& a, const PatternFile& b) {
  if (a.path.empty() || b.path.empty()) return a.path.empty() == b.path.empty();
  if (!a.sha256.empty() && !b.sha256.empty()) return a.sha256 == b.sha256;
  return without_folders(a.path) == without_folders(b.path);
}

std::string pattern_text(const PatternFile& file) {
  constexpr std::size_t kShownDigits = 12;
  if (file.path.empty()) return "(the program itself)";
  std::string text = quoted(file.path);
  if (!file.sha256.empty()) text += ", sha256 " + std::string(file.sha256.substr(0, kShownDigits));
  return text;
}

}  // namespace panelcal
