// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include <nlohmann/json.hpp>

// Not installed: public headers know nothing of JSON.
namespace panelcal::internal {

/// Calibration files nest three deep; a file of a million brackets is not one of them.
inline constexpr std::size_t kMaxJsonDepth = 16;

/// Parses JSON as RFC 8259 has it, and refuses what parsers commonly let pass: keys that appear
/// twice, numbers too large for a double, nesting beyond kMaxJsonDepth.
///
/// Fails  json-syntax, with line and column where the text stops making sense
Expected<nlohmann::json> parse_strict_json(std::string_view text, const std::string& file);

/// The members of one JSON object, each of which must be there and have its type; nothing else
/// may be. `name` is what messages call the object.
///
/// Fails  `code`, with the file; a misspelt key names the nearest known one
class StrictObject {
 public:
  static Expected<StrictObject> make(const nlohmann::json& value,
                                     std::string name,
                                     std::span<const std::string_view> keys,
                                     Code code,
                                     std::string file);

  Expected<double> number(std::string_view key) const;
  Expected<std::string> text(std::string_view key) const;
  /// A string that has only one right value.
  Expected<void> constant(std::string_view key, std::string_view value) const;
  /// A whole number from low to high.
  Expected<int> integer(std::string_view key, int low, int high) const;
  /// An array of exactly n finite numbers.
  Expected<std::vector<double>> numbers(std::string_view key, std::size_t n) const;
  /// n_rows arrays of n_columns numbers each, row by row.
  Expected<std::vector<double>> matrix(std::string_view key,
                                       std::size_t n_rows,
                                       std::size_t n_columns) const;
  const nlohmann::json& member(std::string_view key) const;

 private:
  StrictObject(const nlohmann::json& value, std::string name, Code code, std::string file);
  Diagnostic problem(std::string_view key, std::string what, std::string expected) const;

  const nlohmann::json* value_;
  std::string name_;
  Code code_;
  std::string file_;
};

}  // namespace panelcal::internal
