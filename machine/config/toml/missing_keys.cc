// SPDX-License-Identifier: Apache-2.0
#include "machine/config/toml/missing_keys.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::internal {
namespace {

/// A table that lacks keys.
struct LackingTable {
  Place place;
  std::string heading;
  std::vector<const Field*> fields;

  /// Those that the table's own reader has named.
  void leave_out_those_of(const Diagnostic& problem) {
    std::erase_if(fields, [&](const Field* field) {
      const auto names = [&](std::string_view key) {
        return !key.empty() && problem.what.find(quoted(key)) != std::string::npos;
      };
      return names(field->key) || names(field->alternative) ||
             problem.expected.find(field->example) != std::string::npos;
    });
  }

  /// `[[vision.tool]] (line 7): missing keys "number", "shape"`.
  std::string text() const {
    std::vector<std::string> absent;
    for (const Field* const field : fields) absent.push_back(quoted(field->key));
    return fmt::format("{} (line {}): missing {} {}",
                       heading,
                       place.line,
                       absent.size() == 1 ? "key" : "keys",
                       fmt::join(absent, ", "));
  }
};

/// The tables of this name, one by one; none if the file has something else there.
std::vector<const toml::table*> tables_of(const toml::table& document, std::string_view path) {
  const toml::node* node = document.at_path(path).node();
  std::vector<const toml::table*> tables;
  if (node == nullptr) return tables;
  if (const toml::table* const table = node->as_table()) {
    tables.push_back(table);
  } else if (const toml::array* const array = node->as_array()) {
    for (const toml::node& row : *array) {
      if (const toml::table* const one = row.as_table()) tables.push_back(one);
    }
  }
  return tables;
}

std::vector<LackingTable> lacking_tables(const toml::table& document,
                                         const FileDescription& file,
                                         const TomlSource& source) {
  std::vector<LackingTable> lacking;
  for (const TableDescription* const description : file.tables) {
    for (const toml::table* const table : tables_of(document, description->name)) {
      LackingTable one{source.place(table->source().begin), description->heading(), {}};
      for (const Field& field : description->fields) {
        const bool has_it = table->contains(field.key) ||
                            (!field.alternative.empty() && table->contains(field.alternative));
        if (field.is_required() && !has_it) one.fields.push_back(&field);
      }
      if (!one.fields.empty()) lacking.push_back(std::move(one));
    }
  }
  std::ranges::sort(lacking, {}, [](const LackingTable& one) { return one.place.line; });
  return lacking;
}

}  // namespace

Diagnostic with_all_missing_keys(Diagnostic problem,
                                 const toml::table& document,
                                 const FileDescription& file,
                                 const TomlSource& source) {
  std::vector<LackingTable> lacking = lacking_tables(document, file, source);
  const auto is_its = [&](const LackingTable& one) {
    return problem.code == Code::ConfigValue && one.place.line == problem.place.line &&
           one.place.column == problem.place.column;
  };
  if (std::ranges::none_of(lacking, is_its)) return problem;
  const Diagnostic first = problem;
  for (LackingTable& one : lacking) {
    if (is_its(one)) one.leave_out_those_of(first);
    if (one.fields.empty()) continue;
    problem.what += "; " + one.text();
    for (const Field* const field : one.fields) {
      problem.expected += fmt::format("; {}", field->example);
    }
  }
  return problem;
}

}  // namespace panelcal::internal
