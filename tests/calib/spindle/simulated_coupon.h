// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "calib/base/statistics/random.h"
#include "calib/base/units.h"
#include "calib/spindle/fit.h"
#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace panelcal::test {

/// A coupon whose truth is known: written from the machine's side (where things really are), not
/// from the equation that the fit solves.
struct SimulatedCoupon {
  int columns = 3;
  int rows = 3;
  double pitch_mm = 5;
  Eigen::Vector2d offset_mm = {80.25, -3.5};           ///< optical axis minus spindle
  Eigen::Vector2d guessed_offset_mm = {80.24, -3.51};  ///< with which the camera is sent to holes
  Eigen::Vector2d wander_um = {3, 3};
  double drill_stage_um = 0;  ///< repeatability of the stage when drilling
  double view_stage_um = 1;   ///< and when looking
  Eigen::Vector2d backlash_um = {0, 0};
  double detector_um = 0.3;
  Approach drilling = {1, 1};
  std::vector<Approach> looking = {{1, 1}, {1, 1}, {1, 1}, {1, 1}};
  double coupon_turn_rad = 0;  ///< about its middle, between drilling and looking
  /// Distance from the middle of the picture at which holes are looked at, in turn right, up, left,
  /// down.
  double off_middle_mm = 0;
  double camera_scale_error = 0;  ///< relative error of seen distances from the middle

  Eigen::Vector2d middle_mm() const {
    return {300 + 0.5 * pitch_mm * (columns - 1), 200 + 0.5 * pitch_mm * (rows - 1)};
  }
};

inline Eigen::Vector2d normal_2(Random& random) {
  const double x = random.normal();
  return {x, random.normal()};
}

/// True stop of a stage that is sent to a place.
inline Eigen::Vector2d stop_mm(const Eigen::Vector2d& command_mm,
                               const Approach& approach,
                               const Eigen::Vector2d& backlash_um,
                               double repeatability_um,
                               Random& random) {
  const Eigen::Vector2d towards(approach.x, approach.y);
  return command_mm +
         1e-3 * (repeatability_um * normal_2(random) - 0.5 * backlash_um.cwiseProduct(towards));
}

inline CouponHole drill_and_look(const SimulatedCoupon& coupon,
                                 const Eigen::Vector2d& command_mm,
                                 Random& random) {
  CouponHole hole;
  hole.drilled = position_mm<frame::Machine>(command_mm);
  hole.approach = coupon.drilling;
  Eigen::Vector2d hole_mm =
      stop_mm(command_mm, hole.approach, coupon.backlash_um, coupon.drill_stage_um, random) +
      1e-3 * coupon.wander_um.cwiseProduct(normal_2(random));
  const Eigen::Vector2d from_middle_mm = hole_mm - coupon.middle_mm();
  hole_mm += coupon.coupon_turn_rad * Eigen::Vector2d(-from_middle_mm.y(), from_middle_mm.x());
  int quarter = 0;
  for (const Approach& approach : coupon.looking) {
    const Eigen::Vector2d sides[] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    const Eigen::Vector2d aside_mm = coupon.off_middle_mm * sides[quarter++ % 4];
    const Eigen::Vector2d spindle_mm = command_mm - coupon.guessed_offset_mm - aside_mm;
    const Eigen::Vector2d axis_mm =
        coupon.offset_mm +
        stop_mm(spindle_mm, approach, coupon.backlash_um, coupon.view_stage_um, random);
    CouponView view;
    view.spindle = position_mm<frame::Machine>(spindle_mm);
    view.approach = approach;
    const Eigen::Vector2d seen_mm = (1 + coupon.camera_scale_error) * (hole_mm - axis_mm) +
                                    1e-3 * coupon.detector_um * normal_2(random);
    view.seen.position = position_mm<frame::Optical>(seen_mm);
    view.seen.cov = 1e-6 * coupon.detector_um * coupon.detector_um * Eigen::Matrix2d::Identity();
    hole.views.push_back(view);
  }
  return hole;
}

inline std::vector<CouponHole> simulate(const SimulatedCoupon& coupon, std::uint64_t seed) {
  Random random(seed);
  std::vector<CouponHole> holes;
  for (int row = 0; row < coupon.rows; ++row) {
    for (int column = 0; column < coupon.columns; ++column) {
      const Eigen::Vector2d command_mm(300 + coupon.pitch_mm * column, 200 + coupon.pitch_mm * row);
      holes.push_back(drill_and_look(coupon, command_mm, random));
    }
  }
  return holes;
}

/// A hole that is somewhere else than all looks at it say it should be.
inline void move_hole(CouponHole& hole, double x_um, double y_um) {
  for (CouponView& view : hole.views) {
    view.seen.position =
        view.seen.position + displacement_mm<frame::Optical>(1e-3 * x_um, 1e-3 * y_um);
  }
}

/// Squared error of an offset in its own sigmas; 2 on average if the covariance is right.
inline double squared_error(const SpindleCameraOffset& offset, const Eigen::Vector2d& truth_mm) {
  const Eigen::Vector2d error_mm = offset.offset.in_mm() - truth_mm;
  return error_mm.dot(offset.cov_mm2.llt().solve(error_mm));
}

}  // namespace panelcal::test
