// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "machine/config/machine_config.h"
#include "machine/job/checked_program.h"
#include "machine/job/text_variables.h"
#include "machine/job/walk_terms.h"
#include "machine/sources/measurement_file_source.h"
#include "tools/cli/commands.h"
#include "tools/cli/facts_output.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/provenance.h"
#include "tools/plan/design/design.h"
#include "tools/plan/output/json.h"
#include "tools/plan/output/text.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Targets that do not determine their model are what a plan is there to mend.
bool is_about_the_design(const Diagnostic& diagnostic) {
  return diagnostic.severity() != Severity::Error || diagnostic.code == Code::SeriesDegenerate ||
         diagnostic.code == Code::TargetsTooFew;
}

/// Noise of a target as it was recorded, mm^2. Of a slot the axis that it shows stands for both.
Eigen::Matrix2d noise_mm2(const Measurement& measurement) {
  const Eigen::Matrix2d& cov_mm2 = measurement.measured.cov;
  switch (measurement.request.axes) {
    case ObservedAxes::X:
      return cov_mm2(0, 0) * Eigen::Matrix2d::Identity();
    case ObservedAxes::Y:
      return cov_mm2(1, 1) * Eigen::Matrix2d::Identity();
    case ObservedAxes::Both:
      break;
  }
  return cov_mm2;
}

class PlanRun {
 public:
  PlanRun(const PlanOptions& options, CommandContext& context)
      : options_(options), context_(context) {}

  Answer execute_all() {
    Answer answer;
    if (prepare() && check() && read_noise()) {
      answer = state(plan::make_plan(
          checked_->program, config_.walk, checked_->nominal_survey, programmed_, request_));
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
  bool refuse(std::string what, std::string expected) {
    log_.add({Code::Usage, {"panelcal plan", 0, 0}, std::move(what), std::move(expected)});
    return false;
  }

  bool prepare() {
    if (!take(check_extension("panelcal plan", options_.facts.report, ".html"))) return false;
    if (!take(read_machine_config(options_.machine), config_)) return false;
    // Targets that are where they are drawn speak for no model.
    request_.chooses_model = std::exchange(config_.walk.chooses_model, false);
    request_.bends_panel = std::exchange(config_.walk.bends_panel, false);
    if (request_.bends_panel) config_.walk.model = PanelModel::Affine;
    request_.fixed_model = config_.walk.model;
    // A slot's ends say all about it.
    config_.walk.slots = config_.walk.step_slots = Cycles::Kept;
    const WalkTerms terms = {.program = options_.program,
                             .clock = options_.clock,
                             .now = system_clock()(),
                             .max_operations = options_.max_operations,
                             .reading = options_.reading,
                             .command = "panelcal plan"};
    return take(check_spindle_is_calibrated(config_)) &&
           take(set_walk_terms(terms, config_), time_);
  }

  /// Walks over the perfect panel. Where only the design of a series is at fault, once more with
  /// a model that any target determines, so that there are holes to speak of.
  bool check() {
    std::optional<Program> program = read_program(options_.program, config_.reading, log_);
    if (!program || !take(check_patterns(context_.options, *program, context_.files))) return false;
    checked_ = CheckedProgram{*std::move(program), {}};
    DiagnosticLog found;
    checked_->nominal_survey = survey_nominal(checked_->program, config_.walk, found);
    const bool is_design = !log_.has_errors() && found.has_errors() &&
                           std::ranges::all_of(found.kept(), is_about_the_design);
    if (is_design) {
      found = {};
      config_.walk.model = PanelModel::Offset;
      checked_->nominal_survey = survey_nominal(checked_->program, config_.walk, found);
    }
    for (const Diagnostic& diagnostic : found.kept()) log_.add(diagnostic);
    if (log_.has_errors()) return false;
    const plan::ModelRule rule{
        checked_->program.dialect, request_.fixed_model, config_.walk.sieb_meyer.fits_scale};
    for (const SeriesResult& series : checked_->nominal_survey.series) {
      programmed_.push_back(
          is_design ? rule(series.level, plan::design_of(checked_->nominal_survey, series))
                    : series.model);
    }
    return true;
  }

  /// The noise of targets: as the option says, or as a recorded job had it.
  bool read_noise() {
    request_.n_added = static_cast<std::size_t>(options_.n_added);
    request_.fiducial_sigma = um(options_.fiducial_sigma_um.value_or(2));
    request_.is_assumed = !options_.fiducial_sigma_um && options_.measurements.empty();
    request_.sigma_source =
        fmt::format("{} {:.2f} um",
                    options_.fiducial_sigma_um ? "--fiducial-sigma-um" : "assumed",
                    request_.fiducial_sigma.in_um());
    return options_.measurements.empty() || read_recorded_noise();
  }

  bool read_recorded_noise() {
    RecordedMeasurements recorded;
    if (!take(read_measurements(options_.measurements), recorded)) return false;
    MeasurementFileSource source(std::move(recorded));
    std::vector<Eigen::Matrix2d> noises_mm2;
    double sum_mm2 = 0;
    std::size_t n_found = 0;
    for (const Measurement& nominal : checked_->nominal_survey.measurements) {
      Measurement seen;
      if (!take(source.measure(nominal.request), seen)) return false;
      const bool is_found = seen.status == MeasurementStatus::Found;
      noises_mm2.emplace_back(is_found ? noise_mm2(seen) : Eigen::Matrix2d::Zero());
      sum_mm2 += noises_mm2.back().trace() / 2;
      n_found += is_found ? 1 : 0;
    }
    if (!take(source.check_all_used())) return false;
    if (n_found == 0) return refuse("no target was found in " + quoted(options_.measurements), "");
    // A target that was not found then is taken to be as good as the others.
    const double typical_mm2 = sum_mm2 / static_cast<double>(n_found);
    for (Eigen::Matrix2d& noise : noises_mm2) {
      if (noise.isZero(0)) noise = typical_mm2 * Eigen::Matrix2d::Identity();
    }
    request_.sigma_source = "recorded in " + options_.measurements;
    if (const std::size_t n_lost = noises_mm2.size() - n_found; n_lost > 0) {
      request_.sigma_source += fmt::format(
          ", {} of {} targets not found and taken like the others", n_lost, noises_mm2.size());
    }
    request_.recorded_mm2 = std::move(noises_mm2);
    return true;
  }

  Answer state(const plan::Plan& made) {
    plan::PlanOrigin origin{
        checked_->program.source.file,
        config_.name,
        provenance_of(
            context_.options, checked_->program, {options_.machine, options_.measurements})};
    if (drills_the_time(checked_->program) || config_.drift_um_per_sqrt_day > 0) {
      origin.provenance.emplace_back("clock", time_);
    }
    const Survey& survey = checked_->nominal_survey;
    return state_facts(context_,
                       options_.facts,
                       "Plan: " + origin.program,
                       [&] { return facts::text(plan::plan_facts(made, survey, origin)); },
                       {plan::plan_text(made, survey)});
  }

  const PlanOptions& options_;
  CommandContext& context_;
  DiagnosticLog log_;
  MachineConfig config_;
  std::optional<CheckedProgram> checked_;
  std::vector<PanelModel> programmed_;
  plan::PlanRequest request_;
  std::string time_;
};

}  // namespace

Expected<Answer> run_command(const PlanOptions& options, CommandContext& context) {
  return PlanRun(options, context).execute_all();
}

}  // namespace panelcal
