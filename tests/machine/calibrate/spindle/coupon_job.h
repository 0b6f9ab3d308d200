// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "machine/calibrate/spindle/calibration.h"
#include "machine/sim/sim_coupon.h"
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"

namespace panelcal::test {

/// A machine of 10 um a pixel with noise of 3/255 whose offset is 30 and 20 um off what the file
/// says.
inline Expected<MachineConfig> coupon_machine(const std::filesystem::path& folder,
                                              const std::string& more = "") {
  return config_with_camera(folder, test_camera(240, 220), R"([machine]
travel_low_mm = [0, 0]
travel_high_mm = [600, 500]
settle_s = 0.25
[vision]
search_radius_mm = 0.5
[[vision.tool]]
number = 1
shape = "hole"
size_mm = 0.8
[camera]
calibration = "camera.cal.json"
[spindle]
camera_offset_mm = [45.0, -3.0]
[sim]
seed = 5
noise = 3
background = 0.6
target_level = 0.9
spindle_camera_offset_mm = [45.03, -2.98]
)" + more);
}

inline Coupon three_by_three() {
  Coupon coupon;
  coupon.origin = position_mm<frame::Machine>(300, 100);
  return coupon;
}

/// 3 um of drill wander, 1 um of the stage.
inline SimCouponOptions usual_scatter(std::uint64_t seed) {
  SimCouponOptions options;
  options.seed = seed;
  options.wander = um(3);
  options.stage_repeatability = um(1);
  return options;
}

/// Drills and looks.
inline Expected<CouponSights> run_coupon(const MachineConfig& config,
                                         const Coupon& coupon,
                                         SimCoupon& machine) {
  const auto places = places_of_row(coupon, 0);
  PANELCAL_CHECK(drill_coupon(config, coupon, places, machine, machine, {}));
  return look_at_coupon(config, coupon, places, {machine, machine, {}});
}

}  // namespace panelcal::test
