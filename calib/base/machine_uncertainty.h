// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <iterator>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "calib/base/units.h"
#include <Eigen/Core>

namespace panelcal {

/// Of [scale mm/px, rotation rad, axis x px, axis y px, k1 1/px^2], the parameters of a camera
/// calibration.
using CameraCovariance = Eigen::Matrix<double, 5, 5>;
/// d measured place (mm) / d camera parameters, in the same order.
using CameraJacobian = Eigen::Matrix<double, 2, 5>;

/// The uncertainty of a spindle-camera offset, mm^2.
struct OffsetUncertainty {
  Eigen::Matrix2d calibrated_mm2 = Eigen::Matrix2d::Zero();  ///< of the offset as calibrated
  Eigen::Matrix2d drift_mm2 = Eigen::Matrix2d::Zero();       ///< of the offset since then
};

/// The error that one machine adds to places, as [uncertainty], [spindle] and [camera] name it.
/// All lengths are standard deviations along each axis.
///
///   target: measured = true + stage + table + camera (shared) + offset (shared) + detector
///   hole:   drilled  = commanded + rounding + stage + table + wander
///
/// The error that a [table] calibration leaves is smooth, so that neighbouring places err alike;
/// here it is counted as if it were drawn anew at every target and every hole, like the rest of
/// `table`. What a hole and the targets beside it have in common would cancel, so there sigma is
/// too large, by up to all of this part. The camera stands by the spindle-camera offset beside the
/// hole when it sees its target, so that even a hole at its own target cannot count on it. Targets
/// that lie close together err alike and far from their holes, and averaging them helps less than
/// is counted here: there this part's sigma is too small, by a factor of sqrt(2) at most.
///
/// "Shared" errors are the same for all targets and holes of a job and are never averaged; the
/// others are drawn anew at every place. A shared error of the offset moves every measured place,
/// and so every corrected hole, alike.
/// See    docs/formulation.md, From the pixel to the hole
struct MachineUncertainty {
  Length stage_repeatability;  ///< of every arrival
  Length table_residual;       ///< error of the table beyond its smooth map
  Length table_map;            ///< of a place on a calibrated table ([table] calibration)
  Length drill_wander;         ///< of the drill's tip against its spindle
  Length depth;                ///< of a stroke's depth: the tool's length, the axis, the foot
  Length output_rounding;      ///< of a coordinate in a written program, by its last digit
  /// The machine's file states the term, be it as zero. They are the largest ones of most machines.
  bool states_stage = false;
  bool states_table = false;
  bool states_wander = false;
  Eigen::Matrix2d spindle_camera_mm2 = Eigen::Matrix2d::Zero();  ///< of the offset as calibrated
  Eigen::Matrix2d drift_mm2 = Eigen::Matrix2d::Zero();           ///< of the offset since then
  CameraCovariance camera = CameraCovariance::Zero();
  /// Of the calibrations of [[camera.zoom]], whose errors are their own.
  std::map<double, CameraCovariance> zooms;

  /// Cameras are counted: 0 for [camera], then the zooms by their level. A zoom that has no
  /// calibration (recorded measurements) counts as the camera.
  int camera_index(const std::optional<double>& zoom) const {
    const auto found = zoom ? zooms.find(*zoom) : zooms.end();
    if (found == zooms.end()) return 0;
    return 1 + static_cast<int>(std::distance(zooms.begin(), found));
  }
  int n_cameras() const { return 1 + static_cast<int>(zooms.size()); }
  /// Precondition: 0 <= i_camera < n_cameras().
  const CameraCovariance& camera_of(int i_camera) const {
    return i_camera == 0 ? camera : std::next(zooms.begin(), i_camera - 1)->second;
  }

  /// Of stage, table and drill: the terms that are neither above zero nor stated as zero. Without
  /// them sigma is that of the fits only, and no risk follows from it.
  std::vector<std::string_view> unstated() const {
    std::vector<std::string_view> out;
    const Length none;
    if (!states_stage && !(stage_repeatability > none)) out.push_back("stage repeatability");
    if (!states_table && !(table_residual > none) && !(table_map > none)) {
      out.push_back("table residual");
    }
    if (!states_wander && !(drill_wander > none)) out.push_back("drill wander");
    return out;
  }

  OffsetUncertainty offset() const { return {spindle_camera_mm2, drift_mm2}; }
  void set_offset(const OffsetUncertainty& offset) {
    spindle_camera_mm2 = offset.calibrated_mm2;
    drift_mm2 = offset.drift_mm2;
  }

  Eigen::Matrix2d stage_mm2() const { return isotropic(stage_repeatability); }
  Eigen::Matrix2d residual_mm2() const { return isotropic(table_residual); }
  Eigen::Matrix2d map_mm2() const { return isotropic(table_map); }
  Eigen::Matrix2d table_mm2() const { return residual_mm2() + map_mm2(); }
  Eigen::Matrix2d wander_mm2() const { return isotropic(drill_wander); }
  Eigen::Matrix2d rounding_mm2() const { return isotropic(output_rounding); }
  /// Of one target on top of what the picture says. Layers of one target lie side by side: the
  /// table is as wrong at one as at the next.
  Eigen::Matrix2d of_target_mm2(int n_arrivals = 1) const {
    return stage_mm2() / n_arrivals + table_mm2();
  }
  /// Of every hole alike: no further target makes it smaller.
  Eigen::Matrix2d shared_mm2() const { return spindle_camera_mm2 + drift_mm2; }
  /// Of one hole by itself.
  Eigen::Matrix2d of_hole_mm2() const {
    return stage_mm2() + table_mm2() + wander_mm2() + rounding_mm2();
  }

 private:
  static Eigen::Matrix2d isotropic(Length sigma) {
    return sigma.in_mm() * sigma.in_mm() * Eigen::Matrix2d::Identity();
  }
};

}  // namespace panelcal
