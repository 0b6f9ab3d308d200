// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/units.h"
#include "machine/devices/camera.h"

namespace panelcal {

/// A camera on the wire that may be away for a while: a switch that starts anew, a cable that is
/// touched. What fails in the device is tried again with the camera opened anew and set as before,
/// until its patience ends; then the last error stands.
///
/// See    tests/machine/devices/cameras/patient_camera_test.cc
class PatientCamera final : public CameraDevice {
 public:
  using Open = std::function<Expected<std::unique_ptr<CameraDevice>>()>;
  using Wait = std::function<void(Time)>;

  /// Opens the camera, at once or not at all: a wrong address is no camera that is away.
  ///
  /// In     wait: as sleep_for(); from one try to the next
  /// Fails  what `open` reports
  static Expected<std::unique_ptr<CameraDevice>> make(Open open, Time patience, Wait wait);

  Expected<Image> take() override;
  std::string name() const override { return name_; }
  std::optional<PictureSize> size() const override { return size_; }
  int n_retaken() const override;
  std::vector<Diagnostic> risks() const override { return risks_; }
  bool can_set(CameraSetting setting) const override;
  std::optional<double> value(CameraSetting setting) const override {
    return device_ ? device_->value(setting) : std::nullopt;
  }
  Expected<void> set(CameraSetting setting, double value) override;

 private:
  PatientCamera(Open open, Time patience, Wait wait, std::unique_ptr<CameraDevice> device);

  Expected<void> reopen();
  /// Those that were said before stand.
  void add_risks();
  template <class Result, class Act>
  Expected<Result> tried(const Act& act);

  Open open_;
  Time patience_;
  Wait wait_;
  std::unique_ptr<CameraDevice> device_;  ///< null while it is away
  std::string name_;
  std::optional<PictureSize> size_;
  std::array<bool, kCameraSettings> can_set_{};
  std::map<CameraSetting, double> settings_;
  std::vector<Diagnostic> risks_;
  int n_retaken_before_ = 0;  ///< of the devices before this one
};

/// As open_camera(); a live camera is a patient one.
Expected<std::unique_ptr<CameraDevice>> open_patient_camera(std::string_view uri, Time patience);

}  // namespace panelcal
