// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tools/cli/options/command_help.h"

namespace panelcal {

/// "panelcal-surface-fit.1": the file of a command's manual page.
std::string manual_page_name(const CommandHelp& command);

/// The manual page of a command in the language of man(7): the same words as `panelcal help`.
///
/// In     version: of the program
/// See    tests/tools/manual_pages_test.py
std::string manual_page(const CommandHelp& command, const std::string& version);

}  // namespace panelcal
