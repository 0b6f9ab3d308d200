// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include <Eigen/Core>
#include <toml++/toml.h>

// Not installed: public headers know nothing of TOML.
namespace panelcal::internal {

/// A TOML file, kept so that messages can show what it says.
struct TomlSource {
  std::string file;
  std::string_view text;

  Place place(const toml::source_position& at) const;
  /// The text of a region, fit for a message; its first line only.
  std::string excerpt(const toml::source_region& region) const;
};

/// Bytes of the longest line that is read: a long enough chain of dotted keys would nest deeper
/// than any stack.
inline constexpr std::size_t kMaxTomlLine = 1000;

/// Parses TOML 1.0.
///
/// Fails  toml-syntax, with line and column
Expected<toml::table> parse_toml(const TomlSource& source);

/// Numbers that a key takes.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_is_open = false;  ///< `low` itself is outside

  bool contains(double v) const { return (low_is_open ? v > low : v >= low) && v <= high; }
  /// "a number from 0 to 1", "a number above 0".
  std::string text() const;
};

/// The keys a table may have.
struct TomlKeys {
  std::span<const std::string_view> known;
  /// Agreed on, not yet supported: an error of its own, so that no user searches for a typing
  /// error.
  std::span<const std::string_view> planned;
};

/// A key that a table must have, and how a user may write it.
struct RequiredKey {
  std::string_view key;
  std::string_view example;
};

/// One table of which every key is known. Readers give nothing for an absent key.
///
/// Fails  config-key-unknown; not-supported; config-value: with the key's or the value's place
class TomlTable {
 public:
  /// `name` is what messages call it, such as "[vision]"; `at` is its place.
  static Expected<TomlTable> make(const toml::table& table,
                                  std::string name,
                                  const toml::source_region& at,
                                  const TomlKeys& keys,
                                  const TomlSource& source);

  bool has(std::string_view key) const { return table_->contains(key); }
  /// Fails  config-value, with all keys that the table lacks
  Expected<void> require(std::span<const RequiredKey> keys) const;
  Expected<void> require(std::initializer_list<RequiredKey> keys) const;
  /// The key's value is the text "off".
  bool is_off(std::string_view key) const;
  Expected<std::optional<double>> number(std::string_view key, const Range& range) const;
  Expected<double> number_or(std::string_view key, const Range& range, double otherwise) const;
  /// Whole numbers, written without a decimal point.
  Expected<std::optional<std::int64_t>> integer(std::string_view key,
                                                std::int64_t low,
                                                std::int64_t high) const;
  Expected<std::optional<std::string>> text(std::string_view key) const;
  Expected<std::optional<bool>> truth(std::string_view key) const;
  /// A date and a time on the wall, which has no zone: 2026-11-21T08:00:00.
  Expected<std::optional<std::chrono::sys_seconds>> wall_time(std::string_view key) const;
  /// A list of texts; empty for an absent key.
  Expected<std::vector<std::string>> texts(std::string_view key) const;
  Expected<std::optional<std::vector<double>>> numbers(std::string_view key,
                                                       const Range& range) const;
  /// Two numbers, [x, y].
  Expected<std::optional<Eigen::Vector2d>> pair(std::string_view key, const Range& range) const;
  /// A table of this table; `name` as in make.
  Expected<std::optional<TomlTable>> table(std::string_view key,
                                           std::string name,
                                           const TomlKeys& keys) const;
  /// The tables of an array of tables.
  Expected<std::vector<TomlTable>> tables(std::string_view key,
                                          std::string name,
                                          const TomlKeys& keys) const;

  /// "key = value": why it will not do. Precondition: has(key).
  Diagnostic problem(std::string_view key, std::string expected, std::string because = {}) const;
  Diagnostic not_supported(std::string_view key, std::string expected) const;
  /// Something that is not there.
  Diagnostic missing(std::string_view what, std::string expected) const;

 private:
  TomlTable(const toml::table& table,
            std::string name,
            const toml::source_region& at,
            const TomlSource& source);
  Expected<double> checked_number(std::string_view key,
                                  const toml::node& node,
                                  const Range& range) const;
  Diagnostic wrong_value(std::string_view key, const toml::node& node, std::string expected) const;

  const toml::table* table_;
  std::string name_;
  toml::source_region at_;
  const TomlSource* source_;
};

inline constexpr Range kAboveZero_um{0, 1e6, true};

/// A number in um, stored in mm, where it is given.
Expected<void> read_um_in_mm(const TomlTable& table, std::string_view key, double& value_mm);

}  // namespace panelcal::internal
