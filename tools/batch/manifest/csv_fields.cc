// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/manifest/csv_fields.h"

#include <algorithm>
#include <utility>

namespace panelcal::batch {
namespace {

bool is_space(char c) {
  return c == ' ' || c == '\t';
}

/// Reads the quoted field that begins at `at`, which then is behind its closing quote; false where
/// that is missing.
bool read_quoted(std::string_view line, std::size_t& at, std::string& text) {
  for (++at; at < line.size(); ++at) {
    if (line[at] == '"' && line.substr(at + 1, 1) != "\"") {
      ++at;
      return true;
    }
    if (line[at] == '"') ++at;  // the second one of a pair stands for both
    text += line[at];
  }
  return false;
}

}  // namespace

tl::expected<std::vector<CsvField>, int> split_csv(std::string_view line) {
  std::vector<CsvField> fields;
  for (std::size_t at = 0;; ++at) {
    while (at < line.size() && is_space(line[at])) ++at;
    CsvField field{"", static_cast<int>(at) + 1};
    if (at < line.size() && line[at] == '"') {
      if (!read_quoted(line, at, field.text)) return tl::unexpected(field.column);
      while (at < line.size() && is_space(line[at])) ++at;
      if (at < line.size() && line[at] != ',') return tl::unexpected(field.column);
    } else {
      const std::size_t end = std::min(line.find(',', at), line.size());
      field.text = line.substr(at, end - at);
      at = end;
      while (!field.text.empty() && is_space(field.text.back())) field.text.pop_back();
      const std::size_t quote = field.text.find('"');
      if (quote != std::string::npos) {
        return tl::unexpected(field.column + static_cast<int>(quote));
      }
    }
    fields.push_back(std::move(field));
    if (at >= line.size()) return fields;
  }
}

}  // namespace panelcal::batch
