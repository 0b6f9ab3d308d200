// SPDX-License-Identifier: Apache-2.0
// Like command_line.cc it includes CLI11: seconds to compile.
#include "tools/cli/options/completion.h"

#include <string_view>
#include <vector>

#include "calib/base/append_format.h"
#include "tools/cli/options/file_options.h"
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal {
namespace {

/// Cases of bash for one command and those below it.
struct Cases {
  std::string commands;  ///< of "COMMAND WORD": the word goes on to a command
  std::string values;    ///< of "COMMAND OPTION": what the option takes
  std::string words;     ///< of "COMMAND": what may stand there
};

/// "--to" and "-o", with their dashes.
std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  return names;
}

/// "jsonl csv", of an option that takes one of them.
std::string choices_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto open = type.find('{');
  const auto close = type.find('}', open);
  if (close == std::string::npos) return {};
  std::string words = type.substr(open + 1, close - open - 1);
  std::ranges::replace(words, ',', ' ');
  return words;
}

/// What completes the value of an option: one of its words, a file, or nothing.
std::string completion_of(const CLI::Option& option) {
  if (const std::string words = choices_of(option); !words.empty()) {
    return fmt::format("COMPREPLY=($(compgen -W '{}' -- \"$word\"))", words);
  }
  return names_file(option) ? "COMPREPLY=($(compgen -f -- \"$word\"))" : "COMPREPLY=()";
}

void add_cases(const CLI::App& app, const std::string& command, Cases& cases) {
  std::vector<std::string> words;
  const auto add_options = [&](const CLI::App& of) {
    for (const CLI::Option* const option : of.get_options()) {
      const std::vector<std::string> names = names_of(*option);
      words.insert(words.end(), names.begin(), names.end());
      if (option->get_items_expected_max() == 0) continue;
      for (const std::string& name : names) {
        internal::append_format(
            cases.values, "    '{} {}') {}; return ;;\n", command, name, completion_of(*option));
      }
    }
  };
  add_options(app);
  for (const CLI::App* const below : app.get_subcommands([](const CLI::App*) { return true; })) {
    const std::string& name = below->get_name();
    if (name.empty()) {  // a group of options
      add_options(*below);
      continue;
    }
    words.push_back(name);
    const std::string longer = command.empty() ? name : command + " " + name;
    internal::append_format(
        cases.commands, "      '{} {}') command='{}' ;;\n", command, name, longer);
    add_cases(*below, longer, cases);
  }
  internal::append_format(cases.words, "    '{}') words='{}' ;;\n", command, fmt::join(words, " "));
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
  Cases cases;
  add_cases(app, "", cases);
  return "# Completion of panelcal in bash: eval \"$(panelcal help completion.bash)\"\n"
         "_panelcal() {\n"
         "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}\n"
         "  local command='' words='' i\n"
         "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
         "    case \"$command ${COMP_WORDS[i]}\" in\n" +
         cases.commands +
         "    esac\n"
         "  done\n"
         "  case \"$command $before\" in\n" +
         cases.values +
         "  esac\n"
         "  case \"$command\" in\n" +
         cases.words +
         "  esac\n"
         "  COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
         "  [[ $word == -* ]] || COMPREPLY+=($(compgen -f -- \"$word\"))\n"
         "}\n"
         "complete -o filenames -F _panelcal panelcal\n";
}

}  // namespace panelcal
