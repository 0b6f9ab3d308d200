// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/interruption.h"
#include "calib/base/statistics/random.h"
#include "calib/base/units.h"
#include "calib/correction/spindle_camera.h"
#include "machine/config/machine_config.h"
#include "machine/config/settings/sim_options.h"
#include "machine/devices/calibration_devices.h"
#include "machine/devices/camera.h"
#include "machine/devices/spindle.h"
#include "machine/devices/stage.h"
#include "machine/sim/sim_eye.h"
#include "machine/sim/sim_motion.h"
#include "vision/fit/target.h"

namespace panelcal {

namespace internal {

/// The true spindle-camera offset of a virtual machine that was started some time ago.
SpindleCameraOffset sim_offset_at(Time since_start,
                                  const SpindleCameraOffset& warm,
                                  const SimCouponOptions& options);

}  // namespace internal

/// A virtual machine that drills holes and sees them: stage, spindle and camera over an empty
/// coupon, and perhaps a mark. What the camera sees are the mark and the holes that were drilled,
/// where they really are, through the true offset of [sim] spindle_camera_offset_mm, with the lamp
/// and at the height of the camera that were set, as far as [sim] says what these do. Its clock is
/// moved by `wait` alone.
class SimCoupon final : public Stage, public CameraDevice, public Spindle {
 public:
  /// Fails  config-value (no [sim] or no [camera]); vision-tool-undefined
  static Expected<SimCoupon> create(const MachineConfig& config, const SimCouponOptions& options);

  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    PANELCAL_CHECK(check_interruption());
    return motion_.move_to(spindle);
  }
  Expected<void> drill(int tool) override;
  Expected<Image> take() override;
  std::string name() const override { return "sim"; }
  // A machine.toml that states lamp and focus is obeyed, also where they change nothing.
  bool can_set(CameraSetting setting) const override { return setting != CameraSetting::Zoom; }
  Expected<void> set(CameraSetting setting, double value) override;

  /// See SimEye::look_through; the holes stay where they are.
  void look_through(const MachineConfig& config) { eye_.look_through(config); }

  void wait(Time time) { motion_.wait(time); }
  Time now() const { return motion_.now(); }
  /// All that a calibration needs, while this lives where it is.
  CalibrationDevices devices(Prompt prompt = {}) { return devices(*this, std::move(prompt)); }
  /// The same through another stage, that drives this one.
  CalibrationDevices devices(Stage& stage, Prompt prompt = {});

  /// As it is now; that of the warm machine is approached.
  SpindleCameraOffset true_offset() const;
  /// True places of holes.
  const std::vector<Position<frame::Machine>>& holes() const { return holes_; }

 private:
  SimCoupon(const MachineConfig& config,
            const SimCouponOptions& options,
            Target target,
            std::optional<Target> mark);

  SimCouponOptions options_;
  Target target_;
  std::optional<Target> mark_;
  SpindleCameraOffset warm_offset_;
  internal::SimMotion motion_;
  internal::SimEye eye_;
  Random drills_;
  std::vector<Position<frame::Machine>> holes_;
};

}  // namespace panelcal
