// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace panelcal {

/// An option or a positional of a command, as completion and manual pages need it.
struct OptionHelp {
  std::vector<std::string> names;  ///< with their dashes, the long ones first; empty: a positional
  std::string value;               ///< "TEXT", "PROGRAM"; empty: a flag
  std::vector<std::string> choices;  ///< all values that it takes; empty: any
  std::string help;
  bool is_required = false;
  bool is_file = false;  ///< its value is a file or a folder
};

/// A command with what may stand behind it.
struct CommandHelp {
  std::string name;  ///< "surface fit"; empty: the program itself
  std::string summary;
  std::string page;  ///< example, explanation and exit codes
  std::vector<OptionHelp> options;
  std::vector<std::string> below;  ///< commands below it: "fit"
};

/// Every command of the command line, each before those below it.
std::vector<CommandHelp> command_help(const CLI::App& app);

}  // namespace panelcal
