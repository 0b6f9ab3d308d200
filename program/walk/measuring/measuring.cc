// SPDX-License-Identifier: Apache-2.0
#include "program/walk/measuring/measuring.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "calib/base/statistics/chi_square.h"
#include "calib/correction/error_budget.h"
#include "calib/panel/panel_fit.h"
#include "program/walk/measuring/series_examination.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

bool may_be_chosen(const Measurement& measurement) {
  return std::ranges::any_of(measurement.candidates, &MeasuredCandidate::counts);
}

/// A target as the fit of a level has it.
template <class To, class From>
TargetPair<To, From> pair_of(const FitPoint& point, const Position<From>& nominal) {
  return {nominal,
          {position_mm<To>(point.measured.position.in_mm()), point.measured.cov},
          point.axes,
          point.by_camera,
          point.i_camera,
          point.n_arrivals};
}

PanelFitOptions fit_options(const WalkOptions& options, const SeriesResult& series) {
  return {.model = series.prescribed,
          .chooses_model = options.chooses_model,
          .compares_models = options.compares_models,
          .limits = series.limits};
}

/// One wrong target bends a panel as well. Where the affine fit finds who it is, or what else the
/// matter is, the panel is not taken for bent.
bool is_explained_without(const SeriesResult& series,
                          std::span<const FitPoint> points,
                          const Survey& survey,
                          const CorrectionStack& stack,
                          const WalkOptions& options) {
  SeriesResult straight = series;
  straight.model = PanelModel::Affine;
  straight.base = nullptr;  // refused: say why
  const auto fault = examine_series(straight, points, survey, stack, options);
  return fault && fault->i_outlier.has_value();
}

}  // namespace

bool is_same_place(const Placement& a, const Placement& b) {
  constexpr double kRounding_mm = 1e-6;
  return a.linear() == b.linear() && (a.translation() - b.translation()).norm() < kRounding_mm;
}

void CorrectionState::clear_base() {
  stack.clear_base();
  base_series.reset();
  nested_series.reset();
  base_reliability.reset();
  nested_reliability.reset();
  unknown.reset();
}

void CorrectionState::clear_nested() {
  stack.clear_nested();
  if (unknown == CorrectionLevel::Nested) unknown.reset();
  nested_series.reset();
  nested_reliability.reset();
}

Measuring::Measuring(const WalkOptions& options,
                     Survey& survey,
                     MeasurementSource* source,
                     const Reporter& reporter,
                     DiagnosticLog& log)
    : options_(options),
      survey_(survey),
      source_(source),
      reporter_(reporter),
      log_(log),
      corrections_(options.uncertainty) {
  if (options.aligned != nullptr) begin_aligned();
}

void Measuring::begin_aligned() {
  if (is_first_pass()) survey_ = *options_.aligned;
  n_measured_ = options_.aligned->measurements.size();
  n_fitted_ = options_.aligned->series.size();
  activate(0, 0);
}

std::optional<std::size_t> Measuring::measure(MeasurementRequest request, bool is_of_series) {
  const std::size_t index = n_measured_++;
  ++n_steps_;
  if (source_ == nullptr) return index;
  request.seq = static_cast<std::int64_t>(index);
  request.is_of_left_out_board = corrections_.is_withheld;

  Expected<Measurement> measurement = source_->measure(request);
  // Files keep three numbers of a covariance; with the same three here a replay is exact.
  if (measurement) measurement->measured.cov(1, 0) = measurement->measured.cov(0, 1);
  if (!measurement) {
    log_.add(std::move(measurement).error());
    must_stop_ = survey_.was_stopped = true;
    return std::nullopt;
  }
  const bool is_lost = measurement->status != MeasurementStatus::Found;
  const bool is_told_later =
      is_of_series && (may_be_chosen(*measurement) || panelcal::is_left_out(*measurement));
  if (is_lost && !is_told_later && !corrections_.is_withheld) report_lost(*measurement);
  survey_.measurements.push_back(*std::move(measurement));
  return index;
}

