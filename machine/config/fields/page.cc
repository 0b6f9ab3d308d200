// SPDX-License-Identifier: Apache-2.0
#include "machine/config/fields/page.h"

#include <string_view>

#include "calib/base/append_format.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// A bar inside a table's cell would end it.
std::string cell(std::string_view text) {
  std::string safe;
  for (const char c : text) safe += c == '|' ? std::string("\\|") : std::string(1, c);
  return safe;
}

std::string values_cell(const Field& field) {
  if (field.kind == FieldKind::Text && field.expected.empty()) return "a text";
  if (field.kind == FieldKind::Text) return std::string(field.expected);
  if (field.kind == FieldKind::Texts) return "a list of texts";
  if (field.kind == FieldKind::WallTime) return "a date and a time";
  const bool is_several = field.kind == FieldKind::Pair || field.kind == FieldKind::Numbers;
  if (!is_several) return field.takes();
  const std::string range = field.range.text();
  return fmt::format(
      "{} {}", field.kind == FieldKind::Pair ? "[x, y], each" : "a list, each", range);
}

std::string default_cell(const TableDescription& table, const Field& field) {
  if (field.is_required()) {
    return field.alternative.empty() ? "required"
                                     : fmt::format("required, or `{}`", field.alternative);
  }
  if (!field.absence.empty()) return std::string(field.absence);
  const std::string text = table.initial_text(field);
  return text.empty() ? text : fmt::format("`{}`", text);
}

}  // namespace

std::string page_of(const FileDescription& file) {
  std::string out;
  std::string_view last;
  for (const TableDescription* const table : file.tables) {
    if (table->name != last) {
      append_format(out, "\n## `{}`\n\n", table->heading());
      if (!table->about.empty()) append_format(out, "{}\n\n", table->about);
      out += "| key | value | default | meaning |\n| --- | --- | --- | --- |\n";
    }
    last = table->name;
    for (const Field& field : table->fields) {
      append_format(out,
                    "| `{}` | {} | {} | {} |\n",
                    field.key,
                    cell(values_cell(field)),
                    cell(default_cell(*table, field)),
                    cell(field.meaning));
    }
  }
  return out;
}

}  // namespace panelcal::internal
