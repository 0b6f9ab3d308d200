// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/metrics.h"

#include <fmt/format.h>

namespace panelcal {
namespace {

std::string label_text(std::string_view value) {
  std::string out;
  for (const char c : value) {
    if (c == '\n') {
      out += "\\n";
      continue;
    }
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

}  // namespace

void Metrics::gauge(std::string_view name,
                    std::string_view help,
                    const Labels& labels,
                    double value) {
  if (name != name_) {
    text_ += fmt::format("# HELP {0} {1}\n# TYPE {0} gauge\n", name, help);
    name_ = name;
  }
  text_ += name;
  std::string_view before = "{";
  for (const auto& [label, word] : labels) {
    text_ += fmt::format("{}{}=\"{}\"", before, label, label_text(word));
    before = ",";
  }
  if (!labels.empty()) text_ += '}';
  text_ += fmt::format(" {}\n", value);
}

}  // namespace panelcal