std::optional<SeriesAssignment> Measuring::settle(std::span<const std::size_t> measurements,
                                                  CorrectionLevel level,
                                                  int line) {
  if (!is_first_pass()) return std::nullopt;
  std::vector<Measurement> targets;
  for (const std::size_t i : measurements) targets.push_back(measurement(i));
  auto assignment = assign_series(targets, limits_of(level));
  if (assignment) panelcal::settle(*assignment, targets);
  const bool is_open = assignment && !assignment->is_certain();
  if (is_open) reporter_.report(Code::SeriesAmbiguous, line, assignment->text());
  for (std::size_t k = 0; k < targets.size(); ++k) {
    const bool is_lost = targets[k].status != MeasurementStatus::Found;
    if (is_lost && !is_open && may_be_chosen(targets[k])) report_lost(targets[k]);
    survey_.measurements[measurements[k]] = std::move(targets[k]);
  }
  return assignment;
}

void Measuring::report_not_calibrated(int line, int column, std::string_view text) {
  if (!is_first_pass()) return;
  survey_.unperformed.emplace(reporter_.file(), line);
  reporter_.report(Code::CalibrationNotPerformed, line, column, quoted(text));
}

void Measuring::calibrate(CalibrationOrder order, int column, std::string_view text) {
  if (!is_first_pass() || must_stop_) return;
  ++n_steps_;
  if (n_calibrations_ == options_.max_measurements) {
    reporter_.report(Code::TooManyOperations,
                     order.line,
                     column,
                     fmt::format("more than {} calibrations", options_.max_measurements),
                     "a shorter program");
    must_stop_ = survey_.was_stopped = true;
    return;
  }
  order.number = n_calibrations_++;
  Expected<std::optional<CalibrationAnswer>> answer = source_->calibrate(order);
  if (!answer) {
    log_.add(std::move(answer).error());
    must_stop_ = survey_.was_stopped = true;
    return;
  }
  if (!*answer) return report_not_calibrated(order.line, column, text);
  CalibrationAnswer& calibration = **answer;
  calibration.order = std::move(order);
  calibration.i_measurement = n_measured_;
  // As with measurements: a file keeps three numbers of the covariance.
  if (calibration.offset) calibration.offset->cov_mm2(1, 0) = calibration.offset->cov_mm2(0, 1);
  const std::size_t i = survey_.calibrations.size();
  if (calibration.offset) {
    calibration.i_in_force = i;
  } else if (i > 0) {
    calibration.i_in_force = survey_.calibrations.back().i_in_force;
  }
  survey_.calibrations.push_back(std::move(calibration));
}

void Measuring::focus(const MeasurementRequest& request) {
  ++n_steps_;
  Expected<std::optional<FocusResult>> result = source_->focus(request);
  if (!result) {
    log_.add(std::move(result).error());
    must_stop_ = survey_.was_stopped = true;
    return;
  }
  if (!*result) return;  // recorded measurements have no camera
  FocusResult& found = **result;
  if (!found.is_found) {
    reporter_.report(Code::FocusNotFound,
                     request.line,
                     fmt::format("{} at ({:.4f}, {:.4f}) mm: {}",
                                 request.command,
                                 request.expected.in_mm().x(),
                                 request.expected.in_mm().y(),
                                 found.reason));
  }
  survey_.focus.push_back(std::move(found));
}

FitPoint Measuring::fit_point(std::size_t i_measurement) const {
  const Measurement& m = measurement(i_measurement);
  const MachineUncertainty& machine = options_.uncertainty;
  FitPoint point{
      .nominal = m.request.nominal, .measured = m.measured, .i_measurement = i_measurement};
  point.measured.cov += machine.of_target_mm2();
  if (m.by_camera) point.by_camera = *m.by_camera;
  point.i_camera = machine.camera_index(m.request.settings.zoom);
  return point;
}

