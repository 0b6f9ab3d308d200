// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "program/text/source_text.h"

namespace panelcal::sieb_meyer {

/// Capital letters, digits and what file names may hold besides; no folders.
bool is_subprogram_name(std::string_view name);

/// Place of a subprogram's lines in its file: behind its `@name`, up to the next one or a $.
struct SubprogramText {
  LinePlace begin;
  std::size_t end = 0;
};
std::optional<SubprogramText> find_subprogram(std::string_view bytes, std::string_view name);

/// The offset of the first call of a subprogram: of the `M99` that its name follows.
std::optional<std::size_t> find_call(std::string_view bytes, std::string_view name);

/// The subprogram is the last one of its file, which ends in the middle of a line: the file has no
/// mark at its end, so that only its last line can show that it is cut off.
bool is_cut_off(std::string_view bytes, const SubprogramText& body);

/// Reads the files of all subprograms that a program calls, also by way of others, by their names.
///
/// A subprogram NAME is in the first folder that has it: in NAME.SS5 (or .ss5, or without), or else
/// in the first *.SS5 or *.ss5, in alphabetical order, with a line @NAME. A missing file is left
/// out: that is a problem only where the program calls it.
///
/// Source SIEB & MEYER CNC 8x.00 Command Set, 6 Subprograms
/// See    tests/program/sieb_meyer/sections/subprograms_test.cc
std::map<std::string, SourceText, std::less<>> read_subprograms(
    std::string_view program, const std::vector<std::filesystem::path>& folders);

/// The files that this reads, each once, also those where it looks for a subprogram in vain.
std::vector<std::filesystem::path> files_read_for_subprograms(
    std::string_view program, const std::vector<std::filesystem::path>& folders);

}  // namespace panelcal::sieb_meyer
