// SPDX-License-Identifier: Apache-2.0
// Like options.cc it includes CLI11: seconds to compile.
#include "tools/cli/options/history_command_line.h"

#include "tools/cli/help/history_help.h"
#include "tools/cli/options/program_options.h"
#include <CLI/CLI.hpp>

namespace panelcal {
namespace {

class HistoryCommandLine {
 public:
  HistoryCommandLine(CLI::App& history, HistoryOptions& options)
      : history_(history), options_(options) {}

  void add() {
    using Action = HistoryOptions::Action;
    HistoryOptions& o = options_;
    history_.require_subcommand(1);
    CLI::App* list = add_action("list", "Entries, one a line; * is in force", Action::List);
    CLI::App* dump = add_action("export", "Everything as JSON Lines", Action::Export);
    for (CLI::App* command : {list, dump}) {
      add_key(command, false);
      command->add_option("--since", o.since, "Not older: 2026-11-21, or with T08:37:38Z (UTC)");
      command->add_option("--last", o.last, "Only the newest N")
          ->check(CLI::Range(1, 1'000'000'000));
    }
    CLI::App* show = add_action("show", "One entry", Action::Show);
    show->add_option("ID", o.ids, "Its number")->required()->expected(1);
    show->add_flag("--result", o.result, "The calibration itself, byte for byte");
    CLI::App* diff = add_action("diff", "What changed from one entry to another", Action::Diff);
    add_diff_of_job(diff);
    CLI::App* back = add_action("rollback", "Put an earlier one in force", Action::RollBack);
    add_key(back, true);
    back->add_option("--to", o.to, "Entry to go back to (default: the one before)");
    back->add_option("--reason", o.reason, "Why, for those who read it later")->required();
    back->add_option("--by", o.asked_by, "Who asks (default: the user)");
    CLI::App* fresh = add_action("fresh-start",
                                 "Record that later nights are not compared with earlier ones",
                                 Action::FreshStart);
    add_key(fresh, true);
    fresh->add_option("--reason", o.reason, "Reason: the part that was changed or examined")
        ->required();
    fresh->add_option("--by", o.asked_by, "Name of the person (default: the user)");
    CLI::App* plot = add_action("plot", "One parameter over time, a line an entry", Action::Plot);
    add_key(plot, true);
    plot->add_option("--parameter", o.parameter, "Its name, as `show` lists it")->required();
    CLI::App* verify = add_action("verify",
                                  "Check every hash of the ledger, and that it has what "
                                  "calibrations and reports note of it",
                                  Action::Verify);
    verify->add_option(
        "-m,--machine", o.machine_file, "machine.toml: its calibrations and its reports");
    verify->add_option("--against", o.against, "Files, or folders of .json and .html files");
    for (CLI::App* command : {list, show, diff, back, fresh, plot, verify}) {
      command->add_option("--json", o.json, "The facts as JSON; - is standard output");
    }
    for (CLI::App* command : {list, show, diff, plot}) {
      command->add_option("--report", o.report, "A page of the facts (.html)");
    }
  }

 private:
  /// One of history's own commands.
  CLI::App* add_action(const char* name, const char* summary, HistoryOptions::Action action) {
    HistoryOptions& o = options_;
    CLI::App* command = history_.add_subcommand(name, summary);
    command->footer(std::string(history_footer("history " + std::string(name))));
    command->add_option("-l,--ledger", o.ledger, "The ledger's file")->required();
    command->add_option("-o,--output", o.output, "Write to this file, whole or not at all");
    command->callback([&o, action] { o.action = action; });
    return command;
  }

  void add_key(CLI::App* command, bool required) {
    HistoryOptions& o = options_;
    command->add_option("--machine", o.machine, "The machine's name")->required(required);
    command->add_option("--kind", o.kind, "spindle-camera, camera, table, ...")->required(required);
    command->add_option("--subject", o.subject, "Which of that kind, such as \"zoom 3\"")
        ->required(required);
  }

  void add_diff_of_job(CLI::App* diff) {
    HistoryOptions& o = options_;
    diff->add_option("ID", o.ids, "Two numbers: before and after")->required()->expected(2);
    CLI::Option* program =
        diff->add_option("--program", o.program, "Show how far every hole of this job would move");
    CLI::Option* machine = diff->add_option("-m,--machine", o.machine_file, "machine.toml");
    program->needs(machine);
    machine->needs(program);
    diff->add_option("--measurements",
                     o.measurements,
                     "Of cameras: a recorded job, for where in the picture targets were seen")
        ->needs(program);
    add_clock(diff, o.clock);
    add_limit(diff, o.max_operations);
    add_reading(diff, o.reading, program);
  }

  CLI::App& history_;
  HistoryOptions& options_;
};

}  // namespace

void add_history_commands(CLI::App& history, HistoryOptions& options) {
  HistoryCommandLine(history, options).add();
}

}  // namespace panelcal
