// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <string>
#include <utility>

#include "calib/base/clock.h"
#include "calib/base/json/facts.h"
#include "machine/check/machine_check.h"
#include "machine/check/vision_rules.h"
#include "machine/config/machine_config.h"
#include "machine/job/checked_program.h"
#include "machine/job/facts/sections.h"
#include "machine/job/output/output_format.h"
#include "machine/job/walk_terms.h"
#include "program/judge/job_check.h"
#include "program/judge/tally.h"
#include "tools/check/drill_attributes.h"
#include "tools/cli/commands.h"
#include "tools/cli/facts_output.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

std::string count(std::size_t n, std::string_view word) {
  return fmt::format("{} {}{}", n == 0 ? "no" : std::to_string(n), word, n == 1 ? "" : "s");
}

/// What passes by on the way over a perfect panel.
struct Passing {
  explicit Passing(std::optional<Travel> travel) : job_check(travel) {}

  Tally tally;
  JobCheck job_check;
};

struct CheckedJob {
  const Program& program;
  const Survey& survey;
  const Passing& passing;
};

/// Checks the program and passes its job on the perfect panel, in one walk where that is enough.
Survey check_job(const Program& program,
                 const WalkOptions& walk,
                 Passing& passing,
                 DiagnosticLog& log) {
  Passing first = passing;
  Tee first_tee({&first.tally, &first.job_check});
  CheckedWalk checked = check(program, walk, Execution::OfNominal, &first_tee, log);
  if (log.has_errors()) return std::move(checked.survey);
  if (checked.is_executed) {
    passing = std::move(first);
    for (const Diagnostic& diagnostic : checked.working_log.kept()) log.add(diagnostic);
  } else {
    Tee tee({&passing.tally, &passing.job_check});
    execute(program, walk, checked.survey, tee, log);
  }
  passing.job_check.report(program, log);
  return std::move(checked.survey);
}

std::string summary(const Program& program,
                    const Survey& survey,
                    const Tally& tally,
                    const DiagnosticLog& log) {
  std::string job = count(tally.tools_used().size(), "tool") + ", " +
                    count(static_cast<std::size_t>(tally.n_holes()), "hole");
  if (tally.n_slots() > 0) {
    job += ", " + count(static_cast<std::size_t>(tally.n_slots()), "slot");
  }
  if (tally.n_routs() > 0) {
    job += fmt::format(", {} over {:.1f} mm",
                       count(static_cast<std::size_t>(tally.n_routs()), "rout move"),
                       tally.routed_length().in_mm());
  }
  job += fmt::format(
      ", {} in {} series", count(survey.measurements.size(), "target"), survey.series.size());
  if (!survey.probes.empty()) job += ", " + count(survey.probes.size(), "probe");
  const std::string stated = read_drill_attributes(program.source.bytes).text();
  return fmt::format("{}: {}\n{}{}{}, no errors, {}\n",
                     escaped_controls(program.source.file),
                     program.head->reading(),
                     escaped_controls(stated),
                     stated.empty() ? "" : "\n",
                     job,
                     count(log.n_warnings(), "warning"));
}

/// Null where the program's comments state none.
facts::Json attributes_json(const DrillAttributes& attributes) {
  using facts::Json;
  if (attributes.is_empty()) return {};
  Json tools = Json::array();
  for (const auto& [tool, function] : attributes.functions) {
    tools.push_back({{"number", tool}, {"function", function}});
  }
  return {
      {"file_function", attributes.file_function.empty() ? Json() : Json(attributes.file_function)},
      {"tools", tools}};
}

/// What a check has found, as one JSON document: share/schema/check.schema.json.
facts::Json check_facts(const CheckOptions& options,
                        const CheckedJob* checked,
                        const MachineConfig& machine,
                        const DiagnosticLog& log) {
  using facts::Json;
  Json document = facts::envelope("check", 1);
  document["program"] = options.program.empty() ? Json() : Json(options.program);
  document["machine"] = options.machine.empty() ? Json() : Json(options.machine);
  document["has_errors"] = log.has_errors();
  document["messages"] = facts::messages_json(log.kept());
  Json job;
  if (checked != nullptr) {
    const Tally& tally = checked->passing.tally;
    job = {{"language", name(checked->program.dialect)},
           {"reading", checked->program.head->reading()},
           {"attributes", attributes_json(read_drill_attributes(checked->program.source.bytes))},
           {"tools", facts::tools_json(tally)},
           {"n_holes", tally.n_holes()},
           {"n_slots", tally.n_slots()},
           {"n_routs", tally.n_routs()},
           {"routed_length_mm", facts::number(tally.routed_length().in_mm())},
           {"n_targets", checked->survey.measurements.size()},
           {"n_series", checked->survey.series.size()},
           {"n_probes", checked->survey.probes.size()}};
  }
  document["job"] = job;
  document["gates"] = options.machine.empty()
                          ? Json()
                          : Json{{"panel", gates_text(machine.walk.base_limits)},
                                 {"nested", gates_text(machine.walk.nested_limits)}};
  document["gcode_flavour"] = machine.gcode ? Json(name(gcode_flavour(machine))) : Json();
  return document;
}

