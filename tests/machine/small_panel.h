// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "program/walk/walk.h"

#include "tests/machine/virtual_machine.h"

namespace panelcal::test {

/// Three panel fiducials, then two boards of two, each with a hole: seq 0 to 6.
inline constexpr std::string_view kSmallProgram = R"(M48
METRIC,TZ
FMAT,2
VER,1
T1C0.8
%
G90
G34,1
G36X5.0Y5.0
G36X65.0Y5.0
G36X5.0Y45.0
$uvis,alg,0,2
G34,2
M50,1
M25
G46X10.0Y10.0
G46X30.0Y40.0
M01
R1M02X30.0
M02
M08
T1
M51,1
M25
M52,2
X20.0Y20.0
M01
R1M02X30.0
M02
M08
M30
)";

/// The same with one line in front of its first target.
inline std::string small_program_with(std::string_view line) {
  std::string text(kSmallProgram);
  return text.insert(text.find("G36"), std::string(line) + "\n");
}

/// A machine whose camera is calibrated exactly, but for what `sim` says; `vision` stands behind
/// [vision].
inline std::string small_config_text(std::string_view sim, std::string_view vision = "") {
  return "[vision]\n" + std::string(vision) + R"(
search_radius_mm = 0.9
[[vision.tool]]
number = 1
shape = "disc"
size_mm = 0.9
[[vision.tool]]
number = 2
shape = "ring"
size_mm = 0.8
inner_mm = 0.4
polarity = "dark"
[camera]
calibration = "camera.cal.json"
[spindle]
camera_offset_mm = [45.0, -3.0]
[program]
work_zero_mm = [100.0, 50.0]
[sim]
seed = 5
panel_offset_mm = [0.3, -0.2]
panel_rotation_mrad = 1.5
stretch_ppm = [150, -80]
board_offset_sigma_um = 40
board_rotation_sigma_mrad = 0.3
noise = 3
background = 0.4
target_level = 0.75
)" + std::string(sim);
}

inline MachineConfig small_config(const std::filesystem::path& folder,
                                  std::string_view sim = "",
                                  std::string_view vision = "") {
  const auto config =
      config_with_camera(folder, test_camera(280, 240), small_config_text(sim, vision));
  EXPECT_TRUE(config) << config.error().text();
  return config ? *config : MachineConfig();
}

}  // namespace panelcal::test
