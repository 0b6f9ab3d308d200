// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace panelcal::internal {

/// A step beside the one of interest, as blurred as that one.
struct OtherStep {
  double at_px = 0;
  double height = 0;  ///< the change of level beyond it, grey levels
};

/// A step from surroundings to target as a function of the distance inwards:
///
///   (outside + outside_slope x) (1 - s) + (inside + inside_slope x) s,   s = Phi((x - at) / sigma)
///
/// and, beyond each of the others on its own side, its height times its own Phi.
struct StepProfile {
  double at_px = 0;
  double sigma_px = 1;
  double outside = 0;  ///< grey levels, as is inside
  double outside_slope = 0;
  double inside = 0;
  double inside_slope = 0;
  std::vector<OtherStep> others;

  double share(double x_px) const;
  double level(double x_px) const;
  /// Of the step alone, per px: the levels' own slopes left out.
  double steepness(double x_px) const;
  /// The part of another step's height that is reached there, and its derivative by that step's
  /// place, 1/px.
  double other_share(const OtherStep& other, double x_px) const;
  double other_steepness(const OtherStep& other, double x_px) const;
  double contrast() const { return inside - outside; }
};

/// Fits it to levels 1 px apart, from `first_px` on; empty if no step is there.
///
/// In     start: at_px, sigma_px, the others' places
std::optional<StepProfile> fit_step(const Eigen::ArrayXd& levels,
                                    double first_px,
                                    const StepProfile& start);

}  // namespace panelcal::internal
