// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "machine/devices/calibration_devices.h"

namespace panelcal {

/// For dry runs, which open no device.
class NoDevices final : public Stage, public Spindle, public CameraDevice {
 public:
  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& /*spindle*/) override {
    return failure(problem(Code::DeviceStage));
  }
  Expected<void> drill(int /*tool*/) override { return failure(problem(Code::DeviceStage)); }
  Expected<Image> take() override { return failure(problem(Code::DeviceFrame)); }
  std::string name() const override { return "dry run"; }
  bool can_set(CameraSetting /*setting*/) const override { return false; }
  Expected<void> set(CameraSetting /*setting*/, double /*value*/) override {
    return failure(problem(Code::NotSupported));
  }

  CalibrationDevices devices() { return {*this, *this, *this, {}, {}}; }

 private:
  static Diagnostic problem(Code code) {
    return {code, {"dry run", 0, 0}, "a dry run uses no device", ""};
  }
};

}  // namespace panelcal
