// SPDX-License-Identifier: Apache-2.0
// Like the files of tools/cli/options it includes CLI11: seconds to compile.
#include "tools/cli/command_line.h"

#include <algorithm>
#include <iostream>
#include <optional>

#include "calib/base/append_format.h"
#include "tools/cli/command_table.h"
#include "tools/cli/help/help_text.h"
#include "tools/cli/help/help_topics.h"
#include "tools/cli/options/command_help.h"
#include "tools/cli/options/completion.h"
#include "tools/cli/options/manual_page.h"
#include "tools/cli/options/parse_problem.h"
#include "tools/cli/process/version.h"
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal {
namespace {

class CommandLine {
 public:
  CommandLine() {
    app_.require_subcommand(1);
    app_.set_version_flag("--version", std::string("panelcal ") + kVersion);
    app_.footer(std::string(kMainFooter));
    app_.fallthrough();
    app_.add_flag("-q,--quiet", options_.common.quiet, "Errors only on standard error");
    app_.add_option("--log-level", options_.common.log_level, "Level of messages on standard error")
        ->check(CLI::IsMember({"error", "warning", "info"}))
        ->capture_default_str();
    for (std::size_t i = 0; i < fillable_.size(); ++i) add(command_table()[i], fillable_[i]);
    help_ = app_.add_subcommand("help",
                                "Explain a command or a topic; `panelcal help topics` lists them");
    help_->add_option("TOPIC",
                      help_topic_,
                      "A command (`run`, `calibrate camera`), or a topic such as `machine.toml`");
  }

  Expected<Options> parse(int argc, char** argv) {
    options_.command_line.assign(argv, argv + argc);
    try {
      app_.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return refuse(error);
    }
    if (*help_) return help();
    options_.command_name = full_name(command());
    options_.files = file_options(app_);
    const auto rows = command_table();
    const auto row = std::ranges::find(rows, table_name(options_.command_name), &CommandRow::name);
    options_.command = std::move(fillable_[static_cast<std::size_t>(row - rows.begin())]);
    options_.run = row->run;
    return std::move(options_);
  }

 private:
  void add(const CommandRow& row, CommandOptions& options) {
    const auto space = row.name.find(' ');
    CLI::App* const parent = space == std::string_view::npos
                                 ? &app_
                                 : app_.get_subcommand(std::string(row.name.substr(0, space)));
    CLI::App* const command =
        parent->add_subcommand(std::string(row.name.substr(space + 1)), std::string(row.summary));
    command->footer(std::string(row.page));
    if (row.add_options == nullptr) {
      command->require_subcommand(1);
    } else {
      row.add_options(*command, options);
    }
  }

  /// The last command that the words name, such as `fit` of `panelcal surface fit`.
  const CLI::App& command() const {
    const CLI::App* at = &app_;
    while (!at->get_subcommands().empty()) at = at->get_subcommands().front();
    return *at;
  }

  /// "panelcal surface fit".
  static std::string full_name(const CLI::App& command) {
    const CLI::App* const parent = command.get_parent();
    return parent == nullptr ? command.get_name() : full_name(*parent) + " " + command.get_name();
  }

  /// "surface fit", of "panelcal surface fit".
  static std::string_view table_name(std::string_view full_name) {
    return full_name.substr(full_name.find(' ') + 1);
  }

  Expected<Options> help() {
    if (help_topic_.size() == 1) {
      if (const auto page = topic_page(help_topic_.front())) {
        std::cout << *page;
        return std::move(options_);
      }
    }
    const CLI::App* topic = &app_;
    for (const std::string& word : help_topic_) {
      const auto subs = commands_of(*topic);
      const auto found = std::ranges::find(subs, word, &CLI::App::get_name);
      if (found == subs.end()) return failure(unknown_topic(*topic, word));
      topic = *found;
    }
    std::cout << topic->help(topic == &app_ ? "" : full_name(*topic->get_parent()));
    return std::move(options_);
  }

  /// What is made of the command line itself, or of the tables that help_topics.h has.
  std::optional<std::string> topic_page(const std::string& topic) const {
    if (topic == "topics") return topics_page();
    const std::vector<CommandHelp> commands = command_help(app_);
    if (topic == "completion.bash") return bash_completion(commands);
    if (topic == "completion.fish") return fish_completion(commands);
    if (topic == "completion.zsh") return zsh_completion(commands);
    const auto page = std::ranges::find(commands, topic, manual_page_name);
    if (page != commands.end()) return manual_page(*page, kVersion);
    return panelcal::help_topic(topic);
  }

  std::string topics_page() const {
    std::string out = "Commands (`panelcal help COMMAND`)\n";
    for (const CommandHelp& command : command_help(app_)) {
      if (command.name.empty() || command.name == "help") continue;
      internal::append_format(out, "  {:<26} {}\n", command.name, command.summary);
    }
    out += "\nTopics (`panelcal help TOPIC`)\n";
    for (const HelpTopic& topic : help_topics()) {
      internal::append_format(out, "  {:<26} {}\n", topic.name, topic.summary);
    }
    return out;
  }

  Expected<Options> refuse(const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // help or version
      app_.exit(error);
      return std::move(options_);
    }
    const std::vector<std::string> extras = app_.remaining(true);
    if (command().get_require_subcommand_min() > 0) {
      const auto word = std::ranges::find_if(
          extras, [](const std::string& extra) { return !extra.starts_with('-'); });
      if (word != extras.end()) return failure(unknown_command(command(), *word));
      if (extras.empty()) return failure(missing_command(command()));
    }
    const auto option = std::ranges::find_if(
        extras, [](const std::string& extra) { return extra.starts_with("--"); });
    if (option != extras.end()) {
      if (auto unknown = misspelt_option(*option)) return failure(std::move(*unknown));
    }
    // The name of this error is that of the command.
    const bool has_extras = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
    return failure(parse_problem(error.get_name(),
                                 error.what(),
                                 has_extras ? extras : std::vector<std::string>(),
                                 full_name(command())));
  }

  static std::vector<const CLI::App*> commands_of(const CLI::App& app) {
    return app.get_subcommands([](const CLI::App*) { return true; });
  }

  static std::vector<std::string> names_of_commands(const CLI::App& of) {
    const auto subs = commands_of(of);
    std::vector<std::string> names(subs.size());
    std::ranges::transform(
        subs, names.begin(), [](const CLI::App* sub) { return sub->get_name(); });
    return names;
  }

  static std::string nearest_of(const std::string& word, const std::vector<std::string>& names) {
    return std::string(
        nearest_word(word, std::vector<std::string_view>(names.begin(), names.end())));
  }

  static Diagnostic unknown(std::string of,
                            std::string what,
                            const std::string& near,
                            std::string expected) {
    return {Code::Usage,
            {std::move(of), 0, 0},
            std::move(what),
            near.empty() ? std::move(expected) : "did you mean " + quoted(near) + "?"};
  }

  static Diagnostic unknown_command(const CLI::App& of, const std::string& word) {
    const auto names = names_of_commands(of);
    return unknown(full_name(of),
                   "unknown command " + quoted(word),
                   nearest_of(word, names),
                   fmt::format("one of {}", fmt::join(names, ", ")));
  }

  static Diagnostic unknown_topic(const CLI::App& of, const std::string& word) {
    auto names = names_of_commands(of);
    if (of.get_parent() == nullptr) {
      for (const HelpTopic& topic : help_topics()) names.emplace_back(topic.name);
    }
    return unknown(full_name(of),
                   "unknown topic " + quoted(word),
                   nearest_of(word, names),
                   "a topic that `panelcal help topics` lists");
  }

  static Diagnostic missing_command(const CLI::App& of) {
    return {Code::Usage,
            {full_name(of), 0, 0},
            "missing command",
            fmt::format("one of {}; `panelcal help topics` explains them",
                        fmt::join(names_of_commands(of), ", "))};
  }

  /// Of a word that is near an option of the command.
  std::optional<Diagnostic> misspelt_option(const std::string& word) const {
    const std::string name = full_name(command());
    std::vector<std::string> names;
    for (const CommandHelp& of : command_help(app_)) {
      if (!of.name.empty() && of.name != table_name(name)) continue;
      for (const OptionHelp& option : of.options) {
        names.insert(names.end(), option.names.begin(), option.names.end());
      }
    }
    const std::string near = nearest_of(word.substr(0, word.find('=')), names);
    if (near.empty() || near == word) return std::nullopt;
    return unknown(name, "unknown option " + quoted(word), near, "");
  }

  CLI::App app_{std::string(kMainHeader), "panelcal"};
  Options options_;
  /// Of every row, as it may be the one that is meant; CLI11 keeps references to them.
  std::vector<CommandOptions> fillable_{command_table().size()};
  std::vector<std::string> help_topic_;
  CLI::App* help_ = nullptr;
};

}  // namespace

Expected<Options> parse_options(int argc, char** argv) {
  return CommandLine().parse(argc, argv);
}

}  // namespace panelcal
