// SPDX-License-Identifier: Apache-2.0
#include "panelcal/machine/nightly/self_test.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "panelcal/machine/mark_sights.h"
#include "panelcal/machine/picture_locator.h"

namespace panelcal {
namespace {

constexpr int kLooks = 5;
/// Of a picture's pixels that may be overexposed: a reflection, but not a lamp set too high.
constexpr double kMostClipped = 0.02;

/// The mark as a request that a locator understands; work zero is machine zero.
MeasurementRequest request_of(const NightlyConfig& nightly) {
  MeasurementRequest request;
  request.line = nightly.place.line;
  request.command = "mark";
  request.settings.tools = {nightly.mark_tool};
  request.nominal = position_mm<frame::Nominal>(nightly.mark->in_mm());
  request.expected = position_mm<frame::Actual>(nightly.mark->in_mm());
  return request;
}

double clipped_share(const Image& image) {
  if (image.empty()) return 0;
  const auto full = static_cast<float>(image.full_scale());
  const auto n = std::ranges::count_if(image.pixels(), [&](float v) { return v >= full; });
  return static_cast<double>(n) / static_cast<double>(image.pixels().size());
}

Expected<void> check_travel(const MachineConfig& config,
                            const Position<frame::Machine>& place,
                            const Place& at) {
  if (is_in_travel(config, place)) return {};
  const Eigen::Vector2d& p_mm = place.in_mm();
  return failure(
      {Code::TravelExceeded,
       at,
       fmt::format(
           "[nightly] mark_mm sends the spindle to ({:.3f}, {:.3f}) mm", p_mm.x(), p_mm.y()),
       "a mark that can be seen within [machine] travel"});
}

/// What the looks found so far.
struct Looks {
  std::vector<Eigen::Vector2d> places_mm;
  double log_contrast = 0;
  double log_blur = 0;
  double clipped = 0;
  std::string missed;
};

Expected<void> look(const MachineConfig& config,
                    const NightlyConfig& nightly,
                    const CalibrationDevices& devices,
                    const PictureLocator& locator,
                    Looks& looks) {
  const Position<frame::Machine> spindle = config.spindle_camera.spindle_to_see(*nightly.mark);
  const Displacement<frame::Machine> away = displacement_mm<frame::Machine>(1, 1);
  PANELCAL_CHECK(devices.stage.move_to(spindle - away));
  PANELCAL_TRY(const Position<frame::Machine> standing, devices.stage.move_to(spindle));
  if (devices.wait) devices.wait(config.settle);
  PANELCAL_TRY(Image image, devices.camera.take());
  looks.clipped = std::max(looks.clipped, clipped_share(image));
  const TakenPicture picture{
      std::move(image), config.spindle_camera.optical_axis(standing), "", devices.camera.name()};
  const MeasurementRequest request = request_of(nightly);
  PANELCAL_TRY(const Target target, locator.target_of(request));
  Look asked;
  asked.view.axis = picture.axis;
  asked.target = target;
  asked.expected = asked.shown = *nightly.mark;
  asked.radius = config.vision.search_radius;
  PANELCAL_TRY(const Sight sight, locator.look(request, asked, picture));
  if (!sight.is_found()) {
    looks.missed = sight.reason.empty() ? std::string(name(sight.status)) : sight.reason;
    return {};
  }
  looks.places_mm.push_back(sight.place.position.in_mm());
  return {};
}

double variance_of(const std::vector<Eigen::Vector2d>& places_mm) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : places_mm) mean += p / static_cast<double>(places_mm.size());
  double sum = 0;
  for (const Eigen::Vector2d& p : places_mm) sum += (p - mean).squaredNorm();
  return sum / (2.0 * static_cast<double>(places_mm.size() - 1));
}

SelfTestCheck found_check(const Looks& looks) {
  SelfTestCheck check;
  check.name = "mark";
  check.value = static_cast<double>(looks.places_mm.size());
  check.limit = kLooks;
  check.unit = "looks";
  check.passed = looks.places_mm.size() == kLooks;
  check.text = fmt::format("the mark was found in {} of {} looks{}{}",
                           looks.places_mm.size(),
                           kLooks,
                           check.passed ? "" : ": ",
                           check.passed ? "" : looks.missed);
  return check;
}

SelfTestCheck clipped_check(const Looks& looks) {
  SelfTestCheck check;
  check.name = "overexposure";
  check.value = looks.clipped;
  check.limit = kMostClipped;
  check.unit = "1";
  check.passed = looks.clipped <= kMostClipped;
  check.text = fmt::format("{:.1f} % of the picture is overexposed, limit {:.1f} %",
                           100 * looks.clipped,
                           100 * kMostClipped);
  return check;
}

}  // namespace

SelfTestCheck check_disk(const std::filesystem::path& ledger, double min_mb) {
  const std::filesystem::path folder = ledger.has_parent_path() ? ledger.parent_path() : ".";
  SelfTestCheck check;
  check.name = "disk";
  check.limit = min_mb;
  check.unit = "MB";
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  if (error) {
    check.passed = false;
    check.text = "the disk's room is not known: " + error.message();
    return check;
  }
  constexpr double kMega = 1e6;
  check.value = static_cast<double>(space.available) / kMega;
  check.passed = *check.value >= min_mb;
  check.text = fmt::format("{:.0f} MB are free, at least {:.0f} are needed", *check.value, min_mb);
  return check;
}

Expected<MarkLooks> test_mark(const MachineConfig& config,
                              const NightlyConfig& nightly,
                              const CalibrationDevices& devices) {
  Looks looks;
  int n_seen = 0;
  const PictureObserver observer = [&](const SeenView& seen) {
    if (devices.observer) devices.observer(seen);
    if (seen.detection.status != DetectionStatus::Found || !seen.detection.best) return;
    const TargetFit& fit = *seen.detection.best;
    if (!(std::abs(fit.contrast) > 0) || !(fit.blur_px > 0)) return;
    ++n_seen;
    looks.log_contrast += std::log(std::abs(fit.contrast) / seen.picture.image.full_scale());
    looks.log_blur += std::log(fit.blur_px);
  };
  PANELCAL_TRY(const PictureLocator locator, PictureLocator::create(config, observer));
  PANELCAL_CHECK(locator.check(request_of(nightly)));
  const Position<frame::Machine> spindle = config.spindle_camera.spindle_to_see(*nightly.mark);
  PANELCAL_CHECK(check_travel(config, spindle, nightly.place));
  PANELCAL_CHECK(
      check_travel(config, spindle - displacement_mm<frame::Machine>(1, 1), nightly.place));
  for (int i = 0; i < kLooks; ++i) {
    PANELCAL_CHECK(look(config, nightly, devices, locator, looks));
  }
  MarkLooks out;
  out.checks = {found_check(looks), clipped_check(looks)};
  if (looks.places_mm.size() >= 2) {
    const auto degrees = static_cast<double>(2 * (looks.places_mm.size() - 1));
    out.quality.spreads = {{"looks at the mark", "mm", variance_of(looks.places_mm), degrees}};
  }
  if (n_seen > 0) {
    out.quality.levels = {
        {"contrast of the mark", "1", std::exp(looks.log_contrast / n_seen), true},
        {"edge blur of the mark", "px", std::exp(looks.log_blur / n_seen), false}};
  }
  return out;
}

}  // namespace panelcal
