// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/options/completion.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include "calib/base/append_format.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal {
namespace {

using internal::append_format;

/// How the script of a shell whose `case` is that of POSIX completes the value of an option.
struct ValueWords {
  std::string_view choices;  ///< with the list for {}
  std::string_view file;
  std::string_view nothing;
};

/// Cases for all commands; bash and zsh differ in how they offer words.
struct Cases {
  std::string commands;  ///< of "COMMAND WORD": the word goes on to a command
  std::string values;    ///< of "COMMAND OPTION": what the option takes
  std::string words;     ///< of "COMMAND": what may stand there
};

std::string completion_of(const OptionHelp& option, const ValueWords& values) {
  if (!option.choices.empty()) {
    return fmt::format(fmt::runtime(values.choices), fmt::join(option.choices, " "));
  }
  return std::string(option.is_file ? values.file : values.nothing);
}

Cases cases_of(std::span<const CommandHelp> commands, const ValueWords& values) {
  Cases cases;
  for (const CommandHelp& command : commands) {
    std::vector<std::string> words;
    for (const OptionHelp& option : command.options) {
      words.insert(words.end(), option.names.begin(), option.names.end());
      if (option.value.empty()) continue;
      for (const std::string& name : option.names) {
        append_format(cases.values,
                      "    '{} {}') {}; return ;;\n",
                      command.name,
                      name,
                      completion_of(option, values));
      }
    }
    for (const std::string& below : command.below) {
      words.push_back(below);
      append_format(cases.commands,
                    "      '{} {}') command='{}' ;;\n",
                    command.name,
                    below,
                    command.name.empty() ? below : command.name + ' ' + below);
    }
    append_format(cases.words, "    '{}') words='{}' ;;\n", command.name, fmt::join(words, " "));
  }
  return cases;
}

/// Text between the single quotes of fish.
std::string fish_quoted(std::string_view text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c;
  }
  return out + "'";
}

void append_fish_option(const CommandHelp& command, const OptionHelp& option, std::string& out) {
  if (option.names.empty()) return;
  append_format(out, "complete -c panelcal -n \"__panelcal_at '{}'\"", command.name);
  for (const std::string& name : option.names) {
    const bool is_long = name.starts_with("--");
    append_format(out, " {} {}", is_long ? "-l" : "-s", name.substr(is_long ? 2 : 1));
  }
  if (!option.value.empty()) {
    out += option.is_file ? " -rF" : " -x";
    if (!option.choices.empty()) append_format(out, " -a '{}'", fmt::join(option.choices, " "));
  }
  append_format(out, " -d {}\n", fish_quoted(option.help));
}

}  // namespace

std::string bash_completion(std::span<const CommandHelp> commands) {
  const Cases cases = cases_of(commands,
                               {"COMPREPLY=($(compgen -W '{}' -- \"$word\"))",
                                "COMPREPLY=($(compgen -f -- \"$word\"))",
                                "COMPREPLY=()"});
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

std::string zsh_completion(std::span<const CommandHelp> commands) {
  const Cases cases = cases_of(commands, {"compadd -- {}", "_files", ":"});
  return "#compdef panelcal\n"
         "# Completion of panelcal in zsh: source <(panelcal help completion.zsh), behind "
         "compinit\n"
         "_panelcal() {\n"
         "  local word=${words[CURRENT]} before=${words[CURRENT-1]} command='' i\n"
         "  for ((i = 2; i < CURRENT; ++i)); do\n"
         "    case \"$command ${words[i]}\" in\n" +
         cases.commands +
         "    esac\n"
         "  done\n"
         "  case \"$command $before\" in\n" +
         cases.values +
         "  esac\n"
         "  local words=''\n"
         "  case \"$command\" in\n" +
         cases.words +
         "  esac\n"
         "  compadd -- ${=words}\n"
         "  [[ $word == -* ]] || _files\n"
         "}\n"
         "if [[ $funcstack[1] == _panelcal ]]; then\n"
         "  _panelcal\n"
         "else\n"
         "  compdef _panelcal panelcal\n"
         "fi\n";
}

std::string fish_completion(std::span<const CommandHelp> commands) {
  std::string out =
      "# Completion of panelcal in fish: panelcal help completion.fish | source\n"
      "# True where the command that the words name is this one.\n"
      "function __panelcal_at\n"
      "  set -l command ''\n"
      "  for word in (commandline -opc)[2..-1]\n"
      "    switch (string trim \"$command $word\")\n"
      "      case";
  for (const CommandHelp& command : commands) {
    if (!command.name.empty()) append_format(out, " '{}'", command.name);
  }
  out +=
      "\n"
      "        set command (string trim \"$command $word\")\n"
      "    end\n"
      "  end\n"
      "  test \"$command\" = \"$argv[1]\"\n"
      "end\n";
  for (const CommandHelp& command : commands) {
    for (const OptionHelp& option : command.options) append_fish_option(command, option, out);
    for (const std::string& below : command.below) {
      const std::string name = command.name.empty() ? below : command.name + ' ' + below;
      const auto found = std::ranges::find(commands, name, &CommandHelp::name);
      append_format(out,
                    "complete -c panelcal -n \"__panelcal_at '{}'\" -a {} -d {}\n",
                    command.name,
                    below,
                    fish_quoted(found->summary));
    }
  }
  return out;
}

}  // namespace panelcal
