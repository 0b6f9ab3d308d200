// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"

// Not installed: part of surface/files/probe_file.h.
namespace panelcal::internal {

/// Text of one line and where it stands.
struct TextField {
  std::string_view text;
  int line = 0;
  int column = 1;  ///< of its first byte
};

/// The lines of a text; LF, CR and CR LF end one.
class TextLines {
 public:
  /// `file` stands in the diagnostics. A UTF-8 mark at the beginning is no part of the text.
  TextLines(std::string_view text, std::string file);

  /// The next line, without its end; empty behind the last one.
  ///
  /// Fails  measurement-file: a line of more than 65536 bytes
  Expected<std::optional<TextField>> next();
  /// The next line that is not blank.
  Expected<std::optional<TextField>> next_filled();
  /// The next line, which must be there; `expected` says what it is.
  Expected<TextField> require(std::string_view expected);

  const std::string& file() const { return file_; }

 private:
  std::string_view rest_;
  std::string file_;
  int number_ = 0;
};

/// The text between blanks.
std::vector<TextField> words_of(const TextField& line);
/// The text between commas or other separators, without the blanks around it.
std::vector<TextField> cells_of(const TextField& line, char separator = ',');
/// The part of a line from `begin` on, up to `end`.
TextField part_of(const TextField& line,
                  std::size_t begin,
                  std::size_t end = std::string_view::npos);
/// The same without the blanks around it.
TextField trimmed(const TextField& field);

/// That the last line has a line end: without one its last number may be cut off.
///
/// Fails  measurement-file, at that line
Expected<void> check_line_end(std::string_view text, const std::string& file);

/// The first lines of a text that are not blank, at most n_most.
std::vector<TextField> first_lines(std::string_view text, std::size_t n_most);

/// True if all of it is a number, a plus sign ahead of it or not.
bool is_number(std::string_view word);

/// measurement-file, at a field: its text, and what was expected.
Diagnostic unexpected_field(const std::string& file, const TextField& at, std::string expected);

/// A number that is one from end to end and not beyond 1e6 of its unit, a kilometer.
Expected<double> number_of(const std::string& file, const TextField& field);
/// The same with a plus sign ahead of it, or without.
Expected<double> signed_number_of(const std::string& file, const TextField& field);
/// Digits of a whole number from low to high.
Expected<int> count_of(const std::string& file, const TextField& field, int low, int high);

}  // namespace panelcal::internal
