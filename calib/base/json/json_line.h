// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "calib/base/expected.h"

// Not installed.
namespace panelcal::internal {

/// A number as it is written, which is valid JSON. Converted only where it is used, since the
/// common readers make an integer of -0 and lose its sign.
struct JsonNumber {
  std::string_view text;
};

/// A member of a flat object.
struct JsonMember {
  std::string key;
  int column = 0;  ///< of the key
  /// std::monostate: null.
  std::variant<JsonNumber, std::string, bool, std::vector<JsonNumber>, std::monostate> value;
  int value_column = 0;
  std::string_view raw;  ///< the value as written
};

/// One line of a JSON Lines file: an object of numbers, texts, truth values and arrays of numbers,
/// which read_line() of calib/base/fields/json.h puts where they belong.
///
/// A reader of our own because general ones do not say where a value stands, and because a line
/// that does not nest cannot overflow a stack. Columns count bytes from 1. Views the text it was
/// parsed from. A key whose value is null is as good as absent, which is how other programs write
/// what they do not know.
class JsonLine {
 public:
  /// Fails  json-syntax: the first place that RFC 8259, or a flat object, does not allow; a key
  ///        that appears twice
  static Expected<JsonLine> parse(std::string_view text, Place line);

  /// Fails with `code` at a key that is not known, naming the nearest one.
  Expected<void> check_keys(std::span<const std::string_view> known, Code code) const;

  bool has(std::string_view key) const { return find(key) != nullptr; }
  /// Null if the key is absent or its value is null.
  const JsonMember* find(std::string_view key) const;

  /// At the value of a key that is there: what is wrong with it.
  Diagnostic problem(std::string_view key, Code code, std::string expected) const;
  Diagnostic missing(std::string_view key, Code code) const;

 private:
  explicit JsonLine(Place line) : line_(std::move(line)) {}
  bool is_taken(std::string_view key) const;

  Place line_;
  std::vector<JsonMember> members_;
};

}  // namespace panelcal::internal