/// The time of --clock, which set_walk_terms() has found to be one; `now` without.
std::chrono::sys_seconds stated_or(const std::string& clock, std::chrono::sys_seconds now) {
  return clock.empty() ? now : *from_iso_8601(clock + "Z");
}

/// Reads the machine's file, where one is named, and holds it against itself.
Expected<void> read_machine(const CheckOptions& options,
                            MachineConfig& config,
                            DiagnosticLog& of_machine) {
  if (!options.machine.empty()) {
    PANELCAL_TRY(config, read_machine_config(options.machine));
  }
  const std::chrono::sys_seconds now = system_clock()();
  const WalkTerms terms = {.program = options.program,
                           .clock = options.clock,
                           .now = now,
                           .max_operations = options.max_operations,
                           .reading = options.reading,
                           .command = "panelcal check"};
  PANELCAL_CHECK(set_walk_terms(terms, config));
  const StatedKeys keys = StatedKeys::of_file(options.machine);
  if (options.machine.empty()) return {};
  check_machine(config, keys, stated_or(options.clock, now), of_machine);
  if (options.program.empty()) check_stated_series(config, keys, of_machine);
  return {};
}

/// Of a machine: what every job's fits are held against, and whose G-code it reads.
std::string machine_lines(const MachineConfig& machine) {
  const std::string gates = fmt::format("gates of panel fits: {}\ngates of nested fits: {}\n",
                                        gates_text(machine.walk.base_limits),
                                        gates_text(machine.walk.nested_limits));
  if (!machine.gcode) return gates;
  return fmt::format("{}G-code: flavour {}\n", gates, name(gcode_flavour(machine)));
}

}  // namespace

Expected<Answer> run_command(const CheckOptions& options, CommandContext& context) {
  if (options.program.empty() && options.machine.empty()) {
    return failure({Code::Usage,
                    {"panelcal check", 0, 0},
                    "nothing to check",
                    "PROGRAM, -m machine.toml, or both"});
  }
  DiagnosticLog log;
  DiagnosticLog of_machine;  // apart: a program is checked whatever is wrong with the machine
  MachineConfig config;
  PANELCAL_CHECK(read_machine(options, config, of_machine));
  WalkOptions& walk = config.walk;
  walk.slots = walk.step_slots = Cycles::Kept;
  std::optional<Program> program;
  Passing passing(config.travel);
  Survey survey;
  if (!options.program.empty()) {
    program = read_program(options.program, config.reading, log);
    if (program) survey = check_job(*program, walk, passing, log);
    if (program && !options.machine.empty()) check_targets(config, *program, survey, log);
  }
  for (const Diagnostic& diagnostic : of_machine.kept()) log.add(diagnostic);
  context.console.print(log);
  std::optional<CheckedJob> checked;
  if (program && !log.has_errors()) checked.emplace(CheckedJob{*program, survey, passing});
  Answer answer = {{}, exit_code(log)};
  if (!log.has_errors()) {
    answer.text =
        checked ? summary(*program, survey, passing.tally, log) : options.machine + ": no errors\n";
    if (!options.machine.empty()) answer.text += machine_lines(config);
  }
  const auto document = [&] {
    return facts::text(check_facts(options, checked ? &*checked : nullptr, config, log));
  };
  answer = state_facts(context, options.facts, {}, document, std::move(answer));
  if (log.has_errors() && !options.program.empty()) {
    context.console.say(fmt::format("{}: {}, {}",
                                    options.program,
                                    count(log.n_errors(), "error"),
                                    count(log.n_warnings(), "warning")));
  }
  return answer;
}

}  // namespace panelcal
