// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
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
#include "panelcal/machine/spindle.h"
#include "panelcal/machine/stage.h"
#include "panelcal/vision/render.h"
#include "panelcal/vision/target.h"

namespace panelcal {

/// A mark of another look than the others: a plate's tag.
struct SimOtherMark {
  Target target;
  Position<frame::Machine> place;
  Angle turn;  ///< on top of the target's own angle, the same way round
};

/// What a virtual table with marks on it is like, on top of [sim].
struct SimPlateOptions {
  std::uint64_t seed = 1;
  int vision_tool = 1;  ///< what the marks look like
  std::vector<Position<frame::Machine>> marks;
  std::vector<SimOtherMark> others;
  /// Where the stage really stands against where it was sent to; empty: there.
  std::function<Eigen::Vector2d(const Position<frame::Machine>&)> error_mm;
  Length stage_repeatability;  ///< of every stop, per axis
  /// After a move the stage swings along it: amplitude exp(-t / decay) cos(2 pi frequency t).
  Length swing;
  Time swing_decay = seconds(0.05);
  double swing_hz = 20;
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
  bool can_set(CameraSetting setting) const override;
  Expected<void> set(CameraSetting setting, double value) override;

  void wait(Time time) { now_ = now_ + time; }
  Time now() const { return now_; }

 private:
  SimPlate(const MachineConfig& config, SimPlateOptions options, Target target);
  Position<frame::Machine> standing() const;

  SimConfig sim_;
  SimPlateOptions options_;
  Target target_;
  CameraMapping calibrated_;
  Camera camera_;
  SpindleCameraOffset offset_;
  Random stops_;
  Random noise_;
  Time now_;
  Time arrived_;
  Position<frame::Machine> commanded_;
  Position<frame::Machine> rest_;  ///< where it comes to rest
  Eigen::Vector2d direction_ = Eigen::Vector2d::Zero();
  double focus_mm_ = 0;
  double lamp_ = 1;  ///< against the one that [sim] describes
};

}  // namespace panelcal
