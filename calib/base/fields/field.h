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
  // Of JSON alone.
  Time,     ///< UTC
  Counter,  ///< a whole number of 64 bits without a sign
  Wholes,
  Matrix,   ///< rows of numbers
  Object,   ///< a table in a table
  Objects,  ///< a list of them
  Any,      ///< is not looked at
};

/// The value of a key: the member of its field's kind. Numbers are in the units that panelcal
/// stores.
struct FieldValue {
  bool truth = false;
  bool is_off = false;  ///< of a Limit; of an optional value: there is none
  std::int64_t whole = 0;
  double number = 0;
  std::chrono::sys_seconds time{};
  std::string text;
  std::vector<double> numbers;  ///< also a pair's, and a matrix's row by row; NaN: null
  std::vector<std::int64_t> wholes;
  std::vector<std::string> texts;
  std::filesystem::path folder;  ///< of the file that states it
};

/// A unit that keys end with.
struct FieldUnit {
  double (*stored)(double written) = [](double v) { return v; };
  double (*written)(double stored) = [](double v) { return v; };
};

struct TableDescription;

/// The objects of a type that lie in another one: of a member that is an object, an optional one,
/// or a list.
struct InnerObjects {
  /// Gives the object that is read next: the member itself, or a new element.
  void* (*open)(void* object) = nullptr;
  std::size_t (*count)(const void* object) = nullptr;
  const void* (*at)(const void* object, std::size_t i) = nullptr;
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
  FieldUnit unit;
  /// Puts a value into an object of the table's type; false: the text is not as expected.
  bool (*store)(void* object, const FieldValue& value) = nullptr;
  /// Takes the value of an object; false: it has none.
  bool (*load)(const void* object, FieldValue& value) = nullptr;
  const void* owner = nullptr;  ///< the type of the object, see kOwner

  std::size_t n_rows = 0;     ///< of numbers and matrices; 0: any number
  std::size_t n_columns = 0;  ///< of a matrix; 0: as there are rows
  bool is_optional = false;   ///< in JSON null stands for none
  bool may_lack = false;      ///< in JSON the key is left out where there is no value
  bool has_gaps = false;      ///< of numbers: some may be null
  double left_out_at = std::numeric_limits<double>::quiet_NaN();  ///< the value without the key
  const TableDescription* table = nullptr;                        ///< of objects
  InnerObjects inner;
  bool is_alone_plain = false;  ///< a list of one object is that object, without brackets
  bool is_on_new_line = false;  ///< in a file that has lines
  bool is_in_lines = false;     ///< each element of a list is on a line of its own

  /// A copy with another value of a member. It stands ahead of its callers, since clang 16 does not
  /// know it in constant expressions otherwise.
  template <class Value>
  constexpr Field with(Value Field::*member, Value value) const {
    Field field = *this;
    field.*member = value;
    return field;
  }

  /// The table must have the key, or its `alternative`; `how` a user may write it.
  constexpr Field required(std::string_view how) const { return with(&Field::example, how); }
  constexpr Field or_key(std::string_view other) const { return with(&Field::alternative, other); }
  constexpr Field without(std::string_view what) const { return with(&Field::absence, what); }
  /// Of a value without a member's type.
  constexpr Field within(Range those) const { return with(&Field::range, those); }
  constexpr Field within(WholeRange those) const { return with(&Field::whole, those); }
  constexpr Field or_off() const { return of_kind(FieldKind::Limit); }
  constexpr Field as_folder() const { return of_kind(FieldKind::Folder); }
  constexpr Field not_empty(std::string_view what) const { return with(&Field::expected, what); }
  /// Of a number without a type of its own: the key is in um, the number in mm.
  constexpr Field um_in_mm() const {
    Field field = *this;
    field.unit = {[](double written) { return written * 1e-3; },
                  [](double stored) { return stored * 1e3; }};
    return field;
  }
  /// In JSON: a file may lack the key, which is then left out if there is no value.
  constexpr Field or_absent() const { return with(&Field::may_lack, true); }
  /// The same for a number that has this value without the key.
  constexpr Field or_absent(double value) const {
    Field field = or_absent();
    field.left_out_at = value;
    return field;
  }
  constexpr Field or_null() const { return with(&Field::is_optional, true); }
  /// Of an optional member that a file has to state.
  constexpr Field never_null() const { return with(&Field::is_optional, false); }
  /// A matrix as a list of its numbers, row by row.
  constexpr Field flat() const {
    Field field = of_kind(FieldKind::Numbers);
    field.n_rows *= n_columns;
    return field;
  }
  /// Of a matrix without a member's type.
  constexpr Field columns(std::size_t n) const { return with(&Field::n_columns, n); }
  constexpr Field on_new_line() const { return with(&Field::is_on_new_line, true); }
  constexpr Field plain_alone() const { return with(&Field::is_alone_plain, true); }
  constexpr Field in_lines() const { return with(&Field::is_in_lines, true); }
  constexpr Field of_kind(FieldKind other) const { return with(&Field::kind, other); }

  bool is_required() const { return !example.empty(); }
  /// The values that the key takes, as messages have it: "a whole number from 1 to 12".
  std::string takes() const;
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
  bool is_in_lines = false;  ///< as JSON each key is on a line of its own
  int indent = 0;            ///< of the lines in it, against the line that it begins on

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
