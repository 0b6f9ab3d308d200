// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "calib/correction/spindle_camera.h"
#include "machine/config/machine_config.h"
#include "machine/devices/camera.h"
#include "machine/devices/controls/control.h"
#include "machine/devices/stage.h"
#include "machine/look/view_taker.h"

namespace panelcal {

/// Shows the panel with a live camera on a stage: drives, sets lamp, zoom and focus, lets the
/// machine come to rest, takes a picture. The focus comes after the drive, since the best height
/// belongs to a place and the camera need not carry it to the next; a setting without a command is
/// refused before anything moves.
///
///   spindle = place to look at - spindle-camera offset
///   axis    = where the stage says the spindle stands + spindle-camera offset
///
/// A setting that is already so is not ordered again: the pictures of several inspections are taken
/// without moving. After a failure everything is ordered anew.
class CameraViews final : public ViewTaker {
 public:
  /// Waits for a time; tests wait in their own way.
  using Wait = std::function<void(Time)>;

  /// Precondition: camera and stage are there.
  CameraViews(SpindleCameraOffset offset,
              std::unique_ptr<CameraDevice> camera,
              std::shared_ptr<Stage> stage,
              Time settle,
              Wait wait = {});

  /// Fails  config-value (a lamp, zoom or focus is asked for that neither the camera nor the stage
  ///        can set); device-stage; device-frame
  Expected<TakenPicture> take(const MeasurementRequest& request, const View& view) override;

  bool can_set(CameraSetting setting) const override {
    return camera_->can_set(setting) || stage_->can_set(setting);
  }
  std::optional<double> exposure_us() const override {
    return camera_->value(CameraSetting::Exposure);
  }

  const CameraDevice& camera() const { return *camera_; }

  /// [camera] lamp for requests without one, and [camera] focus_mm until a view asks for another.
  void set_stated(const VisionOptions& vision) { stated_ = vision; }

  /// Sets lamp, zoom and focus.
  ///
  /// Fails  as take, but for the frame
  Expected<void> prepare(const MeasurementRequest& request, const View& view);

  /// Looks through another offset from here on.
  void set_offset(const SpindleCameraOffset& offset) { offset_ = offset; }
  // For calibrations with the same devices; code that drives the stage has to say so afterwards.
  CameraDevice& camera() { return *camera_; }
  Stage& stage() { return *stage_; }
  const Wait& wait() const { return wait_; }
  void forget_place() { commanded_.reset(); }

 private:
  using Settings = std::vector<std::pair<CameraSetting, double>>;

  /// The settings of a view that are not so already.
  Expected<Settings> settings_for(const MeasurementRequest& request, const View& view) const;
  Expected<void> set(const Settings& settings);
  Expected<void> drive(const Position<frame::Machine>& spindle);

  SpindleCameraOffset offset_;
  std::unique_ptr<CameraDevice> camera_;
  std::shared_ptr<Stage> stage_;
  Time settle_;
  Wait wait_;
  VisionOptions stated_;                               ///< its lamp and focus
  std::map<CameraSetting, double> set_;                ///< the last values
  std::optional<double> usual_exposure_us_;            ///< before a request asked for another
  std::optional<Position<frame::Machine>> commanded_;  ///< place to which the spindle was sent last
  Position<frame::Machine> standing_;                  ///< and where it stands
  bool is_settled_ = false;
};

/// The camera and the stage of a machine file.
///
/// In     control: gives what open_control has opened; empty: it is opened here
/// Fails  config-value (no [camera], nothing drives the stage); what open_camera and control report
Expected<std::unique_ptr<CameraViews>> open_camera_views(
    const MachineConfig& config,
    std::string_view camera_uri,
    const std::function<Expected<OpenedControl>()>& control = {});

}  // namespace panelcal
