// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "calib/base/clock.h"
#include "machine/config/machine_config.h"
#include "machine/job/checked_program.h"
#include "machine/job/text_variables.h"
#include "tools/cli/commands.h"
#include "tools/cli/facts_output.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/provenance.h"
#include "tools/plan/output/json.h"
#include "tools/plan/output/text.h"
#include "tools/plan/planning.h"

namespace panelcal {
namespace {

class PlanRun {
 public:
  PlanRun(const PlanOptions& options, CommandContext& context)
      : options_(options), context_(context) {}

  Answer execute_all() {
    Answer answer;
    if (const auto planning = prepare()) {
      answer = state(*planning);
      if (answer.code == ExitCode::Done && !options_.facts.report.empty()) {
        context_.console.say("plan: " + options_.facts.report);
      }
    }
    context_.console.print(log_);
    answer.code = std::max(answer.code, exit_code(log_));
    return answer;
  }

 private:
  template <class T>
  bool take(Expected<T> value, T& out) {
    if (!value) {
      log_.add(std::move(value).error());
      return false;
    }
    out = *std::move(value);
    return true;
  }
  bool take(Expected<void> done) {
    if (!done) log_.add(std::move(done).error());
    return done.has_value();
  }

  std::optional<plan::Planning> prepare() {
    MachineConfig machine;
    if (!take(check_extension("panelcal plan", options_.facts.report, ".html")) ||
        !take(read_machine_config(options_.machine), machine)) {
      return std::nullopt;
    }
    const plan::PlanningTerms terms = {
        .read = [this](const ReadOptions& reading,
                       DiagnosticLog& log) { return read(reading, log); },
        .walk = {.program = options_.program,
                 .clock = options_.clock,
                 .now = system_clock()(),
                 .max_operations = options_.max_operations,
                 .reading = options_.reading,
                 .command = "panelcal plan"},
        .measurements = options_.measurements,
        .fiducial_sigma_um = options_.fiducial_sigma_um,
        .n_added = static_cast<std::size_t>(options_.n_added)};
    return plan::prepare_plan(terms, std::move(machine), log_);
  }

  std::optional<Program> read(const ReadOptions& reading, DiagnosticLog& log) {
    std::optional<Program> program = read_program(options_.program, reading, log);
    if (!program || !take(check_patterns(context_.options, *program, context_.files))) return {};
    return program;
  }

  Answer state(const plan::Planning& planning) {
    const Program& program = planning.checked.program;
    plan::PlanOrigin origin{
        program.source.file,
        planning.machine.name,
        provenance_of(context_.options, program, {options_.machine, options_.measurements})};
    if (drills_the_time(program) || planning.machine.drift_um_per_sqrt_day > 0) {
      origin.provenance.emplace_back("clock", planning.time);
    }
    const plan::Plan made = planning.make();
    const Survey& survey = planning.checked.nominal_survey;
    return state_facts(context_,
                       options_.facts,
                       "Plan: " + origin.program,
                       [&] { return facts::text(plan::plan_facts(made, survey, origin)); },
                       {plan::plan_text(made, survey)});
  }

  const PlanOptions& options_;
  CommandContext& context_;
  DiagnosticLog log_;
};

}  // namespace

Expected<Answer> run_command(const PlanOptions& options, CommandContext& context) {
  return PlanRun(options, context).execute_all();
}

}  // namespace panelcal
