// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "calib/base/frames.h"
#include "calib/base/machine_uncertainty.h"
#include "calib/correction/spindle_camera.h"
#include "calib/correction/spindle_offsets.h"
#include "program/model/pattern_file.h"
#include "program/model/placement.h"
#include <Eigen/Core>

namespace panelcal {

/// A deviation that the program has measured and stores as a correction of offsets.
struct OffsetCorrection {
  OffsetOrder order;
  /// Measured minus where the measured holes were drilled.
  Displacement<frame::Machine> deviation;
  Eigen::Matrix2d cov_mm2 = Eigen::Matrix2d::Zero();  ///< without the camera's calibration
  CameraJacobian by_camera = CameraJacobian::Zero();  ///< d deviation / d camera parameters
};

/// The order of a program to calibrate between its measurements: the spindle-camera offset.
struct CalibrationOrder {
  std::int64_t number = 0;  ///< from 0, in the order of execution
  int line = 0;
  std::string file;         ///< of a stored pattern or subprogram; empty: the program itself
  std::string file_sha256;  ///< of that file's bytes; empty: not known
  std::string command;      ///< G39, $uvis,calib, or G39,SPOP and its kin
  InstancePath path;
  /// G39X#Y#: where the first of the coupon's holes is drilled. Absent: the coupon's next free rows
  /// are.
  std::optional<Position<frame::Machine>> first_hole;
  /// G39,SPOP..: nothing is drilled.
  std::optional<OffsetCorrection> correction;
  std::optional<double> lamp;  ///< $uvis,lamp, as written
  std::optional<double> zoom;  ///< $uvis,zoom, as written

  PatternFile pattern() const& { return {file, file_sha256}; }
  PatternFile pattern() const&& = delete;  // it views this
};

/// The answer to an order. It counts for this job: nothing is installed.
struct CalibrationAnswer {
  CalibrationOrder order;
  /// The offset of measurements from now on. Absent: the offset of the spindle that drills stays
  /// (of another one it was calibrated).
  std::optional<SpindleCameraOffset> offset;
  std::string text;  ///< one line for people
  /// The first measurement that is made with it: index into Survey::measurements.
  std::size_t i_measurement = 0;
  /// The last one of the job that moved the offset, up to this one: index into
  /// Survey::calibrations.
  std::optional<std::size_t> i_in_force;
};

/// One JSON object, without a line end, in the format of docs/formats/measurements.md.
std::string to_json(const CalibrationOrder& order);
std::string to_json(const CalibrationAnswer& answer);

/// "calibration 0 (G39, line 7)", for diagnostics.
std::string describe(const CalibrationOrder& order);

}  // namespace panelcal
