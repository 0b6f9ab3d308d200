// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "calib/base/expected.h"

namespace panelcal {

/// A program's bytes and the name under which diagnostics know them.
struct SourceText {
  std::string file;
  std::string bytes;
  std::string sha256 = {};  ///< of the whole file as it is on disk; empty: not known
};

/// Fails  file-unreadable
Expected<SourceText> read_source(const std::filesystem::path& path);
/// The same, with the file's digest: of a stored pattern, which recordings name by its content.
Expected<SourceText> read_source_with_digest(const std::filesystem::path& path);

/// One line without its line end.
struct SourceLine {
  std::string_view text;
  int number = 0;  ///< from 1
  int column = 1;  ///< of the text's first character
};

/// A place between two lines. Unlike a cursor it stays good when the text is moved or copied.
struct LinePlace {
  std::size_t offset = 0;
  int number = 1;  ///< of the line that begins here
};

/// The last line is complete: nothing that it says can have been cut off.
inline bool ends_in_line_end(std::string_view text) {
  return text.ends_with('\n') || text.ends_with('\r');
}

/// The last line of a text, complete or not; the empty line 1 of an empty text.
SourceLine last_line(std::string_view text);

/// Number of line feeds of a text, counted eight characters at a time.
std::size_t count_line_feeds(std::string_view text);

/// Number of characters of a line end: CR LF and LF CR are one line end each; LF CR LF is an empty
/// line that ends in CR LF.
///
/// Precondition: `at` is a CR or LF before `end`
inline std::ptrdiff_t line_end_length(const char* at, const char* end) {
  if (at + 1 == end) return 1;
  if (at[0] == '\r' && at[1] == '\n') return 2;
  const bool begins_another = at + 2 != end && at[2] == '\n';
  return at[0] == '\n' && at[1] == '\r' && !begins_another ? 2 : 1;
}

/// Walks over the lines of a text; LF, CR, CR LF and LF CR all end a line. Copyable, so that a
/// place in the text can be kept and returned to.
class LineCursor {
 public:
  LineCursor() = default;
  /// Precondition: `from` is a place of this text.
  explicit LineCursor(std::string_view bytes, LinePlace from = {})
      : bytes_(bytes), offset_(from.offset), number_(from.number) {}

  bool at_end() const { return offset_ >= bytes_.size(); }
  /// Precondition: !at_end().
  SourceLine next();
  std::string_view text() const { return bytes_; }  ///< the whole of it
  std::size_t offset() const { return offset_; }
  LinePlace place() const { return {offset_, number_}; }
  /// Number of the line that next() would give.
  int line_number() const { return number_; }
  /// Moves over whole lines that someone else has read.
  void skip(std::size_t n_characters, int n_lines) {
    offset_ += n_characters;
    number_ += n_lines;
  }

 private:
  std::string_view bytes_;
  std::size_t offset_ = 0;
  int number_ = 1;
};

}  // namespace panelcal
