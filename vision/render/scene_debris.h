// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/base/statistics/random.h"
#include "calib/base/units.h"
#include "vision/render/scene.h"

namespace panelcal {

/// Dirt and scratches on a mark.
struct DebrisOptions {
  double rim_share = 0;  ///< of the mark's outline that is covered, 0 to 0.95
  Length size = um(80);  ///< of crumbs; single ones have half to one and a half times as much
  double darkest = 0;    ///< brightness of crumbs and scratches, 0 to 1 of full scale
  double brightest = 1;
  int scratches = 0;  ///< straight lines across or near the mark
  Length scratch_width = um(15);
  Length scratch_length = mm(1);  ///< a half to one and a half times as much
};

/// Things that cover a mark.
struct Debris {
  std::vector<Feature> features;
  double rim_share = 0;  ///< of the mark's outline that crumbs cover
};

/// Strews opaque crumbs of irregular outline on the outline of a mark, and scratches about it.
///
/// The last crumb is made as large as it takes to cover just the share asked for. What pixels are
/// touched tells touched_pixels() of vision/render/render.h.
///
/// In     mark: all of its features; none have a rim too long for crumbs of this size (1000 times)
/// Out    debris to paint behind the mark in the list; fewer crumbs if they cannot cover so much
/// See    tests/vision/render/scene_debris_test.cc
Debris strew_debris(const std::vector<Feature>& mark, const DebrisOptions& options, Random& random);

}  // namespace panelcal
