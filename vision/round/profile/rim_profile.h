// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "vision/round/model/model.h"
#include "vision/round/model/window.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// Area to search for a rim, and criteria of one.
struct RimSearch {
  RimVector start = RimVector::Zero();  ///< center, radius, sigma
  double sign = 1;                      ///< of the inside's level less the outside's
  double outer_px = 20;                 ///< distance from the rim to search, outwards and inwards
  double inner_px = 20;
  double least_contrast = 1;  ///< grey levels
  double least_used = 0.5;    ///< of the rim
  /// Of the radius, as a sigma: a rim that is this far from round is taken as a whole, and the band
  /// follows its shape. Beyond, and with 0, an arc that lies off the rest is something else.
  double own_shape = 0;
  /// The rim is the edge nearest to this radius, fit frame units, whatever others there are; 0: the
  /// one that dominates.
  double ring_radius = 0;
  double ring_px = 0;  ///< its distance from there, as a sigma
  double far = 0.2;    ///< of the start's radius: a rim or a center farther off is another one's
};

/// A rim measured sector by sector.
struct RimProfile {
  RimVector parameters = RimVector::Zero();  ///< of center, radius, sigma, levels and oval
  Eigen::Matrix2d center_cov = Eigen::Matrix2d::Zero();  ///< fit frame units squared
  double used = 0;         ///< part of the rim that lies on the circle
  double arc = 0;          ///< that tells as much of the center as this part
  double oval_sigma = 0;   ///< of each component of the oval, by noise and roughness
  double correlation = 0;  ///< of the band and a step, camera noise aside
  double roughness = 0;    ///< rms of the rim's deviations from round, of the radius
  int n_lobes = 0;         ///< of a rim that is one wave around the circle: a polygon's
  double lobes = 0;        ///< their amplitude, of the radius
  double noise = 0;        ///< sigma of a pixel about the step, grey levels
  bool is_settled = false;
};

/// Measures a rim on anything that is not flat: textured board, grain, shading, tracks, debris.
///
/// The band along the rim is unrolled; one linear filter that is blind to each sector's own levels
/// gives its deviation; a circle is fitted to the sectors that agree; the waves that these still
/// show around the rim tell how far its shape may have moved it.
///
/// Out    empty if there is no step of that sign all around
/// Cost   about 0.2 ms a pass for a radius of 40 px, two or three passes
/// See    tests/vision/round/profile/rim_profile_test.cc; docs/formulation.md, Locating
std::optional<RimProfile> measure_rim(RimWindow& window, const RimSearch& search);

}  // namespace panelcal::internal
