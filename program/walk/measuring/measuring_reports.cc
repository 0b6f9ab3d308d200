// SPDX-License-Identifier: Apache-2.0
// Diagnostics of targets that are lost, of fits that are refused, and of their causes.
#include <algorithm>
#include <string>
#include <utility>

#include "program/walk/measuring/measuring.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal {
namespace {

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

std::string remedy(MeasurementStatus status) {
  switch (status) {
    case MeasurementStatus::Ambiguous:
      return "one that fits best, as a smaller search_radius_mm of [vision] may leave";
    case MeasurementStatus::Rejected:
    case MeasurementStatus::Skipped:
      return "";
    case MeasurementStatus::BoardLeftOut:
      return "a series in a copy of a pattern (M25), ahead of its holes";
    default:
      return "a mark of the vision tool's size and polarity, at most search_radius_mm of [vision] "
             "from its place";
  }
}

/// For a panel whose rotation only another quarter turn explains.
std::string turn_remedy(const SeriesResult& series) {
  if (series.base == nullptr) return {};
  GateLimits limits{.rotation = series.limits.rotation};
  limits.refuses_mirror = series.limits.refuses_mirror;
  for (const int turned_deg : {0, 90, 180, 270}) {
    limits.turned_deg = turned_deg;
    if (!all_accepted(check_gates(*series.base, limits))) continue;
    return fmt::format("--turned {} or [gates] turned_deg, if the panel is meant to lie so",
                       turned_deg);
  }
  return {};
}

}  // namespace

void Measuring::report_lost(const Measurement& measurement) {
  const MeasurementRequest& request = measurement.request;
  reporter_.report(lost_code(measurement.status),
                   request.line,
                   fmt::format("{} target {} at nominal ({:.4f}, {:.4f}) mm{}{}",
                               request.command,
                               request.seq,
                               request.nominal.in_mm().x(),
                               request.nominal.in_mm().y(),
                               measurement.reason.empty() ? "" : ": ",
                               measurement.reason),
                   remedy(measurement.status));
}

void Measuring::report_left_out(const SeriesResult& series) {
  // The board's first series has said it.
  if (corrections_.is_withheld) return;
  const Measurement& first = measurement(*std::ranges::find_if(
      series.measurements, [this](std::size_t i) { return is_of_left_out_board(i); }));
  reporter_.report(Code::TargetDropped,
                   first.request.line,
                   fmt::format("board {} is left out, and nothing of it is drilled{}{}",
                               fmt::join(series.path, "."),
                               first.reason.empty() ? "" : ": ",
                               first.reason));
}

void Measuring::report_skipped(const Measurement& measurement, const SeriesResult& series) {
  if (!series.is_fitted()) return report_lost(measurement);
  report_dropped(measurement.request, series, measurement.reason);
}

void Measuring::report_dropped(const SeriesResult& series, std::span<const std::string> reasons) {
  for (std::size_t i = 0; i < series.dropped.size(); ++i) {
    report_dropped(measurement(series.dropped[i]).request, series, reasons[i]);
  }
}

void Measuring::report_dropped(const MeasurementRequest& request,
                               const SeriesResult& series,
                               const std::string& reason) {
  reporter_.report(Code::TargetDropped,
                   request.line,
                   fmt::format("{} target at nominal ({:.4f}, {:.4f}) mm, {} others make "
                               "the fit: {}",
                               request.command,
                               request.nominal.in_mm().x(),
                               request.nominal.in_mm().y(),
                               series.points.size(),
                               reason));
}

void Measuring::report_fault(const SeriesResult& series, std::span<const FitPoint> points) {
  // Without a rate the test refuses nothing; a gate has, and the summary and the report say why.
  if (!series.fault || !(series.fault->false_alarm > 0)) return;
  const SeriesFault& fault = *series.fault;
  const int line = fault.i_outlier
                       ? measurement(points[*fault.i_outlier].i_measurement).request.line
                       : series.line;
  std::string what = fault.text();
  if (fault.degrees_of_freedom > 0 && fault.p_value < fault.false_alarm) {
    constexpr double kLeastShown = 1e-6;
    what += fault.p_value < kLeastShown
                ? "; healthy targets fit so badly less than once in a million times"
                : fmt::format("; healthy targets fit so badly with p = {:.2g}", fault.p_value);
  }
  reporter_.report(
      fault.i_outlier ? Code::TargetSuspected : Code::SeriesInconsistent, line, std::move(what));
}

void Measuring::report_fit_failure(const SeriesResult& series, bool bends) {
  const auto undetermined = [&](std::size_t n_targets, std::string_view model) {
    return fmt::format(
        "{} targets from line {} do not determine the model \"{}\"", n_targets, series.line, model);
  };
  const std::size_t n_targets = series.measurements.size();
  // Targets of one coordinate (G45, slots) may be enough in number and still too few.
  const auto n_parameters = static_cast<std::size_t>(parameter_count(series.model));
  switch (*series.failure) {
    case FitFailure::TooFewTargets:
      if (bends) {
        return reporter_.report(
            Code::TargetsTooFew,
            series.line,
            undetermined(series.points.size(), "smooth"),
            fmt::format(
                "{} to {} targets, not in one line", kLeastSmoothTargets, kMostSmoothTargets));
      }
      return reporter_.report(Code::TargetsTooFew,
                              series.line,
                              undetermined(n_targets, name(series.model)),
                              2 * n_targets >= n_parameters
                                  ? fmt::format("at least {} coordinates", n_parameters)
                                  : fmt::format("{} targets or more", (n_parameters + 1) / 2));
    case FitFailure::Degenerate:
      return reporter_.report(Code::SeriesDegenerate,
                              series.line,
                              undetermined(n_targets, name(series.model)),
                              "targets that neither coincide nor lie in one line");
    case FitFailure::BadCovariance:
      return reporter_.report(Code::MeasurementInvalid,
                              series.line,
                              "a measurement of the series has no usable covariance",
                              "a positive definite matrix");
    case FitFailure::Mirrored:
      return reporter_.report(Code::PanelMirrored,
                              series.line,
                              fmt::format("{} targets of the series", n_targets),
                              "the panel the right way up, or mirror = \"off\" in [gates]");
    case FitFailure::Folded:
      return reporter_.report(
          Code::PanelFolded,
          series.line,
          fmt::format("{} targets", series.points.size()),
          "targets that were not taken for one another, or an affine [vision] model");
  }
}

void Measuring::report_nested_on_smooth(const SeriesResult& series) {
  reporter_.report(Code::NestedOnSmooth,
                   series.line,
                   fmt::format("nested series from line {}", series.line),
                   "[vision] model = \"affine\" or a stiffer one, or no nested series");
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
    reporter_.report(Code::GateFailed,
                     gate.i_target ? request.line : series.line,
                     what,
                     gate.gate == "rotation" ? turn_remedy(series) : "");
  }
}

}  // namespace panelcal