TargetHolePlace Measuring::hole_at_target(std::size_t i_measurement) const {
  const Measurement& m = measurement(i_measurement);
  MachineUncertainty machine = options_.uncertainty;
  machine.set_offset(offset_uncertainty(survey_.calibration_of(i_measurement), machine));
  const ErrorBudget budget = error_budget_at_target(machine,
                                                    m.measured.cov,
                                                    m.by_camera.value_or(CameraJacobian::Zero()),
                                                    machine.camera_index(m.request.settings.zoom));
  return {{m.measured.position, total_mm2(budget)}, i_measurement};
}

/// The mean of several arrivals averages the stage's errors and the detector's, and neither the
/// table's, which is as wrong at one layer as at the next, nor the camera's.
FitPoint mean_of_layers(std::span<const FitPoint> layers, const MachineUncertainty& machine) {
  const auto n = static_cast<double>(layers.size());
  Eigen::Vector2d nominal_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d measured_mm = Eigen::Vector2d::Zero();
  FitPoint mean{.nominal = {}, .measured = {}, .i_measurement = layers.back().i_measurement};
  mean.i_camera = layers.back().i_camera;
  mean.n_arrivals = 0;
  for (const FitPoint& layer : layers) {
    nominal_mm += layer.nominal.in_mm();
    measured_mm += layer.measured.position.in_mm();
    mean.measured.cov += layer.measured.cov - machine.table_mm2();
    mean.by_camera += layer.by_camera / n;
    mean.n_arrivals += layer.n_arrivals;
  }
  mean.nominal = position_mm<frame::Nominal>(nominal_mm / n);
  mean.measured.position = position_mm<frame::Actual>(measured_mm / n);
  mean.measured.cov = mean.measured.cov / (n * n) + machine.table_mm2();
  return mean;
}

/// A hole at its own target has no fit to hold against limits, but it may not be farther from its
/// expected place than a panel may be.
void Measuring::gate_hole(const Measurement& measurement, CorrectionLevel level) {
  const GateLimits& limits = limits_of(level);
  const MeasurementRequest& request = measurement.request;
  const Eigen::Vector2d meant_mm = turned_by(request.expected.in_mm(), limits.turned_deg);
  const Length offset = mm((measurement.measured.position.in_mm() - meant_mm).norm());
  if (!limits.offset || offset <= *limits.offset) return;
  reporter_.report(Code::GateFailed,
                   request.line,
                   fmt::format("{} target at nominal ({:.4f}, {:.4f}) mm is {:.3f} mm from its "
                               "expected place, limit {:.3f} mm",
                               request.command,
                               request.nominal.in_mm().x(),
                               request.nominal.in_mm().y(),
                               offset.in_mm(),
                               limits.offset->in_mm()));
}

std::size_t Measuring::fit(SeriesResult series, std::span<const FitPoint> points) {
  const std::size_t i_series = n_fitted_++;
  ++n_steps_;
  if (!is_first_pass()) return i_series;
  prepare(series);
  for (const FitPoint& point : points) series.points.push_back(point.i_measurement);
  if (!points.empty()) {
    fit_points(points, series);
    examine({points.begin(), points.end()}, series);
    note_reliability(series);
  }
  if (series.is_left_out) report_left_out(series);
  for (const std::size_t i : series.measurements) {
    if (!series.is_left_out && panelcal::is_left_out(measurement(i))) {
      report_skipped(measurement(i), series);
    }
  }
  survey_.series.push_back(std::move(series));
  if (options_.fitted) options_.fitted(survey_);
  return i_series;
}

void Measuring::prepare(SeriesResult& series) const {
  series.prescribed = series.model;
  series.limits = limits_of(series.level);
  if (series.level == CorrectionLevel::Nested) series.base_series = corrections_.base_series;
}

