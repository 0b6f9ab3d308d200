// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/measuring.h"

#include <memory>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

bool is_mirrored(const Eigen::Matrix2d& linear) {
  return linear(0, 0) * linear(1, 1) - linear(0, 1) * linear(1, 0) <= 0;
}

Code lost_code(MeasurementStatus status) {
  switch (status) {
    case MeasurementStatus::Ambiguous:
      return Code::TargetAmbiguous;
    case MeasurementStatus::Rejected:
      return Code::TargetRejected;
    default:
      return Code::TargetNotFound;
  }
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
}

void CorrectionState::clear_nested() {
  stack.clear_nested();
  nested_series.reset();
}

Measuring::Measuring(const WalkOptions& options,
                     Survey& survey,
                     MeasurementSource* source,
                     const Reporter& reporter,
                     DiagnosticLog& log)
    : options_(options), survey_(survey), source_(source), reporter_(reporter), log_(log) {
}

std::optional<std::size_t> Measuring::measure(MeasurementRequest request) {
  const std::size_t index = n_measured_++;
  if (source_ == nullptr) return index;
  request.seq = static_cast<std::int64_t>(index);

  Expected<Measurement> measurement = source_->measure(request);
  // Files keep three numbers of a covariance; with the same three here a replay is exact.
  if (measurement) measurement->measured.cov(1, 0) = measurement->measured.cov(0, 1);
  if (!measurement) {
    log_.add(std::move(measurement).error());
    must_stop_ = true;
    return std::nullopt;
  }
  if (measurement->status != MeasurementStatus::Found) report_lost(*measurement);
  survey_.measurements.push_back(*std::move(measurement));
  return index;
}

