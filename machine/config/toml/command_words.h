// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "machine/config/settings/stage_commands.h"

namespace panelcal::internal {

/// True if a word holds a zero byte, which no argument of a program may have.
bool has_zero_byte(const CommandWords& words);

/// Puts the folder ahead of a program with a relative path; a bare name is looked for in PATH.
///
/// In     words: not empty; folder: that of the file that states them
void look_for_program(CommandWords& words, const std::filesystem::path& folder);

}  // namespace panelcal::internal
