// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "calib/base/expected.h"

namespace panelcal {

namespace internal {
class JsonLine;
}

/// The stored pattern or subprogram in which a program asks for something.
struct PatternFile {
  std::string_view path;    ///< as it was found; empty: the program itself
  std::string_view sha256;  ///< of its bytes; empty: not known
};

/// True if two requests come from the same pattern. Its content decides, whatever the folder that
/// it was found from; where one of the two does not know it, the file's name without folders.
///
/// See    tests/program/model/pattern_file_test.cc
bool is_same_pattern(const PatternFile& a, const PatternFile& b);

/// `"boards/PINS", sha256 0123456789ab`, for diagnostics; `"PINS"` where the content is not known;
/// `(the program itself)`.
std::string pattern_text(const PatternFile& file);

/// Appends the keys `file`, without folders, and `file_sha256` of a JSON object that has other keys
/// already; nothing for the program itself. So a recording is the same wherever it was made.
void append_pattern(std::string& out, const PatternFile& file);

/// Reads those keys, each of which may be absent.
///
/// Fails  what the line reports of a wrong value, with the code; a digest without its file
Expected<void> read_pattern(const internal::JsonLine& line,
                            Code code,
                            std::string& file,
                            std::string& file_sha256);

}  // namespace panelcal
