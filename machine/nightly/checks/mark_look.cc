// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/checks/mark_look.h"

#include <algorithm>
#include <utility>

#include "machine/look/mark_sights.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// From where every look comes: so much below the mark, on both axes.
Displacement<frame::Machine> mark_approach() {
  return displacement_mm<frame::Machine>(1, 1);
}

/// The mark as a request that a locator understands; work zero is machine zero.
MeasurementRequest mark_request(const NightlyConfig& nightly) {
  MeasurementRequest request;
  request.line = nightly.place.line;
  request.command = "mark";
  request.settings.tools = {nightly.mark_tool};
  request.nominal = position_mm<frame::Nominal>(nightly.mark->in_mm());
  request.expected = position_mm<frame::Actual>(nightly.mark->in_mm());
  return request;
}

double mark_clipped_share(const Image& image) {
  if (image.empty()) return 0;
  const auto full = static_cast<float>(image.full_scale());
  const auto n = std::ranges::count_if(image.pixels(), [&](float v) { return v >= full; });
  return static_cast<double>(n) / static_cast<double>(image.pixels().size());
}

}  // namespace

Expected<MarkLooker> MarkLooker::make(const MachineConfig& config,
                                      const NightlyConfig& nightly,
                                      PictureObserver observer) {
  if (!nightly.mark) {
    return failure({Code::ConfigValue, nightly.place, "there is no mark to look at", "mark_mm"});
  }
  PANELCAL_TRY(PictureLocator locator, PictureLocator::create(config, std::move(observer)));
  PANELCAL_CHECK(locator.check(mark_request(nightly)));
  const Position<frame::Machine> spindle = config.spindle_camera.spindle_to_see(*nightly.mark);
  for (const Position<frame::Machine>& stop : {spindle, spindle - mark_approach()}) {
    PANELCAL_CHECK(check_travel(config,
                                stop,
                                nightly.place,
                                "[nightly] mark_mm sends the spindle to",
                                "a mark that can be seen within [machine] travel"));
  }
  return MarkLooker(config, nightly, std::move(locator));
}

Expected<MarkSighting> MarkLooker::look(const CalibrationDevices& devices) const {
  const Position<frame::Machine> spindle = config_.spindle_camera.spindle_to_see(*nightly_.mark);
  PANELCAL_CHECK(devices.stage.move_to(spindle - mark_approach()));
  PANELCAL_TRY(const Position<frame::Machine> standing, devices.stage.move_to(spindle));
  if (devices.wait) devices.wait(config_.settle);
  PANELCAL_TRY(Image image, devices.camera.take());
  MarkSighting out;
  out.clipped_share = mark_clipped_share(image);
  const TakenPicture picture{
      std::move(image), config_.spindle_camera.optical_axis(standing), "", devices.camera.name()};
  const MeasurementRequest request = mark_request(nightly_);
  Look asked;
  asked.view.axis = picture.axis;
  PANELCAL_TRY(asked.target, locator_.target_of(request));
  asked.expected = asked.shown = *nightly_.mark;
  asked.radius = config_.vision.search_radius;
  PANELCAL_TRY(const Sight sight, locator_.look(request, asked, picture));
  if (sight.is_found()) {
    out.place_mm = sight.place.position.in_mm();
  } else {
    out.missed = sight.reason.empty() ? std::string(name(sight.status)) : sight.reason;
  }
  return out;
}

}  // namespace panelcal
