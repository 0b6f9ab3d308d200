// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/planning.h"

#include <algorithm>
#include <span>
#include <utility>

#include "machine/config/machine_config.h"
#include "machine/sources/measurement_file_source.h"
#include "tools/plan/design/design.h"
#include "tools/plan/output/facts.h"
#include <fmt/format.h>

namespace panelcal::plan {
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

/// Fills a Planning, stage by stage. Every stage leaves its problems in the log.
class PlanPreparation {
 public:
  PlanPreparation(const PlanningTerms& terms, MachineConfig machine, DiagnosticLog& log)
      : terms_(terms), log_(log) {
    planning_.machine = std::move(machine);
  }

  std::optional<Planning> planning() {
    if (prepare() && check() && read_noise()) return std::move(planning_);
    return std::nullopt;
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
    log_.add({Code::Usage, {terms_.command, 0, 0}, std::move(what), std::move(expected)});
    return false;
  }

  bool prepare() {
    MachineConfig& machine = planning_.machine;
    PlanRequest& request = planning_.request;
    // Targets that are where they are drawn speak for no model.
    request.chooses_model = std::exchange(machine.walk.chooses_model, false);
    request.bends_panel = std::exchange(machine.walk.bends_panel, false);
    if (request.bends_panel) machine.walk.model = PanelModel::Affine;
    request.fixed_model = machine.walk.model;
    // A slot's ends say all about it.
    machine.walk.slots = machine.walk.step_slots = Cycles::Kept;
    return take(check_spindle_is_calibrated(machine)) &&
           take(set_walk_terms(terms_.walk, machine), planning_.time);
  }

  /// Walks over the perfect panel. Where only the design of a series is at fault, once more with
  /// a model that any target determines, so that there are holes to speak of.
  bool check() {
    MachineConfig& machine = planning_.machine;
    CheckedProgram& checked = planning_.checked;
    std::optional<Program> program = terms_.read(machine.reading, log_);
    if (!program) return false;
    checked.program = *std::move(program);
    DiagnosticLog found;
    checked.nominal_survey = survey_nominal(checked.program, machine.walk, found);
    const bool is_design = !log_.has_errors() && found.has_errors() &&
                           std::ranges::all_of(found.kept(), is_about_the_design);
    if (is_design) {
      found = {};
      machine.walk.model = PanelModel::Offset;
      checked.nominal_survey = survey_nominal(checked.program, machine.walk, found);
    }
    for (const Diagnostic& diagnostic : found.kept()) log_.add(diagnostic);
    if (log_.has_errors()) return false;
    const ModelRule rule{
        checked.program.dialect, planning_.request.fixed_model, machine.walk.sieb_meyer.fits_scale};
    for (const SeriesResult& series : checked.nominal_survey.series) {
      planning_.programmed.push_back(
          is_design ? rule(series.level, design_of(checked.nominal_survey, series)) : series.model);
    }
    return true;
  }

  /// The noise of targets: as the option says, or as a recorded job had it.
  bool read_noise() {
    PlanRequest& request = planning_.request;
    request.n_added = terms_.n_added;
    request.fiducial_sigma = um(terms_.fiducial_sigma_um.value_or(2));
    request.is_assumed = !terms_.fiducial_sigma_um && terms_.measurements.empty();
    request.sigma_source = fmt::format("{} {:.2f} um",
                                       terms_.fiducial_sigma_um ? "--fiducial-sigma-um" : "assumed",
                                       request.fiducial_sigma.in_um());
    return terms_.measurements.empty() || read_recorded_noise();
  }

  bool read_recorded_noise() {
    PlanRequest& request = planning_.request;
    RecordedMeasurements recorded;
    if (!take(read_measurements(terms_.measurements), recorded)) return false;
    MeasurementFileSource source(std::move(recorded));
    std::vector<Eigen::Matrix2d> noises_mm2;
    double sum_mm2 = 0;
    std::size_t n_found = 0;
    for (const Measurement& nominal : planning_.checked.nominal_survey.measurements) {
      Measurement seen;
      if (!take(source.measure(nominal.request), seen)) return false;
      const bool is_found = seen.status == MeasurementStatus::Found;
      noises_mm2.emplace_back(is_found ? noise_mm2(seen) : Eigen::Matrix2d::Zero());
      sum_mm2 += noises_mm2.back().trace() / 2;
      n_found += is_found ? 1 : 0;
    }
    if (!take(source.check_all_used())) return false;
    if (n_found == 0) return refuse("no target was found in " + quoted(terms_.measurements), "");
    // A target that was not found then is taken to be as good as the others.
    const double typical_mm2 = sum_mm2 / static_cast<double>(n_found);
    for (Eigen::Matrix2d& noise : noises_mm2) {
      if (noise.isZero(0)) noise = typical_mm2 * Eigen::Matrix2d::Identity();
    }
    request.sigma_source = "recorded in " + terms_.measurements;
    if (const std::size_t n_lost = noises_mm2.size() - n_found; n_lost > 0) {
      request.sigma_source += fmt::format(
          ", {} of {} targets not found and taken like the others", n_lost, noises_mm2.size());
    }
    request.recorded_mm2 = std::move(noises_mm2);
    return true;
  }

  const PlanningTerms& terms_;
  DiagnosticLog& log_;
  Planning planning_;
};

}  // namespace

Plan Planning::make() const {
  return make_plan(checked.program, machine.walk, checked.nominal_survey, programmed, request);
}

std::optional<Planning> prepare_plan(const PlanningTerms& terms,
                                     MachineConfig machine,
                                     DiagnosticLog& log) {
  return PlanPreparation(terms, std::move(machine), log).planning();
}

}  // namespace panelcal::plan
