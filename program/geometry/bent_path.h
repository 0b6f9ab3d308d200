// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "program/geometry/arcs.h"
#include <Eigen/Core>

namespace panelcal {

/// A piece of a path before and after it was bent.
struct BentPiece {
  Eigen::Vector2d end_mm;  ///< on the path
  double share = 1;        ///< of the path up to there
  Arc image;
};

/// The image of a line or an arc under any smooth map, as lines or arcs.
///
/// The path is cut into as many equal pieces as it takes until every image is within tolerance_mm
/// of the chord (of a line) or of the circle through its ends and its middle (of an arc), by
/// sampling: seven places a piece, at least one for every 2 mm of a path up to 16 m.
///
/// In     path: straight, or an arc of at most half a turn; map: smooth at the scale of 2 mm
/// Out    1 to 4096 pieces; they begin and end at images of the path and chain exactly. An arc's
///        pieces are straight where their sagitta is below 1e-9 mm
/// Fails  never. A path or an image that is not finite gives one straight piece. At 4096 pieces
///        cutting ends whatever the tolerance.
/// See    tests/program/geometry/bent_path_test.cc
std::vector<BentPiece> carry_bent(const Arc& path,
                                  const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& map,
                                  double tolerance_mm);

}  // namespace panelcal
