// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/base/statistics/random.h"
#include <Eigen/Core>

#include "tests/vision/tag/trial.h"

namespace panelcal::test {

/// An opaque patch on or beside a tag: a rectangle, or the ellipse in it.
struct Patch {
  Eigen::Vector2d center_px;
  Eigen::Vector2d half_px;
  double angle_rad = 0;
  double level = 0;  ///< of 255
  bool is_round = false;
};

enum class DirtPlace { Area, Rim };

/// Blobs of 3 to 12 px on a part of the tag's face or of its outline, and scratches across it.
///
/// In     scene: posed; part: covered share of the corners' square, or of its outline
std::vector<Patch> draw_dirt(
    const TagScene& scene, DirtPlace place, double part, int n_scratches, Random& random);

/// Marks 6 to 20 px from the tag's outermost cells.
std::vector<Patch> draw_tag_neighbours(const TagScene& scene, int n, Random& random);

/// Paints patches over a picture's levels, edges blurred by the scene's lens.
void paint(const TagScene& scene, const std::vector<Patch>& patches, std::vector<double>& levels);

}  // namespace panelcal::test
