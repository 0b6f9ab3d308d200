// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/spindle/camera_run.h"

#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "machine/calibrate/spindle/coupon.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// A list of a coupon of many holes would hide what else there is to say.
constexpr std::size_t kListedLooks = 20;

Expected<const Coupon*> coupon_of(const MachineConfig& config) {
  if (config.coupon) return &*config.coupon;
  return failure({Code::ConfigValue,
                  {config.file.string(), 0, 0},
                  "there is no [coupon] to drill into",
                  "[coupon] with origin_mm = [x, y]"});
}

/// Backlash is in the offset if every look came to rest along an axis as the drill did not.
Expected<void> check_approaches(const MachineConfig& config, const Coupon& coupon) {
  if (fit_options(config).backlash) return {};
  const auto has_one_side = [&](int Approach::*axis) {
    return std::ranges::all_of(coupon.looking, [&](const Approach& approach) {
      return approach.*axis == coupon.looking.front().*axis;
    });
  };
  for (int Approach::*axis : {&Approach::x, &Approach::y}) {
    if (!has_one_side(axis) || coupon.looking.front().*axis == coupon.drilling.*axis) continue;
    return failure({Code::ConfigValue,
                    coupon.place,
                    fmt::format("all looks at coupon {} come to rest along {} otherwise than the "
                                "drill ({}), so that backlash would be taken for offset",
                                quoted(coupon.name),
                                axis == &Approach::x ? 'x' : 'y',
                                text(coupon.drilling)),
                    "approaches from the drill's side, or from both"});
  }
  return {};
}

/// All that can be known before anything moves and before a row is taken.
Expected<void> check(const MachineConfig& config,
                     const CalibrationDevices& devices,
                     const Coupon& coupon,
                     const std::vector<Position<frame::Machine>>& places) {
  if (!devices.spindle.can_drill()) {
    return failure({Code::ConfigValue,
                    {config.file.string(), 0, 0},
                    "there is no [machine] drill_command that drills a hole",
                    "drill_command = [\"PROGRAM\", \"{tool}\"]"});
  }
  PANELCAL_CHECK(check_approaches(config, coupon));
  return check_coupon_job(config, coupon, places);
}

std::string missed_lines(const SpindleCameraRun& run) {
  std::string lines;
  std::size_t n_listed = 0;
  for (const MissedLook& look : run.sights.missed) {
    if (++n_listed > kListedLooks) {
      return lines + fmt::format("and {} more\n", run.sights.missed.size() - kListedLooks);
    }
    const Eigen::Vector2d& place_mm = run.places[look.i_place].in_mm();
    lines += fmt::format("not seen: the hole at ({:.3f}, {:.3f}) mm, look {}: {}\n",
                         place_mm.x(),
                         place_mm.y(),
                         look.i_look + 1,
                         look.reason);
  }
  return lines;
}

/// With an offset that is wrong by whole pitches the camera shows holes at each place, but other
/// ones. Earlier rows are seen before there is anything to see. So is a coupon that an operator has
/// drilled already, before a drill breaks in its holes.
Expected<void> check_is_fresh(const MachineConfig& config,
                              const CalibrationDevices& devices,
                              const Coupon& coupon,
                              std::vector<Position<frame::Machine>> places,
                              std::string_view cause) {
  Coupon first = coupon;
  first.looking.resize(1);
  places.resize(static_cast<std::size_t>(coupon.columns));
  PANELCAL_TRY(
      const CouponSights sights,
      look_at_coupon(config, first, places, {devices.stage, devices.camera, devices.wait, {}}));
  if (sights.holes.empty()) return {};
  const Eigen::Vector2d& place_mm = sights.holes.front().drilled.in_mm();
  return failure(
      {Code::CalibrationRefused,
       coupon.place,
       fmt::format("there is a hole already where the one to be drilled at ({:.3f}, "
                   "{:.3f}) mm is looked for: {}, or the spindle-camera offset is wrong by a "
                   "pitch",
                   place_mm.x(),
                   place_mm.y(),
                   cause),
       "a fresh coupon with a name of its own, and an offset to begin with that is true "
       "to less than half a pitch"});
}

