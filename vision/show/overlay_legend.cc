// SPDX-License-Identifier: Apache-2.0
#include "vision/show/overlay_legend.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "calib/base/statistics/linear_algebra.h"
#include "vision/show/other_candidates.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// A texture full of false starts must not make a legend longer than the picture is high.
constexpr std::size_t kMaxListed = 12;
/// Chi-square of two degrees of freedom below which lie 95 %.
constexpr double kChiSquare95 = 5.991464547;

using Lines = std::vector<LegendLine>;

std::string point_text(const Eigen::Vector2d& v, int n_decimals) {
  return fmt::format("{:.{}f}, {:.{}f}", v.x(), n_decimals, v.y(), n_decimals);
}

/// Along x and y, in digits that say something.
std::string sigma_text(const Eigen::Matrix2d& cov) {
  const Eigen::Vector2d sigma = cov.diagonal().cwiseMax(0).cwiseSqrt();
  return fmt::format("{:.2g}, {:.2g}", sigma.x(), sigma.y());
}

void add_place(const TargetFit& fit, Lines& lines) {
  lines.push_back({fmt::format("centre {} px", point_text(fit.center.position.in_px(), 4))});
  if (fit.blind_direction) {
    const UncertaintyEllipse ellipse = uncertainty_ellipse(fit.center.cov);
    lines.push_back(
        {fmt::format("sigma across {:.2g} px", ellipse.minor_px.norm() / std::sqrt(kChiSquare95))});
    lines.push_back(
        {fmt::format("nothing measured along {:.2f} deg", fit.blind_direction->in_deg()),
         Ink::Bad});
    return;
  }
  lines.push_back({fmt::format("sigma {} px", sigma_text(fit.center.cov))});
  if (fit.center_optical) {
    constexpr double kUm2PerMm2 = 1e6;
    lines.push_back({fmt::format("sigma {} um", sigma_text(kUm2PerMm2 * fit.center_optical->cov))});
  }
}

void add_size(const TargetFit& fit, Lines& lines) {
  lines.push_back(
      {fit.size_mm
           ? fmt::format("size {:.3f} px = {:.4f} mm", fit.size.in_px(), fit.size_mm->in_mm())
           : fmt::format("size {:.3f} px", fit.size.in_px())});
  if (fit.inner_size) {
    lines.push_back({fmt::format("hole {:.3f} px, off by {} px",
                                 fit.inner_size->in_px(),
                                 point_text(fit.hole_offset_px, 3))});
  }
  if (fit.axis_ratio != 1) lines.push_back({fmt::format("axes 1 : {:.4f}", fit.axis_ratio)});
  if (fit.angle_sigma.in_rad() > 0) {
    lines.push_back({fmt::format(
        "angle {:.3f} deg, sigma {:.2g}", fit.angle.in_deg(), fit.angle_sigma.in_deg())});
  }
}

Lines facts_of(const TargetFit& fit) {
  Lines lines;
  if (fit.tag_id) lines.push_back({fmt::format("id {}", *fit.tag_id)});
  add_place(fit, lines);
  add_size(fit, lines);
  for (std::size_t i = 0; i < fit.corners.size(); ++i) {
    lines.push_back(
        {fmt::format("corner {}: {}", i, point_text(fit.corners[i].position.in_px(), 3))});
  }
  lines.push_back({fmt::format("score {:.3f}, blur {:.2f} px", fit.score, fit.blur_px)});
  lines.push_back({fmt::format("contrast {:+.1f}, noise {:.2f}", fit.contrast, fit.noise)});
  lines.push_back({fmt::format(
      "{:.0f} % of the rim seen, {:.0f} % left out", 100 * fit.visible, 100 * fit.excluded)});
  return lines;
}

std::string why(const Candidate& candidate, DetectionStatus status) {
  if (!candidate.reason.empty()) return candidate.reason;
  return status == DetectionStatus::Found ? "it counts, but the one found is better" : "it counts";
}

Lines candidate_lines(const Detection& detection) {
  const auto others = other_candidates(detection);
  Lines lines;
  const bool has_best = detection.best && detection.status != DetectionStatus::Found;
  for (std::size_t i = 0; i < std::min(others.size(), kMaxListed); ++i) {
    const Candidate& c = others[i];
    const bool is_best = has_best && c.center == detection.best->center.position;
    lines.push_back({fmt::format("{}  at {}, size {:.1f} px, score {:.2f}: {}",
                                 i + 1,
                                 point_text(c.center.in_px(), 1),
                                 c.size.in_px(),
                                 c.score,
                                 why(c, detection.status)),
                     is_best ? Ink::Bad : Ink::Other});
  }
  if (others.size() > kMaxListed) {
    lines.push_back({fmt::format("and {} more", others.size() - kMaxListed), Ink::Quiet});
  }
  return lines;
}

}  // namespace

Legend legend_of(const Detection& detection, std::string_view title) {
  Legend legend;
  if (!title.empty()) legend.verdict.push_back({std::string(title), Ink::Quiet});
  std::string verdict(name(detection.status));
  std::ranges::replace(verdict, '_', ' ');
  if (!detection.reason.empty()) verdict += ": " + detection.reason;
  legend.verdict.push_back({std::move(verdict), ink_of(detection.status)});
  if (detection.best) legend.facts = facts_of(*detection.best);
  legend.candidates = candidate_lines(detection);
  return legend;
}

UncertaintyEllipse uncertainty_ellipse(const Eigen::Matrix2d& cov_px2) {
  const PlaneEigensystem eigen = plane_eigensystem(cov_px2);
  const Eigen::Vector2d semi_px =
      (kChiSquare95 * eigen.values).cwiseMax(0).cwiseSqrt();  // ascending
  return {semi_px[1] * eigen.vectors.col(1), semi_px[0] * eigen.vectors.col(0)};
}

double round_length(double v) {
  const double power = std::pow(10, std::floor(std::log10(v)));
  for (const double digit : {5.0, 2.0}) {
    if (digit * power <= v) return digit * power;
  }
  return power;
}

}  // namespace panelcal::internal
