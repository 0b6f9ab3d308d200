// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/excellon/vision.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

bool is_nested(Command command) {
  return command == Command::NestedOffset || command == Command::NestedSeries ||
         command == Command::NestedHoleAtTarget;
}

bool is_single(Command command) {
  return command == Command::BaseOffset || command == Command::NestedOffset;
}

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

VisionSession::VisionSession(const WalkOptions& options,
                             Survey& survey,
                             MeasurementSource* source,
                             const Reporter& reporter,
                             DiagnosticLog& log)
    : options_(options),
      survey_(survey),
      source_(source),
      reporter_(reporter),
      log_(log),
      series_size_(options.series_size) {
}

bool VisionSession::refuse_unfinished(int line, std::string_view command) {
  if (!open_) return false;
  reporter_.report(Code::SeriesUnfinished,
                   line,
                   1,
                   fmt::format("{} comes after {} of {} targets of the {} series begun in line {}",
                               command,
                               open_->measurements.size(),
                               open_->n_wanted,
                               open_->command,
                               open_->line),
                   fmt::format("{} more {}",
                               open_->n_wanted - static_cast<int>(open_->measurements.size()),
                               open_->command));
  open_.reset();
  return true;
}

std::optional<std::size_t> VisionSession::measure(const TargetPlace& target,
                                                  CorrectionLevel level) {
  const std::size_t index = n_measured_++;
  if (source_ == nullptr) return index;

  if (settings_.tools.empty()) {
    reporter_.report(Code::VisionToolMissing,
                     target.line,
                     1,
                     code_text(target.command) + " measures before any G34",
                     "G34,# with the number of a vision tool");
    must_stop_ = true;
    return std::nullopt;
  }
  MeasurementRequest request;
  request.seq = static_cast<std::int64_t>(index);
  request.line = target.line;
  request.file = target.file;
  request.command = code_text(target.command);
  request.settings = settings_;
  request.nominal = target.nominal;
  request.work_zero = target.work_zero;
  request.path = target.path;
  const Eigen::Vector2d expected_mm = level == CorrectionLevel::Nested
                                          ? stack_.base_from_nominal()(target.nominal).in_mm()
                                          : target.nominal.in_mm();
  request.expected = position_mm<frame::Actual>(expected_mm);

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

void VisionSession::report_lost(const Measurement& measurement) {
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

void VisionSession::measure_target(const TargetPlace& target) {
  const CorrectionLevel level =
      is_nested(target.command) ? CorrectionLevel::Nested : CorrectionLevel::Base;
  const std::string command = code_text(target.command);
  if (refuse_inside_stored(target.line)) return;
  if (open_ && open_->command != command) refuse_unfinished(target.line, command);
  if (!open_) {
    open_ = OpenSeries{.level = level,
                       .line = target.line,
                       .n_wanted = is_single(target.command) ? 1 : series_size_,
                       .command = command,
                       .measurements = {}};
  }
  const std::optional<std::size_t> index = measure(target, level);
  if (!index) return;
  open_->measurements.push_back(*index);
  if (static_cast<int>(open_->measurements.size()) == open_->n_wanted) complete(target);
}

std::optional<PositionEstimate<frame::Actual>> VisionSession::measure_hole(
    const TargetPlace& target) {
  refuse_unfinished(target.line, code_text(target.command));
  const CorrectionLevel level =
      is_nested(target.command) ? CorrectionLevel::Nested : CorrectionLevel::Base;
  const auto index = measure(target, level);
  if (!index) return std::nullopt;
  const Measurement& measurement = survey_.measurements[*index];
  if (measurement.status != MeasurementStatus::Found) return std::nullopt;
  if (source_ != nullptr) gate_hole(measurement, level);
  return measurement.measured;
}

/// A hole at its own target has no fit to hold against limits, but it may not be farther from its
/// expected place than a panel may be.
void VisionSession::gate_hole(const Measurement& measurement, CorrectionLevel level) {
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

void VisionSession::complete(const TargetPlace& target) {
  const OpenSeries open = *std::exchange(open_, std::nullopt);
  const std::size_t i_series = n_fitted_++;
  if (source_ != nullptr) survey_.series.push_back(fit(open, target));
  memory_.store({i_series, open.n_wanted});
  activate(i_series, target.line);
}

SeriesResult VisionSession::fit(const OpenSeries& open, const TargetPlace& target) {
  SeriesResult series;
  series.level = open.level;
  series.line = open.line;
  series.path = target.path;
  series.placement = target.placement;
  series.measurements = open.measurements;
  series.model = open.n_wanted == 1 ? PanelModel::Offset
                                    : options_.model.value_or(default_model(open.n_wanted));
  const bool all_found = std::ranges::all_of(open.measurements, [&](std::size_t i) {
    return survey_.measurements[i].status == MeasurementStatus::Found;
  });
  if (!all_found) return series;
  if (open.level == CorrectionLevel::Base) {
    fit_base(open, series);
  } else {
    series.base_series = base_series_;
    fit_nested(open, series);
  }
  report_gates(series);
  return series;
}

void VisionSession::fit_base(const OpenSeries& open, SeriesResult& series) {
  std::vector<TargetPair<frame::Base, frame::Nominal>> pairs;
  for (const std::size_t i : open.measurements) {
    const Measurement& m = survey_.measurements[i];
    // Without a nested correction the base frame is the actual one.
    pairs.push_back({m.request.nominal,
                     {position_mm<frame::Base>(m.measured.position.in_mm()), m.measured.cov}});
  }
  auto result = fit_panel<frame::Base, frame::Nominal>(pairs, series.model);
  if (!result.fit) return report_fit_failure(series, result.failure);
  if (is_mirrored(result.fit->map.map.linear())) return report_mirrored(series);
  series.gates = check_gates(*result.fit, options_.base_limits);
  series.base = std::make_shared<const BaseFit>(*std::move(result.fit));
}

void VisionSession::fit_nested(const OpenSeries& open, SeriesResult& series) {
  std::vector<TargetPair<frame::Actual, frame::Base>> pairs;
  for (const std::size_t i : open.measurements) {
    const Measurement& m = survey_.measurements[i];
    pairs.push_back({stack_.base_from_nominal()(m.request.nominal), m.measured});
  }
  auto result = fit_panel<frame::Actual, frame::Base>(pairs, series.model);
  if (!result.fit) return report_fit_failure(series, result.failure);
  if (is_mirrored(result.fit->map.map.linear())) return report_mirrored(series);
  series.gates = check_gates(*result.fit, options_.nested_limits);
  series.nested = std::make_shared<const NestedFit>(*std::move(result.fit));
}

void VisionSession::report_fit_failure(const SeriesResult& series, FitFailure failure) {
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

void VisionSession::report_mirrored(const SeriesResult& series) {
  reporter_.report(Code::PanelMirrored,
                   series.line,
                   1,
                   fmt::format("the {} targets of the series are seen as in a mirror",
                               series.measurements.size()),
                   "the panel the right way up");
}

void VisionSession::report_gates(const SeriesResult& series) {
  for (const GateVerdict& gate : series.gates) {
    if (gate.accepted) continue;
    const Measurement& worst = survey_.measurements[series.measurements[gate.i_target.value_or(0)]];
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

void VisionSession::activate(std::size_t i_series, int line) {
  const SeriesResult& series = survey_.series[i_series];
  if (series.level == CorrectionLevel::Base) {
    if (!series.base) {
      must_stop_ = true;
      return;
    }
    stack_.set_base(series.base);
    base_series_ = i_series;
    nested_series_.reset();
    return;
  }
  nested_series_.reset();
  if (!series.nested) return stack_.clear_nested();
  if (series.base_series != base_series_) {
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
  stack_.set_nested(series.nested);
  nested_series_ = i_series;
}

void VisionSession::cancel_base(int line) {
  refuse_unfinished(line, "G37");
  stack_.clear_base();
  base_series_.reset();
  nested_series_.reset();
}

void VisionSession::cancel_nested(int line) {
  refuse_unfinished(line, "G47");
  stack_.clear_nested();
  nested_series_.reset();
}

void VisionSession::end_instance(int line) {
  refuse_unfinished(line, "the end of the pattern");
}

bool VisionSession::is_allowed(int line) {
  if (refuse_unfinished(line, "a coordinate")) return false;
  return !refuse_inside_stored(line) && !refuse_without_advance(line);
}

void VisionSession::end_program(int line) {
  refuse_unfinished(line, "the end of the program");
}

bool VisionSession::is_unused() const {
  return !open_ && stack_.base() == nullptr && stack_.nested() == nullptr && memory_.empty();
}

}  // namespace panelcal::excellon
