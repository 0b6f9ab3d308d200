// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "calib/camera/calibration/calibration_file.h"
#include "machine/config/machine_config.h"

#include "tests/machine/calibrate/spindle/coupon_job.h"

namespace panelcal::test {

/// As coupon_machine, and all that an installation needs: a coupon of six rows, a ledger, a
/// calibration's file that is not there yet. The simulated drill wanders by 3 um, the stage by 1.
inline std::string spindle_toml(const std::string& spindle = "", const std::string& more = "") {
  return R"([machine]
name = "drill 1"
travel_low_mm = [0, 0]
travel_high_mm = [600, 500]
[vision]
search_radius_mm = 0.5
[[vision.tool]]
number = 1
shape = "hole"
size_mm = 0.8
[camera]
calibration = "camera.cal.json"
[spindle]
calibration = "spindle.cal.json"
camera_offset_mm = [45.0, -3.0]
)" + spindle +
         R"([coupon]
name = "A"
origin_mm = [300, 100]
rows = 6
approaches = ["+x+y", "-x-y"]
[ledger]
file = "drill1.ledger"
[sim]
seed = 5
noise = 3
background = 0.6
target_level = 0.9
spindle_camera_offset_mm = [45.03, -2.98]
[sim.coupon]
drill_wander_um = 3
stage_repeatability_um = 1
)" + more;
}

/// Writes machine.toml and its camera into a folder, and reads them.
inline Expected<MachineConfig> spindle_machine(const std::filesystem::path& folder,
                                               const std::string& toml = spindle_toml()) {
  PANELCAL_CHECK(write_camera_calibration(folder / "camera.cal.json", test_camera(240, 220)));
  PANELCAL_CHECK(write_file(folder / "machine.toml", toml));
  return read_machine_config(folder / "machine.toml");
}

}  // namespace panelcal::test
