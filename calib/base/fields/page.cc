// SPDX-License-Identifier: Apache-2.0
#include "calib/base/fields/page.h"

#include <string_view>

#include "calib/base/append_format.h"
#include "calib/base/fields/noted_head.h"
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
  const std::string range = field.range.text();
  if (field.kind == FieldKind::Pair) return "[x, y], each " + range;
  if (field.kind == FieldKind::Numbers && field.n_rows == 0) return "a list, each " + range;
  const bool is_several = field.kind == FieldKind::Numbers || field.kind == FieldKind::Matrix;
  return is_several ? fmt::format("{}, each {}", field.takes(), range) : field.takes();
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

// NOLINTNEXTLINE(misc-no-recursion): as deep as tables lie in each other.
void append_json_rows(std::string& out, const TableDescription& table, const std::string& above) {
  for (const Field& field : table.fields) {
    append_format(out,
                  "| `{}{}` | {}{}{} | {} |\n",
                  above,
                  field.key,
                  cell(values_cell(field)),
                  field.is_optional && !field.may_lack ? ", or null" : "",
                  field.may_lack ? "; may be absent" : "",
                  cell(field.meaning));
    if (field.table == nullptr) continue;
    const char* const end = field.kind == FieldKind::Objects ? "[]." : ".";
    append_json_rows(out, *field.table, fmt::format("{}{}{}", above, field.key, end));
  }
}

}  // namespace

std::string page_of(const JsonFile& file) {
  std::string out = fmt::format("\n## {}\n\n{}\n", file.name, file.about);
  for (const TableDescription* const version : file.versions) {
    out += "\n| key | value | meaning |\n| --- | --- | --- |\n";
    append_json_rows(out, *version, "");
    if (!file.notes_ledger) continue;
    for (const TableDescription* const note : noted_head_tables()) {
      append_json_rows(out, *note, "ledger.");
    }
  }
  return out;
}

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
