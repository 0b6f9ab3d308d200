// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "calib/base/expected.h"
#include "machine/calibrate/spindle/calibration.h"
#include "machine/calibrate/spindle/job_calibration.h"
#include "machine/config/machine_config.h"
#include "machine/devices/spindle.h"
#include "machine/look/camera_views.h"
#include "machine/look/vision_procedure.h"
#include "program/model/measurement.h"

namespace panelcal {

/// A machine with a camera: looks at the panel, and calibrates its offset where the program asks
/// for it.
class LiveSource final : public MeasurementSource {
 public:
  /// In     views: camera and stage; prompt: asked where the coupon takes entry material
  /// Fails  config-value (no [camera])
  static Expected<LiveSource> create(const MachineConfig& config,
                                     std::unique_ptr<CameraViews> views,
                                     std::unique_ptr<Spindle> spindle,
                                     Prompt prompt = {},
                                     PictureObserver observer = {});

  /// For the ledger, if calibrations take rows of the coupon.
  void set_taken_by(TakenBy by) { taken_by_ = std::move(by); }

  Expected<Measurement> measure(const MeasurementRequest& request) override;
  Expected<std::optional<FocusResult>> focus(const MeasurementRequest& request) override {
    return procedure_.focus(request, *views_);
  }
  /// Empty as well where the spindle cannot drill.
  Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order) override;

 private:
  LiveSource(const MachineConfig& config,
             VisionProcedure procedure,
             std::unique_ptr<CameraViews> views,
             std::unique_ptr<Spindle> spindle,
             Prompt prompt);

  VisionProcedure procedure_;
  std::unique_ptr<CameraViews> views_;
  std::unique_ptr<Spindle> spindle_;
  Prompt prompt_;
  JobCalibration job_;
  TakenBy taken_by_;
};

}  // namespace panelcal
