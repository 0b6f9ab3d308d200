// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/placement.h"

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

}  // namespace panelcal
