// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/correction/spindle_camera.h"
#include "calib/correction/spindle_offsets.h"
#include "machine/calibrate/spindle/camera_run.h"
#include "machine/config/machine_config.h"
#include "program/model/calibration_order.h"
#include "program/model/measurement.h"

namespace panelcal {

/// The spindle-camera offsets while one job runs: as the machine's files have them, then as the
/// program's own orders to calibrate leave them. Nothing is written anywhere.
///
/// See    tests/machine/calibrate/spindle/job_calibration_test.cc
class JobCalibration {
 public:
  explicit JobCalibration(const MachineConfig& config);

  /// Of the spindle that drills ([spindle] number and station).
  const SpindleCameraOffset& offset() const { return config_.spindle_camera; }

  /// G39, $uvis,calib: drills into the coupon and looks. The camera's lamp and zoom are set
  /// already.
  ///
  /// Fails  as calibrate_spindle_camera; calibration-refused (the coupon turned or grew between
  ///        drilling and looking; the offset moved by more, or is less sure, than [nightly.gates]
  ///        change_um and sigma_um allow, or than their defaults where there are none);
  ///        config-value (a zoom without a calibration). Then the offset stays what it was.
  Expected<CalibrationAnswer> calibrate(const CalibrationOrder& order,
                                        const CalibrationDevices& devices);

  /// G39,SPOP and its kin: what was measured with the offsets as they were moves them. Orders that
  /// use the same measurement do not add up.
  ///
  /// Out    empty if no calibrated offset is meant
  /// Fails  calibration-refused (by the same limits as calibrate)
  /// Precondition: order.correction is set
  Expected<std::optional<CalibrationAnswer>> correct(const CalibrationOrder& order);

  /// The machine at the zoom of an order: [[camera.zoom]] has a calibration of its own.
  ///
  /// Fails  config-value
  Expected<MachineConfig> config_at(const CalibrationOrder& order) const;

  /// To be called for every measurement. One that was made with an offset of this job moves with
  /// the camera's calibration through the offset as well: an error of the axis cancels.
  ///
  /// Fails  command-misplaced (the offset was found at another zoom in this job: each zoom has an
  ///        axis of its own)
  Expected<Measurement> complete(Measurement measurement);

 private:
  Expected<void> check(const SpindleCameraOffset& offset,
                       const Displacement<frame::Machine>& shift,
                       const CalibrationOrder& order) const;

  MachineConfig config_;  ///< with the offset in force
  SpindleAt at_;
  SpindleOffsets offsets_;
  CameraJacobian by_camera_ = CameraJacobian::Zero();  ///< d offset / d camera parameters
  /// The last calibrate() that was not refused: the offset holds for its zoom only.
  std::optional<CalibrationOrder> calibrated_by_;
  SpindleOffsets measured_with_;
  CameraJacobian measured_by_camera_ = CameraJacobian::Zero();
  bool is_measured_with_ = true;  ///< the two above are those in force
};

}  // namespace panelcal
