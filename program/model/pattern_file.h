// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace panelcal {

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

/// The name of a file, as recordings have it: the same wherever they were made.
std::string_view without_folders(std::string_view path);

}  // namespace panelcal
