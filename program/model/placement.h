// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/base/frames.h"

namespace panelcal {

/// Carries a programmed coordinate to its place in one step-and-repeat instance.
using Placement = Transform<frame::Nominal, frame::Programmed>;

/// One instance: a 0-based index per level, outermost first; empty outside step and repeat.
using InstancePath = std::vector<int>;

/// A run of equally spaced copies of everything a level has produced so far.
struct CopyRun {
  int count = 1;
  Displacement<frame::Programmed> step;  ///< from one copy to the next, added up unmirrored
  bool mirror_x = false;                 ///< M80: x -> -x
  bool mirror_y = false;                 ///< M90: y -> -y
  bool swap_axes = false;                ///< M70: x <-> y
  bool restarts = false;                 ///< offsets count from zero again (a bare M02 came before)
};

/// The linear part of a copy: mirrors first, the swap after them, about work zero.
Eigen::Matrix2d copy_orientation(const CopyRun& run);

/// Carries coordinates written in axis version 1 to 8 to version 1, x right and y up. Where the
/// program's +x and +y point: 1 right, up; 2 up, right; 3 up, left; 4 left, up; 5 down, left;
/// 6 left, down; 7 right, down; 8 down, right. Versions 2, 4, 5 and 7 mirror.
///
/// Precondition: 1 <= version <= 8
/// Source docs/decisions, axis versions
Eigen::Matrix2d axis_orientation(int version);

}  // namespace panelcal