namespace {

/// The target that a series is refused for, or the likeliest of several; nothing where it is
/// accepted, or where it lies wrong as a whole.
std::optional<std::size_t> refused_target(const SeriesResult& series) {
  if (!series.is_fitted() || series.is_accepted()) return std::nullopt;
  if (series.fault && series.fault->i_outlier) return series.points[*series.fault->i_outlier];
  for (const GateVerdict& gate : series.gates) {
    if (!gate.accepted && gate.i_target) return series.points[*gate.i_target];
  }
  if (!series.fault) return std::nullopt;
  for (const SeriesFault::Suspicion& suspicion : series.fault->suspicions) {
    if (suspicion.i_point) return series.points[*suspicion.i_point];
  }
  return std::nullopt;
}

std::string refusal_text(const SeriesResult& series) {
  if (series.fault) return series.fault->text();
  return std::ranges::find(series.gates, false, &GateVerdict::accepted)->text();
}

}  // namespace

bool Measuring::reconsider(SeriesResult series, std::span<const FitPoint> points) {
  if (source_ == nullptr || must_stop_ || points.empty() || !source_->reconsiders()) return false;
  DiagnosticLog unheard;
  const Reporter muted(reporter_.file(), unheard);
  Measuring trial(options_, survey_, source_, muted, unheard);
  trial.corrections_ = corrections_;
  trial.prepare(series);
  trial.fit_points(points, series);
  trial.examine({points.begin(), points.end()}, series);
  const auto i_worst = refused_target(series);
  if (!i_worst) return false;
  Measurement& worst = survey_.measurements[*i_worst];
  Expected<std::optional<Measurement>> anew = source_->reconsider({worst, refusal_text(series)});
  if (!anew) {
    log_.add(std::move(anew).error());
    must_stop_ = survey_.was_stopped = true;
    return false;
  }
  if (!*anew) return false;
  worst = **std::move(anew);
  if (is_lost(*i_worst)) report_lost(worst);
  worst.measured.cov(1, 0) = worst.measured.cov(0, 1);
  return true;
}

void Measuring::note_reliability(SeriesResult& series) {
  if (!series.is_fitted()) return;
  Reliability out = series.base ? reliability(*series.base, series.limits)
                                : reliability(*series.nested, series.limits);
  const double chance = series.limits.false_alarm.value_or(kMisfitChance);
  const bool fits = out.degrees_of_freedom < 1 ||
                    chi_square_exceedance(series.chi_square, out.degrees_of_freedom) >= chance;
  out.is_rejected = !fits || !series.is_accepted();
  series.reliability = std::make_shared<const Reliability>(std::move(out));
}

void Measuring::fit_points(std::span<const FitPoint> points, SeriesResult& series) {
  series.base.reset();
  series.nested.reset();
  series.gates.clear();
  series.points.clear();
  for (const FitPoint& point : points) series.points.push_back(point.i_measurement);
  if (series.level == CorrectionLevel::Base) return fit_base(points, series);
  fit_nested(points, series);
}

void Measuring::examine(std::vector<FitPoint> points, SeriesResult& series) {
  series.fault = examine_series(series, points, survey_, corrections_.stack, options_);
  const auto may_go_on = [&](const SeriesResult& s) {
    // A spline follows an outlier as far as nothing else is near: it is not told apart by its
    // residual.
    return s.is_fitted() && !s.is_smooth() && s.fault && s.fault->i_outlier &&
           s.dropped.size() < static_cast<std::size_t>(std::max(0, s.limits.max_dropped));
  };
  std::vector<FitPoint> left = points;
  std::vector<std::string> reasons;  // one for each target left out
  SeriesResult trial = series;
  while (may_go_on(trial)) {
    const std::size_t i_outlier = *trial.fault->i_outlier;
    auto fewer = without_point(left, i_outlier, trial.model);
    if (!fewer) break;
    trial.dropped.push_back(left[i_outlier].i_measurement);
    reasons.push_back(trial.fault->text());
    left = *std::move(fewer);
    fit_points(left, trial);
    trial.fault = examine_series(trial, left, survey_, corrections_.stack, options_);
  }
  if (!trial.dropped.empty() && trial.is_fitted() && !trial.fault && all_accepted(trial.gates)) {
    trial.fault = std::move(series.fault);
    trial.fault->is_resolved = true;
    series = std::move(trial);
    return report_dropped(series, reasons);
  }
  report_gates(series, points);
  report_fault(series, points);
}

