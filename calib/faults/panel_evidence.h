// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "calib/panel/fit.h"
#include "calib/panel/gates.h"
#include <Eigen/Core>

// The evidence for a story of what was measured, weighed against other stories: the marginal
// likelihood, in which a story pays for everything that it leaves open.
namespace panelcal::internal {

/// Prior standard deviations of a panel, before any measurement; 0: not at all.
struct PanelBelief {
  double offset_mm = 0;  ///< of the targets' centre, in x and in y
  double rotation_rad = 0;
  double scale = 0;       ///< of the mean of both scales
  double difference = 0;  ///< of half the difference of the scales
  double shear = 0;
};

/// Spread of healthy panels by the limits: a limit is two standard deviations. Without one a
/// wide one is taken. Stretch not of the model is believed to be 0.
PanelBelief belief_of(const GateLimits& limits, PanelModel model);

/// One target in a story: from where on the panel, seen where, and with which error.
struct ToldTarget {
  Eigen::Vector2d from_mm;
  Eigen::Vector2d to_mm;
  Eigen::Matrix2d cov_mm2;
  ObservedAxes axes = ObservedAxes::Both;
};

/// Pose of a panel that is not just a little off: to = turn (from) + shift, and on top of it what a
/// PanelBelief allows.
struct Lie {
  Eigen::Matrix2d turn = Eigen::Matrix2d::Identity();
  Eigen::Vector2d shift_mm = Eigen::Vector2d::Zero();
};

struct Evidence {
  double log_likelihood = 0;  ///< of all measurements, everything unknown integrated out
  Eigen::Matrix2d linear = Eigen::Matrix2d::Identity();  ///< the likeliest map
  Eigen::Vector2d translation_mm = Eigen::Vector2d::Zero();
};

/// Integrates the likelihood over the panel's map by Laplace's method, which is exact but for the
/// curvature of a rotation within its posterior:
///
///   to_i = c' + t + R(theta) [1 + e + d, k; 0, 1 + e - d] turn (from_i - c) + error_i
///   t, theta, e, d, k ~ N(0, belief^2),  c the targets' centre,  c' = turn c + shift
///
/// In     targets: 1 or more, covariances positive definite in the coordinates that count
/// Cost   O(n) per iteration, a few iterations; allocates nothing
/// Source MacKay 2003, chapters 27 and 28
/// See    tests/calib/faults/panel_evidence_test.cc
Evidence evidence(std::span<const ToldTarget> targets,
                  const PanelBelief& belief,
                  const Lie& lie = {});

}  // namespace panelcal::internal
