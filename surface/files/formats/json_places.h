// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include "surface/files/text_fields.h"

// Not installed: part of surface/files/probe_file.h.
namespace panelcal::internal {

/// The values of a JSON document, each with its line and column, which other readers do not know.
///
/// Precondition: parse_strict_json() accepts the text, which outlives this.
class JsonPlaces {
 public:
  explicit JsonPlaces(std::string_view text);

  /// A value of the text and where it stands; the whole text without a value.
  TextField field(std::string_view value) const;
  std::string_view document() const;

  /// Keys, as written between the quotes, and values; empty unless the value is an object.
  static std::vector<std::pair<std::string_view, std::string_view>> members(
      std::string_view object);
  /// Empty unless the value is an array.
  static std::vector<std::string_view> elements(std::string_view array);
  /// The value of a key; empty if there is none.
  static std::string_view member(std::string_view object, std::string_view key);

 private:
  std::string_view text_;
  std::vector<std::size_t> line_starts_;
};

}  // namespace panelcal::internal
