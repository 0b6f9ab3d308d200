// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/round/model/window.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The band along a rim, unrolled: grey levels by ring (distance from the rim) and by sector.
///
/// Every pixel is shared out linearly among its two rings and two sectors; a cell holds the mean.
struct RimStrip {
  Eigen::ArrayXXf mean;  ///< rings x sectors, grey levels
  /// Pixels in a cell of a ring, on average.
  Eigen::ArrayXd mass;
  double first_px = 0;  ///< of ring 0: distance from the rim, inwards; rings are 1 px apart
  double unit = 1;      ///< fit frame units per px
  double seen = 1;      ///< part of the cells that hold a pixel
  /// Edges beside the rim's that the rings show too: distance from the rim, inwards.
  std::vector<double> others_px;

  Eigen::Index n_rings() const { return mean.rows(); }
  Eigen::Index n_sectors() const { return mean.cols(); }
  double at_px(Eigen::Index ring) const { return first_px + static_cast<double>(ring); }
  double angle_rad(Eigen::Index sector) const;
};

/// In     window: collected about the parameters, at least `reach_px` to either side; inner_px: how
///        far the strip goes inwards; n_sectors: as an earlier strip has them, or 0: sectors of
///        about 2 px of arc, 24 to 256 of them; shape: empty, or by sector how far the rim lies
///        outside of the circle, px: rings follow it
RimStrip unroll(const RimWindow& window,
                const RimVector& parameters,
                double outer_px,
                double inner_px,
                Eigen::Index n_sectors = 0,
                const Eigen::VectorXd& shape = {});

/// The median of each ring, or of the sectors that `use` marks.
///
/// In     use: empty, or as many as there are sectors
Eigen::ArrayXd ring_medians(const RimStrip& strip, const std::vector<char>& use);

/// Leaves of a strip the edge that lies nearest to a place and at most one more on either side.
/// Another edge begins as soon as the slope of the levels has fallen and rises again; a slope that
/// does not fall again is shading, which ends the strip.
///
/// In     at_px: place across the strip; near_px: how far off the edge may be, as a sigma, which
///        weighs slopes; sign: of the inside's level less the outside's
/// Out    medians, strip: the rings of these edges, and where the others are
/// See    tests/vision/round/profile/strip_test.cc
void keep_nearest_edge(
    double at_px, double near_px, double sign, Eigen::ArrayXd& medians, RimStrip& strip);

}  // namespace panelcal::internal
