// SPDX-License-Identifier: Apache-2.0
// Like command_line.cc it includes CLI11: seconds to compile.
#include "tools/cli/options/command_help.h"

#include "tools/cli/options/file_options.h"
#include <CLI/CLI.hpp>

namespace panelcal {
namespace {

/// "jsonl", "csv", of the type "TEXT:{jsonl,csv}".
std::vector<std::string> choices_of(const std::string& type) {
  std::vector<std::string> choices;
  const auto open = type.find('{');
  const auto close = type.find('}', open);
  if (close == std::string::npos) return choices;
  for (auto begin = open + 1; begin <= close;) {
    const auto end = std::min(type.find(',', begin), close);
    choices.push_back(type.substr(begin, end - begin));
    begin = end + 1;
  }
  return choices;
}

OptionHelp words_of(const CLI::Option& option) {
  OptionHelp words;
  for (const std::string& name : option.get_lnames()) words.names.push_back("--" + name);
  for (const std::string& name : option.get_snames()) words.names.push_back("-" + name);
  const std::string type = option.get_type_name();
  words.choices = choices_of(type);
  if (words.names.empty()) {
    words.value = option.get_name(true);
  } else if (option.get_items_expected_max() > 0) {
    // "UINT in [0 - 256]" of "UINT:UINT in [0 - 256]"
    words.value =
        words.choices.empty() ? type.substr(type.rfind(':') + 1) : type.substr(0, type.find(':'));
  }
  words.help = option.get_description();
  words.is_required = option.get_required();
  words.is_file = names_file(option);
  return words;
}

void append_options(const CLI::App& of, CommandHelp& words) {
  for (const CLI::Option* const option : of.get_options()) {
    words.options.push_back(words_of(*option));
  }
}

void add_command(const CLI::App& app, const std::string& name, std::vector<CommandHelp>& out) {
  CommandHelp words{name, app.get_description(), app.get_footer(), {}, {}};
  append_options(app, words);
  std::vector<const CLI::App*> commands;
  for (const CLI::App* const below : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (below->get_name().empty()) {  // a group of options
      append_options(*below, words);
    } else {
      commands.push_back(below);
      words.below.push_back(below->get_name());
    }
  }
  out.push_back(std::move(words));
  for (const CLI::App* const below : commands) {
    add_command(*below, name.empty() ? below->get_name() : name + ' ' + below->get_name(), out);
  }
}

}  // namespace

std::vector<CommandHelp> command_help(const CLI::App& app) {
  std::vector<CommandHelp> out;
  add_command(app, "", out);
  return out;
}

}  // namespace panelcal
