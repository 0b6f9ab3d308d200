// SPDX-License-Identifier: Apache-2.0
#include "machine/look/camera_views.h"

#include <string>
#include <string_view>
#include <utility>

#include "calib/base/interruption.h"
#include "machine/devices/cameras/camera_uri.h"
#include "machine/devices/cameras/patient_camera.h"
#include "machine/devices/controls/open/open_control.h"
#include "machine/devices/table_stage.h"
#include <fmt/format.h>

namespace panelcal {

CameraViews::CameraViews(SpindleCameraOffset offset,
                         std::unique_ptr<CameraDevice> camera,
                         std::shared_ptr<Stage> stage,
                         Time settle,
                         Wait wait)
    : offset_(offset),
      camera_(std::move(camera)),
      stage_(std::move(stage)),
      settle_(settle),
      wait_(std::move(wait)) {
  if (!wait_) wait_ = sleep_for;
}

Expected<CameraViews::Settings> CameraViews::settings_for(const MeasurementRequest& request,
                                                          const View& view) const {
  Settings wanted;
  const std::optional<double> lamp = request.settings.lamp ? request.settings.lamp : stated_.lamp;
  if (lamp) wanted.emplace_back(CameraSetting::Lamp, *lamp);
  if (request.settings.zoom) wanted.emplace_back(CameraSetting::Zoom, *request.settings.zoom);
  // After an `$uvis,focus` that found nothing the axis stands at the last height tried.
  const std::optional<Length> focus_z = view.focus_z ? view.focus_z : stated_.focus;
  if (focus_z) wanted.emplace_back(CameraSetting::Focus, focus_z->in_mm());
  const std::optional<double>& asked_us = request.settings.exposure_us;
  const std::optional<double> exposure_us = asked_us ? asked_us : usual_exposure_us_;
  if (exposure_us) wanted.emplace_back(CameraSetting::Exposure, *exposure_us);
  std::erase_if(wanted, [this](const auto& one) {
    const auto known = set_.find(one.first);
    return known != set_.end() && known->second == one.second;
  });
  for (const auto& [setting, value] : wanted) {
    if (can_set(setting)) continue;
    return failure({Code::ConfigValue,
                    {camera_->name(), 0, 0},
                    fmt::format("{} target {} (line {}) asks for {} {}, which this camera does not "
                                "have",
                                request.command,
                                request.seq,
                                request.line,
                                name(setting),
                                value),
                    fmt::format("[machine] {}_command", name(setting))});
  }
  return wanted;
}

Expected<void> CameraViews::set(const Settings& settings) {
  for (const auto& [setting, value] : settings) {
    if (setting == CameraSetting::Exposure && !usual_exposure_us_) {
      usual_exposure_us_ = camera_->value(setting);
      if (!usual_exposure_us_) {
        return failure({Code::NotSupported,
                        {camera_->name(), 0, 0},
                        "the camera does not tell its exposure, which could not be put back",
                        ""});
      }
    }
    set_.erase(setting);
    is_settled_ = false;
    PANELCAL_CHECK(camera_->can_set(setting) ? camera_->set(setting, value)
                                             : stage_->set(setting, value));
    set_[setting] = value;
  }
  return {};
}

Expected<void> CameraViews::prepare(const MeasurementRequest& request, const View& view) {
  PANELCAL_TRY(const Settings settings, settings_for(request, view));
  return set(settings);
}

Expected<void> CameraViews::drive(const Position<frame::Machine>& spindle) {
  if (commanded_ == spindle) return {};
  commanded_.reset();
  is_settled_ = false;
  PANELCAL_TRY(standing_, stage_->move_to(spindle));
  commanded_ = spindle;
  return {};
}

Expected<TakenPicture> CameraViews::take(const MeasurementRequest& request, const View& view) {
  PANELCAL_TRY(const Settings settings, settings_for(request, view));
  PANELCAL_CHECK(drive(offset_.spindle_to_see(view.axis)));
  PANELCAL_CHECK(set(settings));
  if (!is_settled_) wait_(settle_);
  is_settled_ = true;
  PANELCAL_TRY(Image image, camera_->take());
  return TakenPicture{std::move(image), offset_.optical_axis(standing_), "", camera_->name()};
}

Expected<std::unique_ptr<CameraViews>> open_camera_views(
    const MachineConfig& config,
    std::string_view camera_uri,
    const std::function<Expected<OpenedControl>()>& control) {
  // Before a device is touched.
  PANELCAL_CHECK(parse_camera_uri(camera_uri));
  const Place place{config.file.string(), 0, 0};
  if (!config.camera) {
    return failure({Code::ConfigValue,
                    place,
                    "there is no [camera], so that pictures cannot be brought to mm",
                    "[camera] calibration"});
  }
  if (!config.can_move()) {
    return failure(
        {Code::ConfigValue,
         place,
         "there is no [machine] driver or stage_command that drives the camera to a target",
         "driver = \"grbl\", stage_command = [\"PROGRAM\", \"{x}\", \"{y}\"], or --images for "
         "pictures that are already taken"});
  }
  PANELCAL_TRY(std::unique_ptr<CameraDevice> camera,
               open_patient_camera(camera_uri, config.camera_patience));
  PANELCAL_TRY(OpenedControl opened, control ? control() : open_control(config));
  auto views =
      std::make_unique<CameraViews>(config.spindle_camera,
                                    std::move(camera),
                                    measuring_stage(std::move(opened.stage), config.walk.table),
                                    config.settle);
  views->set_stated(config.vision);
  return views;
}

}  // namespace panelcal
