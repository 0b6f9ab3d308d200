// SPDX-License-Identifier: Apache-2.0
#include "machine/config/toml/required_keys.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::internal {
namespace {

/// A key of a table, with another that will do instead, and how a user may write it.
struct NeededKey {
  std::string_view table;  ///< "camera.zoom"; of an array, each of its tables
  std::string_view key;
  std::string_view other;  ///< empty: there is none
  std::string_view example;
};

constexpr std::array<NeededKey, 18> kNeededKeys = {{
    {"camera", "calibration", "", "calibration = \"NAME.cal.json\""},
    {"camera.zoom", "level", "", "level = 3, as in $uvis,zoom,3"},
    {"camera.zoom", "calibration", "", "calibration = \"NAME.cal.json\""},
    {"coupon", "origin_mm", "", "origin_mm = [x, y]"},
    {"depth", "number", "drill_mm", "number, or drill_mm"},
    {"depth", "depth_mm", "", "depth_mm = 0.8"},
    {"diameter_page", "diameter_mm", "", "diameter_mm = 1.016"},
    {"ledger", "file", "", "file = \"NAME.ledger\""},
    {"nightly", "camera", "machine_driver", "camera = \"URI\" or machine_driver = \"sim\""},
    {"nightly.surface", "file", "", "file = \"NAME.json\", the map that nights write"},
    {"nightly.surface", "low_mm", "", "low_mm = [x, y]"},
    {"nightly.surface", "high_mm", "", "high_mm = [x, y]"},
    {"nightly.table", "plate", "", "plate = \"NAME\""},
    {"table", "calibration", "", "calibration = \"NAME.cal.json\""},
    {"tolerance.tool", "number", "drill_mm", "number, or drill_mm"},
    {"vision.tool", "number", "", "number = 1, as in G34,1"},
    {"vision.tool", "shape", "", "shape = \"disc\" or another"},
    {"vision.tool", "size_mm", "size_px", "size_mm = 1, or size_px = 40 without [camera]"},
}};

/// A table that lacks keys.
struct LackingTable {
  Place place;
  std::string name;  ///< "[[vision.tool]]"
  std::vector<NeededKey> keys;

  /// Those that the table's own reader has named.
  void leave_out_those_of(const Diagnostic& problem) {
    std::erase_if(keys, [&](const NeededKey& needed) {
      const auto names = [&](std::string_view key) {
        return !key.empty() && problem.what.find(quoted(key)) != std::string::npos;
      };
      return names(needed.key) || names(needed.other) ||
             problem.expected.find(needed.example) != std::string::npos;
    });
  }

  /// `[[vision.tool]] (line 7): missing keys "number", "shape"`.
  std::string text() const {
    std::vector<std::string> absent;
    for (const NeededKey& needed : keys) absent.push_back(quoted(needed.key));
    return fmt::format("{} (line {}): missing {} {}",
                       name,
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

void note_absent(const NeededKey& needed,
                 const toml::table& document,
                 const TomlSource& source,
                 std::vector<LackingTable>& lacking) {
  for (const toml::table* const table : tables_of(document, needed.table)) {
    if (table->contains(needed.key)) continue;
    if (!needed.other.empty() && table->contains(needed.other)) continue;
    const Place place = source.place(table->source().begin);
    const auto is_this = [&](const LackingTable& one) {
      return one.place.line == place.line && one.place.column == place.column;
    };
    auto found = std::ranges::find_if(lacking, is_this);
    if (found == lacking.end()) {
      const toml::node* const node = document.at_path(needed.table).node();
      const bool is_row = node != nullptr && node->is_array();
      const std::string name =
          is_row ? fmt::format("[[{}]]", needed.table) : fmt::format("[{}]", needed.table);
      found = lacking.insert(lacking.end(), {place, name, {}});
    }
    found->keys.push_back(needed);
  }
}

}  // namespace

Diagnostic with_all_missing_keys(Diagnostic problem,
                                 const toml::table& document,
                                 const TomlSource& source) {
  std::vector<LackingTable> lacking;
  for (const NeededKey& needed : kNeededKeys) note_absent(needed, document, source, lacking);
  std::ranges::sort(lacking, {}, [](const LackingTable& one) { return one.place.line; });
  const auto is_its = [&](const LackingTable& one) {
    return problem.code == Code::ConfigValue && one.place.line == problem.place.line &&
           one.place.column == problem.place.column;
  };
  if (std::ranges::none_of(lacking, is_its)) return problem;
  const Diagnostic first = problem;
  for (LackingTable& one : lacking) {
    if (is_its(one)) one.leave_out_those_of(first);
    if (one.keys.empty()) continue;
    problem.what += "; " + one.text();
    for (const NeededKey& needed : one.keys) {
      problem.expected += fmt::format("; {}", needed.example);
    }
  }
  return problem;
}

}  // namespace panelcal::internal
