// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// Not installed. What a file may hold, whatever its notation: each table with its keys, their
// units, ranges and meaning, and where their values go. Readers, pages and schemas come from it.
//
//   constexpr std::array kSettleFields = {
//       field<&NightTrials::settle_limit>("limit_um", kAboveZero_um, "error that ..."),
//       field<&NightTrials::settle_longest>("longest_s", {1e-3, 3600}, "longest wait that ...")};
//   constexpr Table<NightTrials> kSettle{"nightly.settle", "", kSettleFields};
namespace panelcal::internal {

/// Numbers that a key takes.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_is_open = false;  ///< `low` itself is outside

  constexpr bool contains(double v) const {
    return (low_is_open ? v > low : v >= low) && v <= high;
  }
  /// "a number from 0 to 1", "a number above 0".
  std::string text() const;
};

/// Whole numbers that a key takes, both ends included.
struct WholeRange {
  std::int64_t low = 0;
  std::int64_t high = 0;

  constexpr bool contains(std::int64_t v) const { return v >= low && v <= high; }
  /// "a whole number from 1 to 100".
  std::string text() const;
};

enum class FieldKind : std::uint8_t {
  Truth,
  Whole,
  Number,
  Limit,  ///< a number, or "off"
  Pair,   ///< [x, y]
  Numbers,
  Text,
  Word,    ///< one of a few texts
  Form,    ///< a text of some form
  File,    ///< a name, relative to the file that states it
  Folder,  ///< the same
  Texts,
  WallTime,  ///< a date and a time without a zone
};

/// The value of a key: the member of its field's kind. Numbers are in the units that panelcal
/// stores.
struct FieldValue {
  bool truth = false;
  bool is_off = false;  ///< of a Limit
  std::int64_t whole = 0;
  double number = 0;
  std::chrono::sys_seconds time{};
  std::string text;
  std::vector<double> numbers;  ///< also a pair's
  std::vector<std::string> texts;
  std::filesystem::path folder;  ///< of the file that states it
};

/// A unit that keys end with.
struct FieldUnit {
  double (*stored)(double written);
};

/// One key of a table.
struct Field {
  std::string_view key;
  FieldKind kind = FieldKind::Text;
  Range range;                   ///< of numbers, as written
  WholeRange whole;              ///< of a whole number
  std::string_view expected;     ///< of a Word or a Form; of a Text: that it may not be empty
  std::string_view meaning;      ///< the manual's text
  std::string_view absence;      ///< that holds without the key, where no initial value says it
  std::string_view example;      ///< of a required key
  std::string_view alternative;  ///< a key that will do instead of a required one
  FieldUnit unit = {[](double written) { return written; }};
  /// Puts a value into an object of the table's type; false: the text is not as expected.
  bool (*store)(void* object, const FieldValue& value) = nullptr;
  /// Takes the value of an object; false: it has none.
  bool (*load)(const void* object, FieldValue& value) = nullptr;
  const void* owner = nullptr;  ///< the type of the object, see kOwner

  /// The table must have the key, or its `alternative`; `how` a user may write it.
  constexpr Field required(std::string_view how) const {
    Field field = *this;
    field.example = how;
    return field;
  }
  constexpr Field or_key(std::string_view other) const {
    Field field = *this;
    field.alternative = other;
    return field;
  }
  constexpr Field without(std::string_view what) const {
    Field field = *this;
    field.absence = what;
    return field;
  }
  /// Of a value without a member's type.
  constexpr Field within(Range those) const {
    Field field = *this;
    field.range = those;
    return field;
  }
  constexpr Field within(WholeRange those) const {
    Field field = *this;
    field.whole = those;
    return field;
  }
  constexpr Field or_off() const { return of_kind(FieldKind::Limit); }
  constexpr Field as_folder() const { return of_kind(FieldKind::Folder); }
  constexpr Field not_empty(std::string_view what) const {
    Field field = *this;
    field.expected = what;
    return field;
  }
  /// Of a number without a type of its own: the key is in um, the number in mm.
  constexpr Field um_in_mm() const {
    Field field = *this;
    field.unit = {[](double written) { return written * 1e-3; }};
    return field;
  }

  bool is_required() const { return !example.empty(); }
  /// The values that the key takes, as messages have it: "a whole number from 1 to 12".
  std::string takes() const;

 private:
  constexpr Field of_kind(FieldKind other) const {
    Field field = *this;
    field.kind = other;
    return field;
  }
};

enum class Rows : std::uint8_t {
  One,
  Many,  ///< an array of tables
};

/// One table of a file.
struct TableDescription {
  std::string_view name;  ///< with those that it lies in: "nightly.settle"
  Rows rows = Rows::One;
  std::string_view about;  ///< Markdown, for the page of the file
  std::span<const Field> fields;
  /// Keys that are agreed on and not yet supported: an error of its own, so that no user searches
  /// for a typing error.
  std::string_view planned;
  /// Value of a field in an object that no file has touched; false: none.
  bool (*initial)(const Field& field, FieldValue& value) = nullptr;

  /// That value as TOML and JSON write it; empty if there is none.
  std::string initial_text(const Field& field) const;

  /// "[nightly.settle]", "[[vision.tool]]".
  std::string heading() const;
  /// Of a table in a table: "nightly"; of others empty.
  std::string_view parent() const;
  /// "settle".
  std::string_view key() const;
};

/// The address of kOwner<T> stands for the type T.
template <class T>
inline constexpr char kOwner = 0;

template <class T>
T initially() {
  return T();
}

/// A table whose values go into a T.
///
/// In     start: makes the T that holds before anything is read
template <class T, T (*start)() = initially<T>>
struct Table : TableDescription {
  constexpr Table(std::string_view table_name,
                  std::string_view about_it,
                  std::span<const Field> table_fields,
                  Rows how_many = Rows::One,
                  std::string_view planned_key = {})
      : TableDescription{table_name, how_many, about_it, table_fields, planned_key, initial_value} {
    for (const Field& field : table_fields) {
      if (field.owner != &kOwner<T>) throw "a field of another type";
    }
  }

 private:
  static bool initial_value(const Field& field, FieldValue& value) {
    const T object = start();
    return field.load != nullptr && field.load(&object, value);
  }
};

/// Tables of one section.
using Tables = std::span<const TableDescription* const>;

/// All tables of a kind of file, in the order of its page.
struct FileDescription {
  std::string_view name;  ///< "machine.toml"
  std::vector<const TableDescription*> tables;

  /// Keys and tables that may stand in a table, or with an empty name in the file, sorted.
  std::vector<std::string_view> known_keys(std::string_view table) const;
};

}  // namespace panelcal::internal
