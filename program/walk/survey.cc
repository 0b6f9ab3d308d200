// SPDX-License-Identifier: Apache-2.0
#include "program/walk/survey.h"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace panelcal {

bool SeriesResult::is_accepted() const {
  return is_fitted() && (!fault || fault->is_resolved) &&
         std::ranges::all_of(gates, &GateVerdict::accepted);
}

bool Survey::is_complete() const {
  const auto is_settled = [](const SeriesResult& one) {
    return one.is_fitted() || one.is_left_out;
  };
  return !was_stopped && std::ranges::all_of(series, is_settled) &&
         std::ranges::all_of(measurements, [](const Measurement& measurement) {
           return measurement.status == MeasurementStatus::Found || is_left_out(measurement);
         });
}

bool Survey::is_accepted() const {
  return is_complete() && std::ranges::all_of(series, [](const SeriesResult& one) {
           return one.is_accepted() || one.is_left_out;
         });
}

std::vector<const SeriesResult*> Survey::left_out_boards() const {
  std::vector<const SeriesResult*> boards;
  for (const SeriesResult& one : series) {
    // A board may have several series, which follow each other.
    const bool is_same =
        !boards.empty() && boards.back() + 1 == &one && one.path == boards.back()->path;
    if (one.is_left_out && !is_same) boards.push_back(&one);
  }
  return boards;
}

namespace {

/// A panel that stands against pins or edges lies this near. Panels farther off that no [gates]
/// offset_mm holds are named in the verdict.
constexpr double kFarOffset_mm = 10;

/// Distance of the targets' centroid from where the program has it, mm, where no limit holds it.
double ungated_offset_mm(const SeriesResult& series) {
  if (!series.is_fitted() || series.limits.offset) return 0;
  GateLimits limits;
  limits.offset = Length();
  limits.turned_deg = series.limits.turned_deg;
  const std::vector<GateVerdict> verdicts =
      series.base ? check_gates(*series.base, limits) : check_gates(*series.nested, limits);
  return verdicts.front().value;
}

}  // namespace

std::vector<std::string> Survey::gates_off() const {
  std::vector<std::string> off;
  for (const SeriesResult& one_series : series) {
    const bool is_nested = one_series.level == CorrectionLevel::Nested;
    for (const std::string_view gate : panelcal::gates_off(one_series.limits)) {
      std::string words = std::string(gate) + (is_nested ? " of nested fits" : "");
      if (std::ranges::find(off, words) == off.end()) off.push_back(std::move(words));
    }
  }
  double largest_mm = 0;
  for (const SeriesResult& one_series : series) {
    largest_mm = std::max(largest_mm, ungated_offset_mm(one_series));
  }
  if (largest_mm > kFarOffset_mm) {
    off.push_back(
        fmt::format("offset (targets lie {:.1f} mm from their programmed places)", largest_mm));
  }
  return off;
}

const CalibrationAnswer* Survey::calibration_of(std::size_t i_measurement) const {
  const auto after =
      std::ranges::upper_bound(calibrations, i_measurement, {}, &CalibrationAnswer::i_measurement);
  if (after == calibrations.begin()) return nullptr;
  const std::optional<std::size_t> i = std::prev(after)->i_in_force;
  return i ? &calibrations[*i] : nullptr;
}

const CalibrationAnswer* Survey::calibration_of(const SeriesResult& one_series) const {
  if (one_series.measurements.empty()) return nullptr;
  return calibration_of(one_series.measurements.back());
}

OffsetUncertainty offset_uncertainty(const CalibrationAnswer* calibration,
                                     const MachineUncertainty& machine) {
  if (calibration == nullptr || !calibration->offset) return machine.offset();
  return {calibration->offset->cov_mm2, Eigen::Matrix2d::Zero()};
}

std::string measurement_lines(const Survey& survey) {
  std::string lines;
  auto calibration = survey.calibrations.begin();
  const auto take_calibrations = [&](std::size_t i_measurement) {
    for (; calibration != survey.calibrations.end() && calibration->i_measurement <= i_measurement;
         ++calibration) {
      lines += to_json(*calibration) + "\n";
    }
  };
  for (std::size_t i = 0; i < survey.measurements.size(); ++i) {
    take_calibrations(i);
    lines += to_json(survey.measurements[i]) + "\n";
  }
  take_calibrations(survey.measurements.size());
  return lines;
}

}  // namespace panelcal
