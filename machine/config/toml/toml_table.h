// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/fields/field.h"
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
  /// The whole of a file.
  static Expected<TomlTable> of_file(const toml::table& document,
                                     const FileDescription& file,
                                     const TomlSource& source);

  /// A table of this one, which the file's description has.
  Expected<std::optional<TomlTable>> table(const TableDescription& description) const;
  /// The tables of an array of tables.
  Expected<std::vector<TomlTable>> tables(const TableDescription& description) const;
  /// Reads all keys of this table into an object; absent ones leave it as it is.
  ///
  /// Fails  config-value: required keys that are missing, all of them; a value
  template <class T, T (*start)()>
  Expected<void> read(const Table<T, start>& description, T& object) const {
    return read_fields(description, &object);
  }
  /// Reads a table of this one; empty if it is not there.
  template <class T, T (*start)()>
  Expected<std::optional<TomlTable>> read_table(const Table<T, start>& description,
                                                T& object) const {
    PANELCAL_TRY(std::optional<TomlTable> child, table(description));
    if (child) PANELCAL_CHECK(child->read(description, object));
    return child;
  }

  /// Of the file, from which the names of others count.
  std::filesystem::path folder() const;
  bool has(std::string_view key) const { return table_->contains(key); }
  /// Precondition: has(key)
  Place place_of(std::string_view key) const { return problem(key, {}).place; }
  /// Fails  config-value, with all keys that the table lacks
  Expected<void> require(std::span<const RequiredKey> keys) const;
  /// The key's value is the text "off".
  bool is_off(std::string_view key) const;
  Expected<std::optional<double>> number(std::string_view key, const Range& range) const;
  /// Whole numbers, written without a decimal point.
  Expected<std::optional<std::int64_t>> integer(std::string_view key,
                                                const WholeRange& range) const;
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

  /// "key = value": why it will not do. Precondition: has(key).
  Diagnostic problem(std::string_view key, std::string expected, std::string because = {}) const;
  /// Something that is not there.
  Diagnostic missing(std::string_view what, std::string expected) const;

 private:
  TomlTable(const toml::table& table,
            std::string name,
            const FileDescription& file,
            const TomlSource& source);
  /// `name` is what messages call it, such as "[vision]"; the file's description has its keys under
  /// `path`.
  static Expected<TomlTable> make(const toml::table& table,
                                  std::string name,
                                  std::string_view path,
                                  std::string_view planned,
                                  const FileDescription& file,
                                  const TomlSource& source);
  Expected<TomlTable> child(const toml::node& node, const TableDescription& description) const;
  Expected<void> read_fields(const TableDescription& description, void* object) const;
  Expected<void> read_value(const Field& field, FieldValue& value) const;
  Expected<double> checked_number(std::string_view key,
                                  const toml::node& node,
                                  const Range& range) const;
  Diagnostic wrong_value(std::string_view key, const toml::node& node, std::string expected) const;

  const toml::table* table_;
  std::string name_;
  const FileDescription* file_;
  const TomlSource* source_;
};

}  // namespace panelcal::internal
