// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/correction/spindle_camera.h"
#include "machine/config/machine_config.h"
#include "machine/devices/camera.h"
#include "machine/devices/spindle.h"
#include "machine/devices/stage.h"
#include "machine/sim/sim_eye.h"
#include "machine/sim/sim_motion.h"
#include "vision/fit/target.h"
#include <Eigen/Core>

namespace panelcal {

/// A mark of another look than the others: a plate's tag.
struct SimOtherMark {
  Target target;
  Position<frame::Machine> place;
  Angle turn;  ///< on top of the target's own angle, the same way round
};

/// The properties of a virtual table with marks on it, on top of [sim].
struct SimPlateOptions : SimStops {
  std::uint64_t seed = 1;
  int vision_tool = 1;  ///< describes the marks
  std::vector<Position<frame::Machine>> marks;
  std::vector<SimOtherMark> others;
  /// True place of the stage minus the commanded one; empty: 0.
  std::function<Eigen::Vector2d(const Position<frame::Machine>&)> error_mm;
};

/// A virtual machine over marks that are fixed to its table. It has a lamp and a focus axis where
/// [sim] says what they do, cannot drill, and has a clock that only `wait` moves.
class SimPlate final : public Stage, public CameraDevice, public Spindle {
 public:
  /// Fails  config-value (no [sim] or no [camera]); vision-tool-undefined
  static Expected<SimPlate> create(const MachineConfig& config, SimPlateOptions options);

  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override;
  Expected<void> drill(int tool) override;
  Expected<Image> take() override;
  std::string name() const override { return "sim"; }
  bool can_set(CameraSetting setting) const override { return eye_.has(setting); }
  Expected<void> set(CameraSetting setting, double value) override;

  void wait(Time time) { motion_.wait(time); }
  Time now() const { return motion_.now(); }

 private:
  SimPlate(const MachineConfig& config, SimPlateOptions options, Target target);

  SimPlateOptions options_;
  Target target_;
  SpindleCameraOffset offset_;
  internal::SimMotion motion_;
  internal::SimEye eye_;
};

}  // namespace panelcal
