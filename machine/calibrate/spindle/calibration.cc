// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/spindle/calibration.h"

#include <cmath>
#include <optional>
#include <utility>

#include "calib/correction/spindle_camera.h"
#include "machine/look/mark_sights.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// From where the stage comes to a place.
Position<frame::Machine> start_of(const Position<frame::Machine>& place,
                                  const Approach& approach,
                                  Length distance) {
  return place - displacement_mm<frame::Machine>(distance.in_mm() * approach.x,
                                                 distance.in_mm() * approach.y);
}

/// Drives to a place so that it comes to rest as told, and returns where it stands.
Expected<Position<frame::Machine>> come_to(Stage& stage,
                                           const Position<frame::Machine>& place,
                                           const Approach& approach,
                                           Length distance) {
  if (!(approach == Approach{})) {
    PANELCAL_CHECK(stage.move_to(start_of(place, approach, distance)));
  }
  return stage.move_to(place);
}

/// A place and where the stage comes from.
Expected<void> check_way(const MachineConfig& config,
                         const Position<frame::Machine>& place,
                         const Approach& approach,
                         const Coupon& coupon) {
  const std::string what =
      fmt::format("a calibration on coupon {} sends the spindle to", quoted(coupon.name));
  PANELCAL_CHECK(check_travel(config, place, coupon.place, what));
  return check_travel(
      config, start_of(place, approach, coupon.approach_distance), coupon.place, what);
}

/// The coupon's hole as a request that a locator understands; work zero is machine zero.
MeasurementRequest coupon_request(const Coupon& coupon,
                                  const Position<frame::Machine>& place,
                                  std::size_t i_place) {
  MeasurementRequest request;
  request.seq = static_cast<std::int64_t>(i_place);
  request.line = coupon.place.line;
  request.command = "coupon";
  request.settings.tools = {coupon.vision_tool};
  request.nominal = position_mm<frame::Nominal>(place.in_mm());
  request.expected = position_mm<frame::Actual>(place.in_mm());
  return request;
}

std::string reason_of(const Sight& sight) {
  return sight.reason.empty() ? std::string(name(sight.status)) : sight.reason;
}

/// Looks at one hole after another.
class CouponLooks {
 public:
  CouponLooks(const MachineConfig& config,
              const Coupon& coupon,
              const CouponLooker& looker,
              PictureLocator locator)
      : config_(config), coupon_(coupon), looker_(looker), locator_(std::move(locator)) {}

  Expected<Sight> look(const Position<frame::Machine>& place,
                       std::size_t i_place,
                       int i_look,
                       CouponView& seen) const {
    const Approach& approach = coupon_.looking[static_cast<std::size_t>(i_look)];
    const Position<frame::Machine> spindle = config_.spindle_camera.spindle_to_see(place);
    PANELCAL_TRY(const Position<frame::Machine> standing,
                 come_to(looker_.stage, spindle, approach, coupon_.approach_distance));
    if (looker_.wait) looker_.wait(config_.settle);
    PANELCAL_TRY(Image image, looker_.camera.take());
    const TakenPicture picture{
        std::move(image), config_.spindle_camera.optical_axis(standing), "", looker_.camera.name()};
    const MeasurementRequest request = coupon_request(coupon_, place, i_place);
    PANELCAL_TRY(const Target target, locator_.target_of(request));
    Look look;
    look.view.axis = picture.axis;
    look.view.i_view = i_look;
    look.target = target;
    look.expected = look.shown = place;
    look.radius = config_.vision.search_radius;
    look.words = fmt::format(", look {} of {}", i_look + 1, coupon_.looking.size());
    PANELCAL_TRY(Sight sight, locator_.look(request, look, picture));
    if (!sight.is_found()) return sight;
    const Eigen::Vector2d from_axis_mm = sight.place.position.in_mm() - picture.axis.in_mm();
    seen = {standing,
            approach,
            {position_mm<frame::Optical>(from_axis_mm), sight.place.cov},
            sight.by_camera};
    return sight;
  }

 private:
  const MachineConfig& config_;
  const Coupon& coupon_;
  const CouponLooker& looker_;
  PictureLocator locator_;
};