void Measuring::focus(const MeasurementRequest& request) {
  Expected<std::optional<FocusResult>> result = source_->focus(request);
  if (!result) {
    log_.add(std::move(result).error());
    must_stop_ = true;
    return;
  }
  if (!*result) return;  // recorded measurements have no camera
  FocusResult& found = **result;
  if (!found.is_found) {
    reporter_.report(Code::FocusNotFound,
                     request.line,
                     1,
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
  return {.nominal = m.request.nominal, .measured = m.measured, .i_measurement = i_measurement};
}

void Measuring::report_lost(const Measurement& measurement) {
  const MeasurementRequest& request = measurement.request;
  reporter_.report(lost_code(measurement.status),
                   request.line,
                   1,
                   fmt::format("{} target {} at nominal ({:.4f}, {:.4f}) mm is {}{}{}",
                               request.command,
                               request.seq,
                               request.nominal.in_mm().x(),
                               request.nominal.in_mm().y(),
                               name(measurement.status),
                               measurement.reason.empty() ? "" : ": ",
                               measurement.reason));
}

/// A hole at its own target has no fit to hold against limits, but it may not be farther from its
/// expected place than a panel may be.
void Measuring::gate_hole(const Measurement& measurement, CorrectionLevel level) {
  const GateLimits& limits =
      level == CorrectionLevel::Base ? options_.base_limits : options_.nested_limits;
  const MeasurementRequest& request = measurement.request;
  const Length offset = mm((measurement.measured.position - request.expected).in_mm().norm());
  if (!limits.offset || offset <= *limits.offset) return;
  reporter_.report(Code::GateFailed,
                   request.line,
                   1,
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
  if (!is_first_pass()) return i_series;
  if (series.level == CorrectionLevel::Nested) series.base_series = corrections_.base_series;
  for (const FitPoint& point : points) series.points.push_back(point.i_measurement);
  if (!points.empty()) {
    if (series.level == CorrectionLevel::Base) {
      fit_base(points, series);
    } else {
      fit_nested(points, series);
    }
    report_gates(series, points);
  }
  survey_.series.push_back(std::move(series));
  return i_series;
}

void Measuring::fit_base(std::span<const FitPoint> points, SeriesResult& series) {
  std::vector<TargetPair<frame::Base, frame::Nominal>> pairs;
  for (const FitPoint& point : points) {
    // Without a nested correction the base frame is the actual one.
    pairs.push_back(
        {point.nominal,
         {position_mm<frame::Base>(point.measured.position.in_mm()), point.measured.cov},
         point.axes});
  }
  auto result = fit_panel<frame::Base, frame::Nominal>(pairs, series.model);
  if (!result.fit) return report_fit_failure(series, result.failure);
  if (is_mirrored(result.fit->map.map.linear())) return report_mirrored(series);
  series.gates = check_gates(*result.fit, options_.base_limits);
  series.base = std::make_shared<const BaseFit>(*std::move(result.fit));
}

void Measuring::fit_nested(std::span<const FitPoint> points, SeriesResult& series) {
  std::vector<TargetPair<frame::Actual, frame::Base>> pairs;
  for (const FitPoint& point : points) {
    pairs.push_back(
        {corrections_.stack.base_from_nominal()(point.nominal), point.measured, point.axes});
  }
  auto result = fit_panel<frame::Actual, frame::Base>(pairs, series.model);
  if (!result.fit) return report_fit_failure(series, result.failure);
  if (is_mirrored(result.fit->map.map.linear())) return report_mirrored(series);
  series.gates = check_gates(*result.fit, options_.nested_limits);
  series.nested = std::make_shared<const NestedFit>(*std::move(result.fit));
}

void Measuring::report_fit_failure(const SeriesResult& series, FitFailure failure) {
  const std::string what = fmt::format("{} targets from line {} do not determine the model \"{}\"",
                                       series.measurements.size(),
                                       series.line,
                                       name(series.model));
  switch (failure) {
    case FitFailure::TooFewTargets:
      reporter_.report(Code::TargetsTooFew,
                       series.line,
                       1,
                       what,
                       fmt::format("at least {} coordinates", parameter_count(series.model)));
      return;
    case FitFailure::Degenerate:
      reporter_.report(Code::SeriesDegenerate,
                       series.line,
                       1,
                       what,
                       "targets that neither coincide nor lie in one line");
      return;
    case FitFailure::BadCovariance:
      reporter_.report(Code::MeasurementInvalid,
                       series.line,
                       1,
                       "a measurement of the series has no usable covariance",
                       "a positive definite matrix");
      return;
  }
}

void Measuring::report_mirrored(const SeriesResult& series) {
  reporter_.report(Code::PanelMirrored,
                   series.line,
                   1,
                   fmt::format("the {} targets of the series are seen as in a mirror",
                               series.measurements.size()),
                   "the panel the right way up");
}

void Measuring::report_gates(const SeriesResult& series, std::span<const FitPoint> points) {
  for (const GateVerdict& gate : series.gates) {
    if (gate.accepted) continue;
    const Measurement& worst = measurement(points[gate.i_target.value_or(0)].i_measurement);
    const MeasurementRequest& request = worst.request;
    const std::string what = fmt::format("{} ({} {} at nominal ({:.4f}, {:.4f}) mm)",
                                         gate.text(),
                                         request.command,
                                         gate.i_target ? "target" : "series that begins",
                                         request.nominal.in_mm().x(),
                                         request.nominal.in_mm().y());
    reporter_.report(Code::GateFailed, gate.i_target ? request.line : series.line, 1, what);
  }
}

void Measuring::activate(std::size_t i_series, int line) {
  const SeriesResult& series = survey_.series[i_series];
  if (series.level == CorrectionLevel::Base) {
    if (!series.base) {
      must_stop_ = true;
      return;
    }
    corrections_.stack.set_base(series.base);
    corrections_.base_series = i_series;
    corrections_.nested_series.reset();
    return;
  }
  corrections_.nested_series.reset();
  if (!series.nested) return corrections_.stack.clear_nested();
  if (series.base_series != corrections_.base_series) {
    reporter_.report(
        Code::NestedBaseChanged,
        line,
        1,
        fmt::format("the nested correction measured in line {} was relative to another "
                    "base correction than the one in force",
                    series.line),
        "the base correction it was measured under");
    must_stop_ = true;
    return;
  }
  corrections_.stack.set_nested(series.nested);
  corrections_.nested_series = i_series;
}

}  // namespace panelcal
