// SPDX-License-Identifier: Apache-2.0
// Like command_line.cc it includes CLI11: seconds to compile.
#include "tools/cli/options/command_options.h"
#include "tools/cli/options/program_options.h"
#include <CLI/CLI.hpp>

namespace panelcal {
namespace {

/// Of each of them.
void begin_history(CLI::App& command, HistoryOptions& o) {
  command.add_option("-l,--ledger", o.ledger, "The ledger's file")->required();
  command.add_option("-o,--output", o.output, "Write to this file, whole or not at all");
}

void add_key(CLI::App& command, HistoryOptions& o, bool required) {
  command.add_option("--machine", o.machine, "The machine's name")->required(required);
  command.add_option("--kind", o.kind, "spindle-camera, camera, table, ...")->required(required);
  command.add_option("--subject", o.subject, "Which of that kind, such as \"zoom 3\"")
      ->required(required);
}

void add_since(CLI::App& command, HistoryOptions& o) {
  command.add_option("--since", o.since, "Not older: 2026-11-21, or with T08:37:38Z (UTC)");
}

/// Of those that have something to look at.
void add_page(CLI::App& command, HistoryOptions& o) {
  add_json(command, o.facts);
  add_report(command, o.facts, "A page of the facts (.html)");
}

/// Of those that list entries.
void add_list(CLI::App& command, HistoryOptions& o) {
  add_key(command, o, false);
  add_since(command, o);
  command.add_option("--last", o.last, "Only the newest N")->check(CLI::Range(1, 1'000'000'000));
}

}  // namespace

void add_history_list_options(CLI::App& command, HistoryOptions& o) {
  begin_history(command, o);
  add_list(command, o);
  add_page(command, o);
}

void add_history_export_options(CLI::App& command, HistoryOptions& o) {
  begin_history(command, o);
  add_list(command, o);
}

void add_history_show_options(CLI::App& command, HistoryOptions& o) {
  begin_history(command, o);
  command.add_option("ID", o.ids, "Its number")->required()->expected(1);
  command.add_flag("--result", o.result, "The calibration itself, byte for byte");
  add_page(command, o);
}

void add_history_diff_options(CLI::App& command, HistoryOptions& o) {
  begin_history(command, o);
  command.add_option("ID", o.ids, "Two numbers: before and after")->required()->expected(2);
  CLI::Option* program =
      command.add_option("--program", o.program, "Show how far every hole of this job would move");
  CLI::Option* machine = command.add_option("-m,--machine", o.machine_file, "machine.toml");
  program->needs(machine);
  machine->needs(program);
  command
      .add_option("--measurements",
                  o.measurements,
                  "Of cameras: a recorded job, for where in the picture targets were seen")
      ->needs(program);
  add_clock(command, o.clock);
  add_limit(command, o.max_operations);
  add_reading(command, o.reading, program);
  add_page(command, o);
}

void add_history_rollback_options(CLI::App& command, HistoryOptions& o) {
  begin_history(command, o);
  add_key(command, o, true);
  command.add_option("--to", o.to, "Entry to go back to (default: the one before)");
  command.add_option("--reason", o.reason, "Why, for those who read it later")->required();
  command.add_option("--by", o.asked_by, "Who asks (default: the user)");
  add_json(command, o.facts);
}

void add_history_fresh_start_options(CLI::App& command, HistoryOptions& o) {
  begin_history(command, o);
  add_key(command, o, true);
  command.add_option("--reason", o.reason, "Reason: the part that was changed or examined")
      ->required();
  command.add_option("--by", o.asked_by, "Name of the person (default: the user)");
  add_json(command, o.facts);
}

void add_history_plot_options(CLI::App& command, HistoryOptions& o) {
  begin_history(command, o);
  add_key(command, o, true);
  command.add_option("--parameter", o.parameter, "Its name, as `show` lists it")->required();
  add_page(command, o);
}

void add_history_verify_options(CLI::App& command, HistoryOptions& o) {
  begin_history(command, o);
  command.add_option(
      "-m,--machine", o.machine_file, "machine.toml: its calibrations and its reports");
  command.add_option("--against", o.against, "Files, or folders of .json and .html files");
  add_json(command, o.facts);
}

void add_history_push_options(CLI::App& command, HistoryOptions& o) {
  command.add_option("-l,--ledger", o.ledger, "The ledger's file")->required();
  command.add_option("--reports", o.reports, "Folder of the machine's nights ([nightly] reports)");
  add_store(command, o.store)->required();
}

void add_history_fleet_options(CLI::App& command, HistoryOptions& o) {
  add_store(command, o.store)->required();
  command.add_option(
      "--clock", o.clock, "Date and time in UTC, such as 2026-11-21T02:00:00Z (default: now)");
  command
      .add_option("--max-age-h", o.max_age_h, "A night that ended earlier says nothing any more")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  add_page(command, o);
}

void add_history_certificate_options(CLI::App& command, HistoryOptions& o) {
  begin_history(command, o);
  command.add_option("-m,--machine", o.machine_file, "machine.toml")->required();
  command.add_option(
      "--plate", o.plate, "The plate that the table was calibrated on (default: [nightly.table])");
  command.add_option("--against", o.against, "Files, or folders of .json and .html files");
  add_since(command, o);
  add_page(command, o);
}

}  // namespace panelcal
