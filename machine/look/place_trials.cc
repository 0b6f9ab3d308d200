// SPDX-License-Identifier: Apache-2.0
#include "machine/look/place_trials.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/correction/spindle_camera.h"
#include "calib/drift/settle_delays.h"
#include "machine/devices/cameras/camera_settings.h"
#include "machine/look/focus.h"
#include "machine/look/mark_sights.h"
#include "machine/look/picture_locator.h"
#include "machine/look/view_taker.h"
#include "vision/locate/locate.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr int kMostLevels = 1000;
constexpr int kMostDelays = 200;
constexpr int kMostMoves = 50;

tl::unexpected<Diagnostic> trial_refused(Code code,
                                         const MachineConfig& config,
                                         std::string what,
                                         std::string expected) {
  return failure({code, {config.file.string(), 0, 0}, std::move(what), std::move(expected)});
}

/// The devices at one place.
class PlaceViews final : public ViewTaker {
 public:
  PlaceViews(const MachineConfig& config, const CalibrationDevices& devices)
      : config_(config), devices_(devices) {}

  Expected<void> check(const Position<frame::Machine>& spindle) const {
    return check_travel(
        config_, spindle, {config_.file.string(), 0, 0}, "the spindle would have to go to");
  }

  Expected<void> set(CameraSetting setting, double value) {
    return set_camera(config_, devices_, setting, value);
  }

  /// Drives so that the axis stands at a place, and says where it does.
  Expected<Position<frame::Machine>> go(const Position<frame::Machine>& axis) {
    const auto spindle = config_.spindle_camera.spindle_to_see(axis);
    PANELCAL_CHECK(check(spindle));
    PANELCAL_TRY(const Position<frame::Machine> standing, devices_.stage.move_to(spindle));
    return config_.spindle_camera.optical_axis(standing);
  }
  void settle() const {
    if (devices_.wait) devices_.wait(config_.settle);
  }

  /// One way for all pictures: the stage stays where it is.
  Expected<TakenPicture> take(const MeasurementRequest& /*request*/, const View& view) override {
    if (!standing_) {
      PANELCAL_TRY(standing_, go(view.axis));
    }
    if (view.focus_z) PANELCAL_CHECK(set(CameraSetting::Focus, view.focus_z->in_mm()));
    settle();
    PANELCAL_TRY(Image image, devices_.camera.take());
    return TakenPicture{std::move(image), *standing_, "", devices_.camera.name()};
  }

 private:
  const MachineConfig& config_;
  const CalibrationDevices& devices_;
  std::optional<Position<frame::Machine>> standing_;
};

MeasurementRequest request_at(const Position<frame::Machine>& place, int tool) {
  MeasurementRequest request;
  request.command = "calibrate";
  request.settings.tools = {tool};
  request.nominal = position_mm<frame::Nominal>(place.in_mm());
  request.expected = position_mm<frame::Actual>(place.in_mm());
  return request;
}

double trial_clipped_share(const Image& image) {
  if (image.empty()) return 0;
  const auto pixels = image.pixels();
  const auto n =
      std::ranges::count_if(pixels, [&](float level) { return level >= image.full_scale(); });
  return static_cast<double>(n) / static_cast<double>(pixels.size());
}

Expected<Target> target_of(const MachineConfig& config, int tool) {
  const auto found = config.vision_tools.find(tool);
  if (found != config.vision_tools.end()) return found->second;
  return trial_refused(Code::VisionToolUndefined,
                       config,
                       fmt::format("vision tool {}", tool),
                       fmt::format("a [[vision.tool]] with number = {}", tool));
}

Expected<void> check_levels(const MachineConfig& config, const std::vector<double>& levels) {
  const bool is_ascending =
      std::ranges::adjacent_find(levels, std::greater_equal<>()) == levels.end();
  const bool is_finite =
      std::ranges::all_of(levels, [](double level) { return std::isfinite(level); });
  if (levels.size() >= 3 && levels.size() <= kMostLevels && is_ascending && is_finite) return {};
  return trial_refused(Code::ConfigValue,
                       config,
                       fmt::format("{} lamp levels to try", levels.size()),
                       fmt::format("3 to {} in ascending order", kMostLevels));
}

Expected<void> check_trial(const MachineConfig& config,
                           const CalibrationDevices& devices,
                           const SettleTrial& trial) {
  const auto bad = [&](std::string what, std::string expected) {
    return trial_refused(Code::ConfigValue, config, std::move(what), std::move(expected));
  };
  if (!devices.wait || !devices.now) {
    return bad("this machine stands still at once, without a settling time", "a real machine");
  }
  if (!(trial.way > Length()) || !(trial.limit > Length())) {
    return bad("the way or the limit of a settle trial is not above 0", "lengths above 0");
  }
  if (!(trial.longest > Time()) || trial.n_delays < 4 || trial.n_delays > kMostDelays ||
      trial.n_moves < 1 || trial.n_moves > kMostMoves) {
    return bad(
        "a settle trial is outside its bounds",
        fmt::format("a time above 0, 4 to {} delays, 1 to {} moves", kMostDelays, kMostMoves));
  }
  return {};
}

