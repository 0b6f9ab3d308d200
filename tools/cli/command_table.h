// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include "tools/cli/commands.h"

namespace CLI {
class App;
}

namespace panelcal {

/// A command: all that the program knows of it. The command line, help and completion go by these
/// rows, in their order.
struct CommandRow {
  std::string_view name;  ///< "check"; of a command below another one "surface fit"
  std::string_view summary;
  std::string_view page;  ///< example, explanation and exit codes, below the options
  /// Registers its options, and what they fill. Null: the command has only commands below it.
  void (*add_options)(CLI::App& command, CommandOptions& options) = nullptr;
  Expected<Answer> (*run)(CommandContext& context) = nullptr;
};

/// A command that has commands below it stands before them.
std::span<const CommandRow> command_table();

}  // namespace panelcal
