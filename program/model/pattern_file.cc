// SPDX-License-Identifier: Apache-2.0
#include "program/model/pattern_file.h"

#include <cstddef>

#include "calib/base/diagnostic.h"
#include "calib/base/json/json_line.h"
#include "program/text/json_text.h"

namespace panelcal {
namespace {

std::string_view without_folders(std::string_view path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string_view::npos ? path : path.substr(slash + 1);
}

}  // namespace

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

void append_pattern(std::string& out, const PatternFile& file) {
  if (file.path.empty()) return;
  out += ",\"file\":";
  append_json_string(out, without_folders(file.path));
  if (file.sha256.empty()) return;
  out += ",\"file_sha256\":";
  append_json_string(out, file.sha256);
}

Expected<void> read_pattern(const internal::JsonLine& line,
                            Code code,
                            std::string& file,
                            std::string& file_sha256) {
  if (line.has("file")) {
    PANELCAL_TRY(file, line.text("file", code));
  }
  if (!line.has("file_sha256")) return {};
  if (file.empty()) {
    return failure(line.problem("file_sha256", code, "the pattern's name, \"file\", beside it"));
  }
  PANELCAL_TRY(file_sha256, line.digest("file_sha256", code));
  return {};
}

}  // namespace panelcal
