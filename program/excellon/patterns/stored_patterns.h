// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "program/text/source_text.h"

namespace panelcal::excellon {

/// The manual's characters for file names, and the dot and underscore of today's systems: nothing
/// that could lead out of a folder.
/// Source CNC-7 manual, Rules for Naming Your Programs
bool is_pattern_name(std::string_view name);

/// Reads the files of all stored patterns that `program` names behind M99, as far as they are
/// found: `NAME` or `name`, with or without .exc, .drl or .pat, in the first folder that has one.
std::map<std::string, SourceText, std::less<>> read_patterns(
    std::string_view program, const std::vector<std::filesystem::path>& folders);

}  // namespace panelcal::excellon
