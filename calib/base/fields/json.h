// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/fields/field.h"
#include "calib/base/json/json_line.h"
#include <nlohmann/json_fwd.hpp>

// Not installed. Reads and writes the objects of a JSON file by their tables (field.h), both ways
// by the same rows:
//
//   constexpr std::array kProbeFields = {
//       plain<&Probe::place>("place", kPlace, "where it was probed"),
//       plain<&Probe::height>("height", kPlace, "above the table plane")};
//   constexpr JsonTable<Probe> kProbe{"probe", kProbeFields};
namespace panelcal::internal {

/// The layout of a table's keys in a file.
enum class JsonLayout : std::uint8_t {
  Flow,  ///< one behind the other, but for those that begin a line
  Lines  ///< each on a line of its own
};

/// A table of a JSON file whose values go into a T; `name` is what messages call one.
template <class T>
struct JsonTable : TableDescription {
  constexpr JsonTable(std::string_view table_name,
                      std::span<const Field> table_fields,
                      JsonLayout layout = JsonLayout::Flow,
                      int indent_of_lines = 2)
      : TableDescription{table_name, Rows::One, "", table_fields, ""} {
    is_in_lines = layout == JsonLayout::Lines;
    indent = indent_of_lines;
    for (const Field& field : table_fields) {
      if (field.owner != &kOwner<T>) throw "a field of another type";
    }
  }
};

/// The look of a text of JSON.
enum class JsonStyle : std::uint8_t {
  File,     ///< for people: lines and spaces; ASCII
  Compact,  ///< no spaces; ASCII
  Line      ///< the same of JSON Lines: UTF-8, and minus zero keeps its sign
};

/// The text of an object, with a line break behind it if it is a file for people. Numbers are in
/// the fewest digits that read back exactly; one that is not finite becomes a text, which no reader
/// of a number takes.
std::string json_text(const TableDescription& table, const void* object, JsonStyle style);
template <class T>
std::string json_text(const JsonTable<T>& table, const T& object, JsonStyle style) {
  return json_text(static_cast<const TableDescription&>(table), &object, style);
}

/// Reads an object: every key that a table has must be there, unless the file may lack it, and no
/// other may.
///
/// Fails  `code`, with the file: a key that is unknown (naming the nearest known one), missing or
///        has a value that its field does not take
Expected<void> read_json(const TableDescription& table,
                         const nlohmann::json& value,
                         void* object,
                         Code code,
                         const std::string& file);
template <class T>
Expected<T> read_json(const JsonTable<T>& table,
                      const nlohmann::json& value,
                      Code code,
                      const std::string& file) {
  T object{};
  PANELCAL_CHECK(
      read_json(static_cast<const TableDescription&>(table), value, &object, code, file));
  return object;
}

/// The same of a line, at its line and column; null is as good as absent.
Expected<void> read_line(const TableDescription& table,
                         const JsonLine& line,
                         void* object,
                         Code code);
template <class T>
Expected<T> read_line(const JsonTable<T>& table, const JsonLine& line, Code code) {
  T object{};
  PANELCAL_CHECK(read_line(static_cast<const TableDescription&>(table), line, &object, code));
  return object;
}

}  // namespace panelcal::internal
