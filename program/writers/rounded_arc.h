// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "calib/base/plane_vectors.h"
#include "calib/base/units.h"
#include <Eigen/Core>

namespace panelcal {

/// The centre of an arc between ends that were rounded, mm: the place nearest to `center_mm` that
/// is equally far from both. Its own rounding then changes the radius by at most twice half a
/// step's diagonal from one end to the other, which readers take for rounding.
///
/// In     ends apart; where they are one, the centre stays
/// See    tests/program/writers/strict_digits_test.cc
inline Eigen::Vector2d center_of_rounded(const Eigen::Vector2d& from_mm,
                                         const Eigen::Vector2d& to_mm,
                                         const Eigen::Vector2d& center_mm) {
  const Eigen::Vector2d chord_mm = to_mm - from_mm;
  if (!(chord_mm.norm() > 0)) return center_mm;
  const Eigen::Vector2d along = chord_mm.normalized();
  const Eigen::Vector2d middle_mm = from_mm + 0.5 * chord_mm;
  return center_mm - along * along.dot(center_mm - middle_mm);
}

/// The place, mm, that a control reads whose axes and steps are those of the written numbers.
inline Eigen::Vector2d on_grid(const Eigen::Vector2d& at_mm,
                               const Eigen::Matrix2d& written_from_work,
                               Length step) {
  const Eigen::Vector2d steps = written_from_work * at_mm / step.in_mm();
  return written_from_work.transpose() * steps.array().round().matrix() * step.in_mm();
}

/// From the centre to the start of an arc, rounded to steps: the nearest such place that makes no
/// more than half a turn of it, which the rounding of half a circle could.
///
/// In     start_mm, end_mm: on the grid; is_clockwise: in the frame of these places
/// Source CNC-7 manual, Arc Center Offset: arcs of up to 180 degrees
inline Eigen::Vector2d half_turn_on_grid(const Eigen::Vector2d& start_mm,
                                         const Eigen::Vector2d& end_mm,
                                         const Eigen::Vector2d& center_mm,
                                         bool is_clockwise,
                                         const Eigen::Matrix2d& written_from_work,
                                         Length step) {
  constexpr double kHalfTurn_mm2 = 1e-9;  // of numbers on a grid: what doubles lose
  const Eigen::Vector2d exact_mm = start_mm - center_mm;
  const Eigen::Vector2d rounded_mm = on_grid(exact_mm, written_from_work, step);
  Eigen::Vector2d best_mm = rounded_mm;
  double least_mm2 = INFINITY;
  for (const int i : {0, -1, 1}) {
    for (const int j : {0, -1, 1}) {
      const Eigen::Vector2d offset_mm = rounded_mm + step.in_mm() * Eigen::Vector2d(i, j);
      const Eigen::Vector2d to_end_mm = end_mm - start_mm + offset_mm;
      const double cross_mm2 = internal::cross(offset_mm, to_end_mm);
      if ((is_clockwise ? -cross_mm2 : cross_mm2) < -kHalfTurn_mm2) continue;
      const double off_mm2 = (offset_mm - exact_mm).squaredNorm();
      if (off_mm2 >= least_mm2) continue;
      least_mm2 = off_mm2;
      best_mm = offset_mm;
    }
  }
  return best_mm;
}

/// An arc that bulges by less than a step, so that its rounded ends may lie anywhere on a circle.
inline bool is_flat(const Eigen::Vector2d& from_mm,
                    const Eigen::Vector2d& to_mm,
                    const Eigen::Vector2d& center_mm,
                    Length step) {
  const double radius_mm = (from_mm - center_mm).norm();
  const double bulge_mm = (to_mm - from_mm).squaredNorm() / (8 * radius_mm);  // at least
  return !(bulge_mm > step.in_mm());
}

}  // namespace panelcal
