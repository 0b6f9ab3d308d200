// SPDX-License-Identifier: Apache-2.0
#include "program/model/placement.h"

#include <array>
#include <cstddef>

namespace panelcal {

Eigen::Matrix2d copy_orientation(const CopyRun& run) {
  const double x_sign = run.mirror_x ? -1 : 1;
  const double y_sign = run.mirror_y ? -1 : 1;
  Eigen::Matrix2d orientation;
  if (run.swap_axes) {
    orientation << 0, y_sign, x_sign, 0;
  } else {
    orientation << x_sign, 0, 0, y_sign;
  }
  return orientation;
}

Eigen::Matrix2d axis_orientation(int version) {
  struct Axes {
    double xx, xy, yx, yy;  // the columns: where +x and +y point
  };
  constexpr std::array<Axes, 8> kAxes = {{{1, 0, 0, 1},
                                          {0, 1, 1, 0},
                                          {0, 1, -1, 0},
                                          {-1, 0, 0, 1},
                                          {0, -1, -1, 0},
                                          {-1, 0, 0, -1},
                                          {1, 0, 0, -1},
                                          {0, -1, 1, 0}}};
  const Axes& axes = kAxes[static_cast<std::size_t>(version - 1)];
  Eigen::Matrix2d orientation;
  orientation << axes.xx, axes.yx, axes.xy, axes.yy;
  return orientation;
}

}  // namespace panelcal
