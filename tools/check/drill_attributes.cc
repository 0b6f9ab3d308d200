// SPDX-License-Identifier: Apache-2.0
#include "tools/check/drill_attributes.h"

#include <charconv>
#include <cstddef>
#include <vector>

#include "program/text/source_text.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Behind `prefix`; empty if the text begins otherwise.
std::string_view behind(std::string_view text, std::string_view prefix) {
  return text.starts_with(prefix) ? text.substr(prefix.size()) : std::string_view();
}

std::vector<std::string_view> parts_of(std::string_view value) {
  std::vector<std::string_view> parts;
  while (true) {
    const auto comma = value.find(',');
    parts.push_back(value.substr(0, comma));
    if (comma == std::string_view::npos) return parts;
    value.remove_prefix(comma + 1);
  }
}

std::string plating_text(std::string_view word) {
  if (word == "Plated") return "plated holes";
  if (word == "NonPlated") return "unplated holes";
  return word == "MixedPlating" ? "plated and unplated holes" : std::string(word);
}

}  // namespace

std::string DrillAttributes::text() const {
  std::string out;
  if (!file_function.empty()) {
    const std::vector<std::string_view> parts = parts_of(file_function);
    out = plating_text(parts[0]);
    if (parts.size() > 2) out += fmt::format(" of layers {} to {}", parts[1], parts[2]);
  }
  std::string_view separator = out.empty() ? "" : ": ";
  for (const auto& [tool, function] : functions) {
    out += fmt::format("{}T{} {}", separator, tool, parts_of(function).back());
    separator = ", ";
  }
  return out;
}

DrillAttributes read_drill_attributes(std::string_view program) {
  DrillAttributes attributes;
  std::string_view function;
  for (LineCursor cursor(program); !cursor.at_end();) {
    const std::string_view line = cursor.next().text;
    if (line.starts_with('X') || line.starts_with('Y')) break;
    const std::string_view attribute = behind(line, "; #@! ");
    if (const auto value = behind(attribute, "TF.FileFunction,"); !value.empty()) {
      attributes.file_function = value;
    } else if (const auto of_tool = behind(attribute, "TA.AperFunction,"); !of_tool.empty()) {
      function = of_tool;
    } else if (attribute.starts_with("TD")) {
      function = {};
    } else if (const auto tool = behind(line, "T"); !tool.empty() && !function.empty()) {
      int number = 0;
      const auto read = std::from_chars(tool.data(), tool.data() + tool.size(), number);
      if (read.ec == std::errc() && number > 0) attributes.functions[number] = function;
      function = {};
    }
  }
  return attributes;
}

}  // namespace panelcal
