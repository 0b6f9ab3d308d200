// SPDX-License-Identifier: Apache-2.0
// Like the files of tools/cli/options it includes CLI11: seconds to compile.
#include "tools/cli/command_line.h"

#include <algorithm>
#include <iostream>

#include "tools/cli/command_table.h"
#include "tools/cli/help/help_text.h"
#include "tools/cli/help/help_topics.h"
#include "tools/cli/options/completion.h"
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
    help_ =
        app_.add_subcommand("help",
                            "Explain a command, or list diagnostics, a language's commands or the "
                            "keys of machine.toml");
    help_->add_option("TOPIC",
                      help_topic_,
                      "A command (`run`, `calibrate camera`), `diagnostics`, `excellon`, "
                      "`sieb-meyer`, `machine.toml`, `machine.schema.json` or `completion.bash`");
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
    if (help_topic_ == std::vector<std::string>{"completion.bash"}) {
      std::cout << bash_completion(app_);
      return std::move(options_);
    }
    if (help_topic_.size() == 1) {
      if (const auto page = panelcal::help_topic(help_topic_.front())) {
        std::cout << *page;
        return std::move(options_);
      }
    }
    const CLI::App* topic = &app_;
    for (const std::string& word : help_topic_) {
      const auto subs = commands_of(*topic);
      const auto found = std::ranges::find(subs, word, &CLI::App::get_name);
      if (found == subs.end()) return failure(unknown_command(*topic, word));
      topic = *found;
    }
    std::cout << topic->help(topic == &app_ ? "" : full_name(*topic->get_parent()));
    return std::move(options_);
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

  static Diagnostic unknown_command(const CLI::App& of, const std::string& word) {
    const auto subs = commands_of(of);
    std::vector<std::string> names(subs.size());
    std::ranges::transform(
        subs, names.begin(), [](const CLI::App* sub) { return sub->get_name(); });
    const std::string_view near =
        nearest_word(word, std::vector<std::string_view>(names.begin(), names.end()));
    return {Code::Usage,
            {full_name(of), 0, 0},
            "unknown command " + quoted(word),
            near.empty() ? fmt::format("one of {}", fmt::join(names, ", "))
                         : "did you mean " + quoted(near) + "?"};
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
