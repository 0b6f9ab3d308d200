// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/kinds/coupon_scatter.h"

#include <algorithm>

namespace panelcal {
namespace {

/// By how much the stage's backlash moves a look's result from that of the drill.
Eigen::Vector2d backlash_mm(const SpindleCameraFit& fit,
                            const Approach& drilling,
                            const Approach& looking) {
  return {0.5 * fit.backlash[0].value.in_mm() * (drilling.x - looking.x),
          0.5 * fit.backlash[1].value.in_mm() * (drilling.y - looking.y)};
}

/// Sum of squares of a hole's looks about their mean.
double squares_of(const SpindleCameraFit& fit, const CouponHole& hole) {
  std::vector<Eigen::Vector2d> found_mm;
  Eigen::Vector2d sum_mm = Eigen::Vector2d::Zero();
  for (const CouponView& view : hole.views) {
    found_mm.emplace_back((hole.drilled - view.spindle).in_mm() - view.seen.position.in_mm() -
                          backlash_mm(fit, hole.approach, view.approach));
    sum_mm += found_mm.back();
  }
  const Eigen::Vector2d mean_mm = sum_mm / static_cast<double>(found_mm.size());
  double squares = 0;
  for (const Eigen::Vector2d& found : found_mm) squares += (found - mean_mm).squaredNorm();
  return squares;
}

}  // namespace

std::vector<NightSpread> coupon_scatter(const SpindleCameraRun& run) {
  const SpindleCameraFit& fit = run.fit;
  double of_holes = 0;
  double of_looks = 0;
  int n_holes = 0;
  int n_looks = 0;
  const std::size_t n = std::min(fit.holes.size(), run.sights.holes.size());
  for (std::size_t i = 0; i < n; ++i) {
    if (fit.holes[i].is_outlier || run.sights.holes[i].views.empty()) continue;
    ++n_holes;
    n_looks += static_cast<int>(run.sights.holes[i].views.size());
    of_holes += fit.holes[i].residual.in_mm().squaredNorm();
    of_looks += squares_of(fit, run.sights.holes[i]);
  }
  std::vector<NightSpread> out;
  const int free_holes = 2 * (n_holes - 1);
  if (free_holes > 0) {
    out.push_back({"holes about the fit", "mm", of_holes / free_holes, double(free_holes)});
  }
  const auto n_backlash =
      static_cast<int>(std::ranges::count_if(fit.backlash, &BacklashEstimate::is_determined));
  const int free_looks = 2 * (n_looks - n_holes) - n_backlash;
  if (free_looks > 0) {
    out.push_back({"looks at a hole", "mm", of_looks / free_looks, double(free_looks)});
  }
  return out;
}

std::vector<NightHole> coupon_holes(const SpindleCameraRun& run) {
  std::vector<NightHole> out;
  const std::size_t n = std::min(run.fit.holes.size(), run.sights.holes.size());
  for (std::size_t i = 0; i < n; ++i) {
    out.push_back({run.sights.holes[i].drilled.in_mm(),
                   run.fit.holes[i].residual.in_mm(),
                   run.fit.holes[i].is_outlier});
  }
  return out;
}

}  // namespace panelcal