/// Checks what drilling needs.
Expected<void> check_drilling(const MachineConfig& config,
                              const Coupon& coupon,
                              std::span<const Position<frame::Machine>> places) {
  for (const Position<frame::Machine>& place : places) {
    PANELCAL_CHECK(check_way(config, place, coupon.drilling, coupon));
  }
  return {};
}

/// Checks what looking needs.
Expected<void> check_looking(const MachineConfig& config,
                             const Coupon& coupon,
                             std::span<const Position<frame::Machine>> places,
                             const PictureLocator& locator) {
  for (const Position<frame::Machine>& place : places) {
    for (const Approach& approach : coupon.looking) {
      PANELCAL_CHECK(
          check_way(config, config.spindle_camera.spindle_to_see(place), approach, coupon));
    }
  }
  return places.empty() ? Expected<void>()
                        : locator.check(coupon_request(coupon, places.front(), 0));
}

Expected<void> tell(const Prompt& prompt, bool is_wanted, std::string_view what) {
  if (!is_wanted) return {};
  if (!prompt) {
    return failure({Code::DeviceStage,
                    {"coupon", 0, 0},
                    fmt::format("operator required to {}: no terminal", what),
                    "an operator at a terminal, or [coupon] entry_material = false"});
  }
  return prompt(what);
}

}  // namespace

Expected<void> check_coupon_job(const MachineConfig& config,
                                const Coupon& coupon,
                                std::span<const Position<frame::Machine>> places) {
  PANELCAL_TRY(const PictureLocator locator, PictureLocator::create(config));
  PANELCAL_CHECK(check_drilling(config, coupon, places));
  return check_looking(config, coupon, places, locator);
}

Expected<void> drill_coupon(const MachineConfig& config,
                            const Coupon& coupon,
                            std::span<const Position<frame::Machine>> places,
                            Stage& stage,
                            Spindle& spindle,
                            const Prompt& prompt) {
  PANELCAL_CHECK(check_drilling(config, coupon, places));
  PANELCAL_CHECK(tell(prompt, coupon.has_entry_material, "lay entry material on the coupon"));
  for (const Position<frame::Machine>& place : places) {
    PANELCAL_CHECK(come_to(stage, place, coupon.drilling, coupon.approach_distance));
    PANELCAL_CHECK(spindle.drill(coupon.drill_tool));
  }
  return tell(prompt, coupon.has_entry_material, "take the entry material off the coupon");
}

Expected<CouponSights> look_at_coupon(const MachineConfig& config,
                                      const Coupon& coupon,
                                      std::span<const Position<frame::Machine>> places,
                                      const CouponLooker& looker) {
  PANELCAL_TRY(PictureLocator locator, PictureLocator::create(config, looker.observer));
  PANELCAL_CHECK(check_looking(config, coupon, places, locator));
  const CouponLooks looks(config, coupon, looker, std::move(locator));
  std::vector<CouponHole> all;
  for (const Position<frame::Machine>& place : places) {
    all.push_back({place, coupon.drilling, {}});
  }
  CouponSights sights;
  for (int i_look = 0; i_look < static_cast<int>(coupon.looking.size()); ++i_look) {
    for (std::size_t i = 0; i < places.size(); ++i) {
      CouponView seen;
      PANELCAL_TRY(const Sight sight, looks.look(places[i], i, i_look, seen));
      if (sight.is_found()) {
        all[i].views.push_back(std::move(seen));
      } else {
        sights.missed.push_back({i, i_look, reason_of(sight)});
      }
    }
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].views.empty()) continue;
    sights.holes.push_back(std::move(all[i]));
    sights.i_place.push_back(i);
  }
  return sights;
}

SpindleCameraFitOptions fit_options(const MachineConfig& config) {
  const MachineUncertainty& machine = config.walk.uncertainty;
  SpindleCameraFitOptions options;
  // A machine file that says nothing of scatter does not say that there is none.
  if (machine.drill_wander == Length() || machine.stage_repeatability == Length()) return options;
  // Between holes there is the stage's own arrival as well.
  options.expected_wander =
      mm(std::hypot(machine.drill_wander.in_mm(), machine.stage_repeatability.in_mm()));
  options.expected_repeatability = machine.stage_repeatability;
  return options;
}

}  // namespace panelcal
