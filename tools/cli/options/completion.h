// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "tools/cli/options/command_help.h"

namespace panelcal {

/// Scripts by which a shell completes commands, options, their words and the names of files. Each
/// command and option is in them.
///
/// In     commands: the program itself first
/// See    tests/tools/completion_test.sh
std::string bash_completion(std::span<const CommandHelp> commands);
std::string fish_completion(std::span<const CommandHelp> commands);
std::string zsh_completion(std::span<const CommandHelp> commands);

}  // namespace panelcal
