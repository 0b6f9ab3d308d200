// SPDX-License-Identifier: Apache-2.0
#include "program/walk/measuring/series_examination.h"

#include <algorithm>

#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Around a board's targets so far pads are looked for, or as far as the board is large.
constexpr double kAround_mm = 10;

/// The pads near a board where the base correction puts them.
KnownPads carried_pads(const KnownPads& pads,
                       std::span<const FitPoint> points,
                       const Transform<frame::Base, frame::Nominal>& base) {
  Eigen::Vector2d low_mm = points.front().nominal.in_mm();
  Eigen::Vector2d high_mm = low_mm;
  for (const FitPoint& point : points) {
    low_mm = low_mm.cwiseMin(point.nominal.in_mm());
    high_mm = high_mm.cwiseMax(point.nominal.in_mm());
  }
  const double around_mm = std::max(kAround_mm, (high_mm - low_mm).norm());
  const Eigen::Vector2d around = Eigen::Vector2d::Constant(around_mm);
  std::vector<std::size_t> near;
  pads.inside(low_mm - around, high_mm + around, near);
  std::vector<KnownPad> out;
  for (const std::size_t i : near) {
    KnownPad pad = pads.all()[i];
    pad.place_mm = base(position_mm<frame::Nominal>(pad.place_mm)).in_mm();
    out.push_back(pad);
  }
  return KnownPads(std::move(out));
}

/// Deviation of a smooth series from its affine part.
Eigen::Vector2d bending_mm(const SeriesResult& series, const Position<frame::Nominal>& nominal) {
  if (!series.base || !series.is_smooth()) return Eigen::Vector2d::Zero();
  return series.base->smooth->map(nominal).in_mm() - series.base->map.map(nominal).in_mm();
}

/// Counted over all targets of the series, those left out as well.
std::size_t target_number(const SeriesResult& series,
                          std::span<const FitPoint> points,
                          std::size_t i) {
  const auto is_before = [&](std::size_t dropped) { return dropped < points[i].i_measurement; };
  return i + 1 + static_cast<std::size_t>(std::ranges::count_if(series.dropped, is_before));
}

std::string name_of(const MeasurementRequest& request, std::size_t number) {
  return fmt::format("target {} ({} in line {}, nominal ({:.4f}, {:.4f}) mm)",
                     number,
                     request.command,
                     request.line,
                     request.nominal.in_mm().x(),
                     request.nominal.in_mm().y());
}

/// Of a panel that is meant to lie turned: its target where it would be on one that is not, as
/// causes and pads have it.
void turn_back(internal::ExaminedTarget& target, int turned_deg) {
  if (turned_deg == 0) return;
  const int back_deg = 360 - turned_deg;
  const auto turn_columns = [&](const Eigen::Matrix2d& m) {
    Eigen::Matrix2d out;
    out << turned_by(m.col(0), back_deg), turned_by(m.col(1), back_deg);
    return out;
  };
  const auto turn_covariance = [&](const Eigen::Matrix2d& cov_mm2) -> Eigen::Matrix2d {
    return turn_columns(turn_columns(cov_mm2).transpose());
  };
  target.to_mm = turned_by(target.to_mm, back_deg);
  target.cov_mm2 = turn_covariance(target.cov_mm2);
  if (target.picture_cov_mm2) target.picture_cov_mm2 = turn_covariance(*target.picture_cov_mm2);
  if (turned_deg % 180 == 0 || target.axes == ObservedAxes::Both) return;
  target.axes = target.axes == ObservedAxes::X ? ObservedAxes::Y : ObservedAxes::X;
}

}  // namespace

std::optional<SeriesFault> examine_series(const SeriesResult& series,
                                          std::span<const FitPoint> points,
                                          const Survey& survey,
                                          const CorrectionStack& stack,
                                          const WalkOptions& options) {
  const bool is_base = series.level == CorrectionLevel::Base;
  const auto base_from_nominal =
      is_base ? Transform<frame::Base, frame::Nominal>() : stack.base_from_nominal();
  std::vector<internal::ExaminedTarget> targets;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const FitPoint& point = points[i];
    const Measurement& measurement = survey.measurements[point.i_measurement];
    targets.push_back({base_from_nominal(point.nominal).in_mm(),
                       point.measured.position.in_mm() - bending_mm(series, point.nominal),
                       point.measured.cov,
                       point.axes,
                       measurement.score,
                       name_of(measurement.request, target_number(series, points, i)),
                       measurement.measured.cov});
    turn_back(targets.back(), series.limits.turned_deg);
  }
  FaultContext context{.limits = series.limits};
  context.is_refused = !series.is_fitted() || !all_accepted(series.gates);
  // Most series are healthy, and then no pads need to be searched.
  const auto first = internal::find_fault_raw(targets, series.model, context);
  if (!first || !options.known_pads) return first;
  const KnownPads* known = options.known_pads();
  if (known == nullptr) return first;
  KnownPads carried;
  if (!is_base) carried = carried_pads(*known, points, base_from_nominal);
  context.pads = is_base ? known : &carried;
  return internal::find_fault_raw(targets, series.model, context);
}

std::optional<std::vector<FitPoint>> without_point(std::span<const FitPoint> points,
                                                   std::size_t i_point,
                                                   PanelModel model) {
  std::vector<FitPoint> kept(points.begin(), points.end());
  kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(i_point));
  std::vector<internal::RawPair> pairs;
  for (const FitPoint& point : kept) {
    pairs.push_back(
        {point.nominal.in_mm(), point.measured.position.in_mm(), point.measured.cov, point.axes});
  }
  const internal::RawFitResult result = internal::fit_raw(pairs, model);
  if (!result.fit || result.fit->degrees_of_freedom < 1) return std::nullopt;
  if (!(result.fit->linear.determinant() > 0)) return std::nullopt;
  return kept;
}

bool is_checked_without(const SeriesResult& series,
                        const Survey& nominal,
                        std::span<const std::size_t> left_out) {
  std::vector<internal::RawPair> pairs;
  for (const std::size_t i : series.measurements) {
    if (std::ranges::find(left_out, i) != left_out.end()) continue;
    const Measurement& target = nominal.measurements[i];
    pairs.push_back({target.request.nominal.in_mm(),
                     target.measured.position.in_mm(),
                     target.measured.cov,
                     target.request.axes});
  }
  const internal::RawFitResult result = internal::fit_raw(pairs, series.prescribed);
  return result.fit && result.fit->degrees_of_freedom >= 1;
}

}  // namespace panelcal