std::vector<Time> delays_of(const SettleTrial& trial,
                            int i_round,
                            const std::vector<SettleView>& seen) {
  if (i_round == 0) return first_settle_delays(trial.n_delays, trial.longest);
  return next_settle_delays(seen, trial.n_delays, i_round, trial.longest, trial.limit);
}

}  // namespace

Expected<FocusResult> calibrate_focus(const MachineConfig& config,
                                      const CalibrationDevices& devices,
                                      const Position<frame::Machine>& place,
                                      int tool,
                                      const FocusRange& range) {
  if (!(range.high > range.low)) {
    return trial_refused(
        Code::ConfigValue, config, "the range of focus heights is empty", "low < high");
  }
  PlaceViews views(config, devices);
  PANELCAL_CHECK(check_can_set(config, devices, CameraSetting::Focus));
  PANELCAL_TRY(FocusResult result, autofocus(request_at(place, tool), range, views));
  if (result.is_found) PANELCAL_CHECK(views.set(CameraSetting::Focus, result.z.in_mm()));
  return result;
}

std::vector<double> lamp_levels(double low, double high, int n) {
  std::vector<double> levels;
  for (int i = 0; i < n; ++i) levels.push_back(low + (high - low) * i / (n - 1));
  return levels;
}

Expected<LightRun> calibrate_light(const MachineConfig& config,
                                   const CalibrationDevices& devices,
                                   const Position<frame::Machine>& place,
                                   int tool,
                                   const std::vector<double>& levels) {
  PANELCAL_CHECK(check_levels(config, levels));
  PANELCAL_TRY(const Target target, target_of(config, tool));
  PlaceViews views(config, devices);
  PANELCAL_CHECK(check_can_set(config, devices, CameraSetting::Lamp));
  const MeasurementRequest request = request_at(place, tool);
  const auto mapping = config.camera && target.size
                           ? std::optional<CameraMapping>(config.camera->mapping())
                           : std::nullopt;
  View view;
  view.axis = place;
  LightRun run;
  for (const double level : levels) {
    PANELCAL_CHECK(views.set(CameraSetting::Lamp, level));
    PANELCAL_TRY(const TakenPicture picture, views.take(request, view));
    const Detection seen =
        locate(picture.image, target, mapping ? &*mapping : nullptr, config.locate);
    const bool is_found = seen.status == DetectionStatus::Found;
    const double contrast =
        is_found ? std::abs(seen.best->contrast) / picture.image.full_scale() : 0;
    run.samples.push_back({level, contrast, trial_clipped_share(picture.image)});
  }
  run.best = best_lamp_level(run.samples, {}, &run.reason);
  if (run.best) PANELCAL_CHECK(views.set(CameraSetting::Lamp, run.best->level));
  return run;
}

Expected<SettleRun> calibrate_settle(const MachineConfig& config,
                                     const CalibrationDevices& devices,
                                     const Position<frame::Machine>& place,
                                     const SettleTrial& trial) {
  PANELCAL_CHECK(check_trial(config, devices, trial));
  PANELCAL_TRY(const PictureLocator locator, PictureLocator::create(config, devices.observer));
  const MeasurementRequest request = request_at(place, trial.tool);
  PANELCAL_CHECK(locator.check(request));
  PANELCAL_TRY(const Target target, locator.target_of(request));
  PlaceViews views(config, devices);
  const auto away =
      place - displacement_mm<frame::Machine>(Eigen::Vector2d::Constant(trial.way.in_mm()));
  PANELCAL_CHECK(views.check(config.spindle_camera.spindle_to_see(away)));
  PANELCAL_CHECK(views.check(config.spindle_camera.spindle_to_see(place)));
  SettleRun run;
  for (int i_move = 0; i_move < trial.n_moves; ++i_move) {
    const std::vector<Time> delays = delays_of(trial, i_move, run.views);
    for (int i = 0; i < trial.n_delays; ++i) {
      PANELCAL_CHECK(views.go(away));
      devices.wait(trial.longest);
      PANELCAL_TRY(const Position<frame::Machine> axis, views.go(place));
      const Time arrived = devices.now();
      devices.wait(delays[static_cast<std::size_t>(i)]);
      const Time asked = devices.now();
      PANELCAL_TRY(Image image, devices.camera.take());
      Look look;
      look.view.axis = axis;
      look.view.i_view = i;
      look.target = target;
      look.expected = look.shown = place;
      look.radius = config.vision.search_radius;
      const TakenPicture picture{std::move(image), axis, "", devices.camera.name()};
      PANELCAL_TRY(const Sight sight, locator.look(request, look, picture));
      if (!sight.is_found()) {
        ++run.n_missed;
        continue;
      }
      const Eigen::Vector2d from_axis_mm = sight.place.position.in_mm() - axis.in_mm();
      // Every view is of another stop.
      const Eigen::Matrix2d cov = sight.place.cov + config.walk.uncertainty.stage_mm2();
      run.views.push_back({asked - arrived, {position_mm<frame::Optical>(from_axis_mm), cov}});
    }
  }
  run.settle = fit_settle(run.views, trial.limit, &run.reason);
  return run;
}

}  // namespace panelcal
