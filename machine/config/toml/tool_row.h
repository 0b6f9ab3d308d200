// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/fields/slots.h"
#include "machine/config/toml/ranges.h"
#include "machine/config/toml/toml_table.h"

// Not installed. Rows that name a tool by its number or its drill's diameter.
namespace panelcal::internal {

inline constexpr Range kDrillDiameter_mm{.low = 0, .high = 100, .low_is_open = true};

/// The field `number` of a row that may have `drill_mm` instead.
template <auto number>
constexpr Field tool_number(std::string_view meaning) {
  return count<number>("number", {1, kMaxToolNumber}, meaning)
      .required("number, or drill_mm")
      .or_key("drill_mm");
}

/// Checks that a row has a number or a diameter.
inline Expected<void> check_names_tool(const TomlTable& row) {
  if (row.has("number") || row.has("drill_mm")) return {};
  return failure(row.missing("number", "number, or drill_mm"));
}

/// Checks that a row has one of them alone.
inline Expected<void> check_names_one_tool(const TomlTable& row) {
  PANELCAL_CHECK(check_names_tool(row));
  if (!row.has("number") || !row.has("drill_mm")) return {};
  return failure(row.problem("drill_mm", "number or drill_mm", "there are both"));
}

/// Adds a row (with members `number` and `drill`) that names no tool of an earlier one.
///
/// In     is_same: of two diameters
template <class Row>
Expected<void> add_tool_row(const TomlTable& table,
                            const Row& row,
                            bool (*is_same)(Length, Length),
                            std::vector<Row>& rows) {
  for (const Row& other : rows) {
    const bool names_it =
        row.number || other.number ? row.number == other.number : is_same(*row.drill, *other.drill);
    if (!names_it) continue;
    return failure(table.problem(
        row.number ? "number" : "drill_mm", "each tool once", "another row names it"));
  }
  rows.push_back(row);
  return {};
}

inline bool is_within_um(Length a, Length b) {
  return std::abs((a - b).in_um()) <= 1;
}

}  // namespace panelcal::internal
