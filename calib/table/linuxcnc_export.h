// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "calib/correction/table_map.h"
#include <Eigen/Core>

namespace panelcal {

struct LinuxcncOptions {
  int points = 51;         ///< of each compensation file, 2 to 256 (LinuxCNC's own limit)
  bool in_inches = false;  ///< [TRAJ] LINEAR_UNITS of the machine
  /// Of each axis, as measured: a stage that comes from above stands so much higher than one that
  /// comes from below. The map is taken for the latter. LinuxCNC ignores BACKLASH beside a file.
  std::array<Length, 2> backlash;
};

/// The part of a table's error that LinuxCNC can correct.
///
/// The linear part goes to matrixkins, whose coefficients turn wanted into joint coordinates:
///
///   setp matrixkins.C_xx 0.999920006        one line a coefficient, in the HAL file, after the
///   line
///                                           KINEMATICS = matrixkins in [KINS] of the INI file
///
/// The rest of each axis along itself goes to COMP_FILE with COMP_FILE_TYPE = 0, in
/// [JOINT_0] and [JOINT_1]: a line a place, ascending,
///
///   nominal forward reverse                 where the joint stands when told nominal, having come
///                                           from below and from above; machine units
///
/// between which LinuxCNC interpolates, and beyond which it keeps the correction of the end. There
/// is no comment in it: at the first line that is no three numbers LinuxCNC stops reading.
///
/// Straightness beyond squareness and anything that depends on both axes it cannot be told;
/// `left_rms_mm` says how much that is.
struct LinuxcncCorrection {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  std::string hal;
  std::array<std::string, 2> comp_file;  ///< of joint 0 (x) and joint 1 (y)
  /// Over the map's rectangle with both in force, but for a shift of the whole.
  double left_rms_mm = 0;
  double left_largest_mm = 0;
};

/// Source LinuxCNC: matrixkins(9); INI configuration, [JOINT_n]; usrmotLoadComp
/// Fails  calibration-data (an option outside its range; a map that is not one to one)
/// See    tests/calib/table/linuxcnc_export_test.cc
Expected<LinuxcncCorrection> linuxcnc_correction(const TableMap& map,
                                                 const LinuxcncOptions& options);

}  // namespace panelcal