/// The other way round a whole edge of the lattice shows nothing.
Expected<void> check_edges(const Coupon& coupon, const SpindleCameraRun& run) {
  const double tolerance_mm = 1e-6;
  for (const int axis : {0, 1}) {
    for (const int side : {-1, 1}) {
      double edge_mm = -std::numeric_limits<double>::infinity();
      double seen_mm = edge_mm;
      for (const Position<frame::Machine>& place : run.places) {
        edge_mm = std::max(edge_mm, side * place.in_mm()[axis]);
      }
      for (const CouponHole& hole : run.sights.holes) {
        seen_mm = std::max(seen_mm, side * hole.drilled.in_mm()[axis]);
      }
      if (seen_mm >= edge_mm - tolerance_mm) continue;
      return failure(
          {Code::CalibrationRefused,
           coupon.place,
           fmt::format(
               "none of the holes at {} = {:.3f} mm, an edge of the lattice, was seen; so it "
               "would be if the spindle-camera offset were wrong by a pitch",
               axis == 0 ? 'x' : 'y',
               side * edge_mm),
           "an offset to begin with that is true to less than half a pitch, and a sound drill"});
    }
  }
  return {};
}

Diagnostic no_fit(const Coupon& coupon, const SpindleCameraRun& run, SpindleCameraFailure reason) {
  std::string what = fmt::format("{} of {} holes of coupon {} were seen; {}",
                                 run.sights.holes.size(),
                                 run.places.size(),
                                 quoted(coupon.name),
                                 text(reason));
  if (!run.sights.missed.empty()) {
    const MissedLook& first = run.sights.missed.front();
    what += fmt::format("; {} looks missed, of hole {}: {}",
                        run.sights.missed.size(),
                        first.i_place + 1,
                        first.reason);
  }
  return {Code::CalibrationRefused, coupon.place, std::move(what), "holes that make an offset"};
}

Expected<SpindleCameraRun> drill_look_and_fit(const MachineConfig& config,
                                              const CalibrationDevices& devices,
                                              const Coupon& coupon,
                                              SpindleCameraRun run) {
  PANELCAL_CHECK(
      drill_coupon(config, coupon, run.places, devices.stage, devices.spindle, devices.prompt));
  PANELCAL_TRY(run.sights,
               look_at_coupon(config,
                              coupon,
                              run.places,
                              {devices.stage, devices.camera, devices.wait, devices.observer}));
  if (run.sights.holes.size() >= static_cast<std::size_t>(kLeastHoles)) {
    PANELCAL_CHECK(check_edges(coupon, run));
  }
  SpindleCameraFitResult result = fit_spindle_camera(run.sights.holes, fit_options(config));
  if (!result.fit) return failure(no_fit(coupon, run, result.failure));
  run.fit = *std::move(result.fit);
  return run;
}

}  // namespace

Expected<SpindleCameraRun> calibrate_spindle_camera(const MachineConfig& config,
                                                    const CalibrationDevices& devices) {
  PANELCAL_TRY(const Coupon* const coupon, coupon_of(config));
  PANELCAL_TRY(const UsedRows used, used_rows(config));
  const int n_used = used.count();
  const std::vector<Position<frame::Machine>> next = places_of_row(*coupon, n_used);
  PANELCAL_CHECK(check(config, devices, *coupon, next));
  // Behind the last row there is something else than coupon.
  if (n_used <= coupon->rows - coupon->rows_per_run) {
    const std::string cause = fmt::format("coupon {} is used farther than {} records",
                                          quoted(coupon->name),
                                          quoted(coupon->state_file.filename().string()));
    PANELCAL_CHECK(check_is_fresh(config, devices, *coupon, next, cause));
  }
  SpindleCameraRun run;
  PANELCAL_TRY(run.i_row, take_rows(config, devices.taken_by));
  run.places = places_of_row(*coupon, run.i_row);
  return drill_look_and_fit(config, devices, *coupon, std::move(run));
}

Expected<SpindleCameraRun> calibrate_spindle_camera_at(
    const MachineConfig& config,
    const CalibrationDevices& devices,
    std::vector<Position<frame::Machine>> places) {
  PANELCAL_TRY(const Coupon* const coupon, coupon_of(config));
  PANELCAL_CHECK(check(config, devices, *coupon, places));
  PANELCAL_CHECK(
      check_is_fresh(config, devices, *coupon, places, "the place was drilled at before"));
  SpindleCameraRun run;
  run.places = std::move(places);
  return drill_look_and_fit(config, devices, *coupon, std::move(run));
}

std::string report_text(const SpindleCameraRun& run) {
  return run.fit.report() + missed_lines(run);
}

}  // namespace panelcal