void Measuring::fit_base(std::span<const FitPoint> points, SeriesResult& series) {
  std::vector<TargetPair<frame::Base, frame::Nominal>> pairs;
  // Without a nested correction the base frame is the actual one.
  for (const FitPoint& point : points) {
    pairs.push_back(pair_of<frame::Base>(point, point.nominal));
  }
  PanelFitOptions options = fit_options(options_, series);
  // If the model is given, the smooth one is only compared.
  if (options.chooses_model) options.smooth = SmoothModels::Eligible;
  // One target alone is an offset whatever the machine's file says.
  options.bends = options_.bends_panel && points.size() > 1;
  series.base = fit_panel(options, std::span(std::as_const(pairs)), series);
  const bool is_bent = series.is_smooth() || series.failure == FitFailure::Folded;
  if (is_bent && !options.bends &&
      is_explained_without(series, points, survey_, corrections_.stack, options_)) {
    options.smooth = SmoothModels::Compared;
    series.base = fit_panel(options, std::span(std::as_const(pairs)), series);
  }
  if (series.failure) report_fit_failure(series, options.bends);
}

void Measuring::fit_nested(std::span<const FitPoint> points, SeriesResult& series) {
  if (corrections_.stack.is_bent()) return report_nested_on_smooth(series);
  std::vector<TargetPair<frame::Actual, frame::Base>> pairs;
  for (const FitPoint& point : points) {
    pairs.push_back(
        pair_of<frame::Actual>(point, corrections_.stack.base_from_nominal()(point.nominal)));
  }
  const PanelFitOptions options = fit_options(options_, series);
  series.nested = fit_panel(options, std::span(std::as_const(pairs)), series);
  if (series.failure) report_fit_failure(series, false);
}

OffsetUncertainty Measuring::offset_of(const SeriesResult& series) const {
  return offset_uncertainty(survey_.calibration_of(series), options_.uncertainty);
}

void Measuring::activate(std::size_t i_series, int line) {
  ++n_steps_;
  const SeriesResult& series = survey_.series[i_series];
  if (series.is_left_out) {
    const bool is_base = series.level == CorrectionLevel::Base;
    if (is_base) corrections_.clear_base();
    corrections_.clear_nested();
    corrections_.is_withheld = true;
    if (!corrections_.unknown) corrections_.unknown = series.level;
    return;
  }
  if (series.level == CorrectionLevel::Base) {
    if (!series.base) {
      must_stop_ = true;
      return;
    }
    corrections_.unknown.reset();
    corrections_.is_withheld = false;
    corrections_.stack.set_base(series.base, offset_of(series));
    corrections_.base_series = i_series;
    corrections_.base_reliability = series.reliability;
    corrections_.nested_series.reset();
    corrections_.nested_reliability.reset();
    return;
  }
  corrections_.nested_series.reset();
  corrections_.nested_reliability.reset();
  if (!series.nested) return corrections_.stack.clear_nested();
  if (series.base_series != corrections_.base_series) {
    reporter_.report(
        Code::NestedBaseChanged,
        line,
        fmt::format("the nested correction measured in line {} was relative to another "
                    "base correction than the one in force",
                    series.line),
        "the base correction it was measured under");
    must_stop_ = true;
    return;
  }
  if (corrections_.unknown == CorrectionLevel::Nested) corrections_.unknown.reset();
  corrections_.is_withheld = false;
  corrections_.stack.set_nested(series.nested, offset_of(series));
  corrections_.nested_series = i_series;
  corrections_.nested_reliability = series.reliability;
}

}  // namespace panelcal
