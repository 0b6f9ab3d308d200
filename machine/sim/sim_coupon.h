// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "panelcal/calib/base/expected.h"
#include "panelcal/calib/base/frames.h"
#include "panelcal/calib/base/random.h"
#include "panelcal/calib/base/units.h"
#include "panelcal/calib/spindle_camera.h"
#include "panelcal/machine/camera.h"
#include "panelcal/machine/machine_config.h"
#include "panelcal/machine/sim/sim_coupon_options.h"
#include "panelcal/machine/spindle.h"
#include "panelcal/machine/stage.h"
#include "panelcal/vision/render.h"
#include "panelcal/vision/target.h"

namespace panelcal {

/// A virtual machine that drills holes and sees them: stage, spindle and camera over an empty
/// coupon. What the camera sees are the holes that were drilled, where they really are, through the
/// true offset of [sim] spindle_camera_offset_mm.
class SimCoupon final : public Stage, public CameraDevice, public Spindle {
 public:
  /// Fails  config-value (no [sim] or no [camera]); vision-tool-undefined
  static Expected<SimCoupon> create(const MachineConfig& config, const SimCouponOptions& options);

  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override;
  Expected<void> drill(int tool) override;
  Expected<Image> take() override;
  std::string name() const override { return "sim"; }
  // Holes look the same in any light and at any height of the camera.
  bool can_set(CameraSetting setting) const override { return setting != CameraSetting::Zoom; }
  Expected<void> set(CameraSetting setting, double value) override {
    return can_set(setting) ? Expected<void>() : Stage::set(setting, value);
  }

  SpindleCameraOffset true_offset() const { return offset_; }
  /// Where holes really are.
  const std::vector<Position<frame::Machine>>& holes() const { return holes_; }

 private:
  SimCoupon(const MachineConfig& config, const SimCouponOptions& options, Target target);

  SimConfig sim_;
  SimCouponOptions options_;
  Target target_;
  CameraMapping calibrated_;
  Camera camera_;
  SpindleCameraOffset offset_;
  Random stops_;
  Random drills_;
  Random noise_;
  Position<frame::Machine> commanded_;
  Eigen::Vector2d direction_ = Eigen::Vector2d::Zero();  ///< of the last move, per axis
  Position<frame::Machine> standing_;                    ///< really
  std::vector<Position<frame::Machine>> holes_;
};

}  // namespace panelcal
