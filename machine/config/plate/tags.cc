// SPDX-License-Identifier: Apache-2.0
#include "machine/config/plate/tags.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "vision/tag/family.h"
#include <Eigen/Geometry>

namespace panelcal {

const PlateTag* PlateTags::find(int id) const {
  const auto found = std::ranges::find(tags, id, &PlateTag::id);
  return found == tags.end() ? nullptr : &*found;
}

std::array<Position<frame::Plate>, 4> corners_of(const PlateTags& tags, const PlateTag& tag) {
  const Eigen::Rotation2Dd turn(tag.turn.in_rad());
  std::array<Position<frame::Plate>, 4> corners;
  const auto in_tag = tag_corners();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    // y is down in a tag's frame, up on the plate.
    const Eigen::Vector2d from_center(in_tag[i].x(), -in_tag[i].y());
    corners[i] = tag.center +
                 displacement_mm<frame::Plate>((tags.size.in_mm() * (turn * from_center)).eval());
  }
  return corners;
}

Length half_side_of(const PlateTags& tags) {
  const auto family = find_tag_family(tags.family);
  return 0.5 * family->n_cells / family->n_on_side * tags.size;
}

bool covers_dot(const PlateTag& tag, Length half_side, const PlateDot& dot) {
  const Eigen::Vector2d in_tag_mm =
      Eigen::Rotation2Dd(-tag.turn.in_rad()) * (dot.place - tag.center).in_mm();
  const Eigen::Vector2d beside_mm =
      (in_tag_mm.cwiseAbs().array() - half_side.in_mm()).max(0).matrix();
  return beside_mm.norm() <= dot.radius.in_mm();
}

}  // namespace panelcal
