// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/measuring/offset_deviation.h"

#include <algorithm>
#include <tuple>
#include <vector>

#include "calib/base/statistics/chi_square.h"
#include "program/text/number_format.h"
#include <Eigen/LU>

namespace panelcal::sieb_meyer {
namespace {

/// 1 for a coordinate that a target shows, 0 for the other one of a slot.
Eigen::Vector2d shown_by(const Measurement& m) {
  return {observes_x(m.request.axes) ? 1.0 : 0.0, observes_y(m.request.axes) ? 1.0 : 0.0};
}

Eigen::Vector2d deviation_mm(const Measurement& m) {
  return (m.measured.position - m.request.expected).in_mm();
}

/// Number of holes that show each coordinate.
Eigen::Vector2d count_holes(std::span<const Measurement> measured) {
  std::vector<std::tuple<double, double, ObservedAxes>> seen;
  for (const Measurement& m : measured) {
    const Eigen::Vector2d& place_mm = m.request.nominal.in_mm();
    seen.emplace_back(place_mm.x(), place_mm.y(), m.request.axes);
  }
  std::ranges::sort(seen);
  const auto repeated = std::ranges::unique(seen);
  seen.erase(repeated.begin(), repeated.end());
  Eigen::Vector2d n = Eigen::Vector2d::Zero();
  for (const auto& [x_mm, y_mm, axes] : seen) {
    n += Eigen::Vector2d(observes_x(axes) ? 1 : 0, observes_y(axes) ? 1 : 0);
  }
  return n;
}

/// Scatter of targets about their mean.
struct Scatter {
  double chi_square = 0;
  int n_free = 0;  ///< 0: there is nothing to compare
};

Scatter scatter_of(std::span<const Measurement> measured,
                   const Eigen::Vector2d& mean_mm,
                   const MachineUncertainty& machine) {
  const Eigen::Matrix2d of_machine_mm2 =
      machine.stage_mm2() + machine.table_mm2() + machine.of_hole_mm2();
  Scatter scatter;
  for (const Measurement& m : measured) {
    if (m.request.axes != ObservedAxes::Both) return {};
    const Eigen::Vector2d off_mm = deviation_mm(m) - mean_mm;
    scatter.chi_square += off_mm.dot((m.measured.cov + of_machine_mm2).inverse() * off_mm);
    scatter.n_free += 2;
  }
  scatter.n_free = std::max(0, scatter.n_free - 2);
  return scatter;
}

/// At least 1: how much wider targets scatter than their covariances say.
double ratio_of(const Scatter& scatter) {
  return scatter.n_free > 0 ? std::max(1.0, scatter.chi_square / scatter.n_free) : 1;
}

}  // namespace

std::optional<OffsetOrder> offset_order(std::string_view text) {
  if (text == "SPOP" || text == "SPOP1") return OffsetOrder{OffsetOrder::Of::Station, 1};
  if (text == "SPOP2") return OffsetOrder{OffsetOrder::Of::Station, 2};
  if (text == "SPISPI") return OffsetOrder{OffsetOrder::Of::SpindleToSpindle, 1};
  if (!text.starts_with("SPOF")) return std::nullopt;
  const auto spindle = parse_count(text.substr(4));
  if (!spindle || *spindle < 1 || *spindle > kMostSpindles) return std::nullopt;
  return OffsetOrder{OffsetOrder::Of::Spindle, *spindle};
}

std::optional<OffsetCorrection> offset_deviation(std::span<const Measurement> measured,
                                                 const MachineUncertainty& machine) {
  Eigen::Vector2d n = Eigen::Vector2d::Zero();
  Eigen::Vector2d sum_mm = Eigen::Vector2d::Zero();
  Eigen::Matrix2d sum_mm2 = Eigen::Matrix2d::Zero();
  CameraJacobian by_camera = CameraJacobian::Zero();
  for (const Measurement& m : measured) {
    const Eigen::Vector2d shown = shown_by(m);
    n += shown;
    sum_mm += shown.cwiseProduct(deviation_mm(m));
    sum_mm2 += shown.asDiagonal() * (m.measured.cov + machine.stage_mm2()) * shown.asDiagonal();
    by_camera += shown.asDiagonal() * m.by_camera.value_or(CameraJacobian::Zero());
  }
  if (!(n.minCoeff() > 0)) return std::nullopt;
  const Eigen::Matrix2d share = n.cwiseInverse().asDiagonal();
  const Eigen::Vector2d mean_mm = share * sum_mm;
  OffsetCorrection correction;
  correction.deviation = displacement_mm<frame::Machine>(mean_mm);
  correction.by_camera = share * by_camera;
  const Eigen::Matrix2d of_hole_mm2 = machine.table_mm2() + machine.of_hole_mm2();
  const Eigen::Vector2d n_holes = count_holes(measured).cwiseMax(1);
  correction.cov_mm2 = share * sum_mm2 * share;
  correction.cov_mm2 +=
      of_hole_mm2.cwiseProduct(Eigen::Matrix2d(n_holes.cwiseInverse().asDiagonal()));
  correction.cov_mm2 *= ratio_of(scatter_of(measured, mean_mm, machine));
  // Rounding must not make it unsymmetric: an offset takes only what is a covariance.
  correction.cov_mm2(1, 0) = correction.cov_mm2(0, 1);
  return correction;
}

double scatter_chance(std::span<const Measurement> measured, const MachineUncertainty& machine) {
  const auto deviation = offset_deviation(measured, machine);
  if (!deviation || !(machine.drill_wander > Length())) return 1;
  const Scatter scatter = scatter_of(measured, deviation->deviation.in_mm(), machine);
  return scatter.n_free > 0 ? chi_square_exceedance(scatter.chi_square, scatter.n_free) : 1;
}

}  // namespace panelcal::sieb_meyer
