// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <string_view>
#include <vector>

#include "machine/config/machine_config.h"
#include "machine/sim/sim_table_surface.h"
#include "machine/sim/simulated_probe.h"
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

constexpr std::string_view kCamera = "[camera]\ncalibration = \"camera.cal.json\"\n";

/// [sim] from line 3 on.
Expected<MachineConfig> parse(std::string_view sim) {
  const test::TemporaryFolder folder;
  return test::config_with_camera(folder.path(),
                                  test::test_camera(320, 240),
                                  std::string(kCamera) + "[sim]\n" + std::string(sim));
}

/// Without the folder, which is another one each time.
std::string refusal(std::string_view sim) {
  const auto config = parse(sim);
  if (config) return "accepted";
  const std::string text = test::brief(config.error());
  return text.substr(text.find("machine.toml"));
}

TEST(SimConfig, DefaultsAreAnIdealMachine) {
  const auto config = parse("");
  ASSERT_TRUE(config) << config.error().text();
  ASSERT_TRUE(config->sim);
  EXPECT_EQ(config->sim->seed, 1u);
  EXPECT_EQ(config->sim->panel_offset.in_mm(), Eigen::Vector2d(0, 0));
  EXPECT_FALSE(config->sim->camera);
  EXPECT_FALSE(config->sim->spindle_camera_offset);
  EXPECT_EQ(config->sim->width_px, 320);
  EXPECT_EQ(config->sim->height_px, 240);
  EXPECT_EQ(config->sim->noise, 0);
  EXPECT_EQ(config->sim->surface.noise_sigma, Length());
  EXPECT_EQ(config->sim->surface.bow, Length());
  EXPECT_EQ(config->sim->surface.axis_offsets.size(), 1u);
}

TEST(SimConfig, ReadsEveryKey) {
  const auto config = parse(R"(
seed = 9223372036854775807
panel_offset_mm = [0.4, -0.2]
panel_rotation_mrad = 2
stretch_ppm = [200, -100]
board_offset_sigma_um = 50
board_rotation_sigma_mrad = 0.3
spindle_camera_offset_mm = [45.1, -3]
picture_px = [320, 240]
blur_px = 1.5
noise = 3
background = 0.25
target_level = 0.8
light_gradient = -0.1
vignetting = 0.2
weave_amplitude = 0.05
neighbors = 4
light_gradient_y = 0.05
weave_period_mm = 0.4
bit_depth = 16
shot_noise = 0.02
hot_pixels = 1e-4
tilt_deg = 3
tilt_axis_deg = 40
burrs_um = 6
ring_offset_sigma_um = 12
slot_length_mm = 2.5
[sim.debris]
rim_share = 0.1
size_um = 60
darkest = 0.2
brightest = 0.6
scratches = 2
scratch_width_um = 9
scratch_length_mm = 0.7
[sim.surface]
height_mm = 1.55
slope_ppm = [120, -80]
bow_um = -40
bow_center_mm = [150, 100]
bow_radius_mm = 180
axis_offsets_um = [0, 12.5]
noise_um = 2
[sim.camera]
scale_mm_per_px = 0.0101
rotation_rad = 0.01
k1_per_px2 = 1e-8
axis_px = [160, 120]
)");
  ASSERT_TRUE(config) << config.error().text();
  const SimConfig& sim = *config->sim;
  EXPECT_EQ(sim.seed, 9223372036854775807u);
  EXPECT_EQ(sim.panel_offset.in_mm(), Eigen::Vector2d(0.4, -0.2));
  EXPECT_EQ(sim.panel_rotation, rad(2e-3));
  EXPECT_EQ(sim.stretch_x_ppm, 200);
  EXPECT_EQ(sim.stretch_y_ppm, -100);
  EXPECT_EQ(sim.board_offset_sigma, um(50));
  EXPECT_EQ(sim.board_rotation_sigma, rad(0.3e-3));
  EXPECT_EQ(sim.spindle_camera_offset->in_mm(), Eigen::Vector2d(45.1, -3));
  EXPECT_EQ(sim.blur_px, 1.5);
  EXPECT_EQ(sim.noise, 3);
  EXPECT_EQ(sim.background, 0.25);
  EXPECT_EQ(sim.target_level, 0.8);
  EXPECT_EQ(sim.light_gradient, -0.1);
  EXPECT_EQ(sim.vignetting, 0.2);
  EXPECT_EQ(sim.weave_amplitude, 0.05);
  EXPECT_EQ(sim.neighbors, 4);
  EXPECT_EQ(sim.light_gradient_y, 0.05);
  EXPECT_EQ(sim.weave_period, mm(0.4));
  EXPECT_EQ(sim.full_scale, 65535);
  EXPECT_EQ(sim.shot_noise, 0.02);
  EXPECT_EQ(sim.hot_pixels, 1e-4);
  EXPECT_EQ(sim.tilt, deg(3));
  EXPECT_EQ(sim.tilt_axis, deg(40));
  EXPECT_EQ(sim.burrs, um(6));
  EXPECT_EQ(sim.ring_offset_sigma, um(12));
  EXPECT_EQ(sim.slot_length, mm(2.5));
  EXPECT_EQ(sim.debris.rim_share, 0.1);
  EXPECT_EQ(sim.debris.size, um(60));
  EXPECT_EQ(sim.debris.darkest, 0.2);
  EXPECT_EQ(sim.debris.brightest, 0.6);
  EXPECT_EQ(sim.debris.scratches, 2);
  EXPECT_EQ(sim.debris.scratch_width, um(9));
  EXPECT_EQ(sim.debris.scratch_length, mm(0.7));
  EXPECT_EQ(sim.surface.seed, 9223372036854775807u);
  EXPECT_EQ(sim.surface.height, mm(1.55));
  EXPECT_EQ(sim.surface.slope_x_ppm, 120);
  EXPECT_EQ(sim.surface.slope_y_ppm, -80);
  EXPECT_EQ(sim.surface.bow, um(-40));
  EXPECT_EQ(sim.surface.bow_center, position_mm<frame::Actual>(150, 100));
  EXPECT_EQ(sim.surface.bow_radius, mm(180));
  EXPECT_EQ(sim.surface.axis_offsets, (std::vector<Length>{um(0), um(12.5)}));
  EXPECT_EQ(sim.surface.noise_sigma, um(2));
  EXPECT_EQ(sim.camera->scale_mm_per_px, 0.0101);
  EXPECT_EQ(sim.camera->rotation_rad, 0.01);
  EXPECT_EQ(sim.camera->k1_per_px2, 1e-8);
  EXPECT_EQ(sim.camera->axis_px, Eigen::Vector2d(160, 120));
}

TEST(SimConfig, SurfaceIsWhereItIsExpectedWhereNothingElseIsSaid) {
  const auto config =
      parse_machine_config("[surface]\nheight_mm = 1.6\n[sim]\nseed = 3\n", "machine.toml");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->sim->surface.height, mm(1.6));
  EXPECT_EQ(config->sim->surface.seed, 3u);
}

TEST(SimConfig, RefusesSurfacesThatMakeNoSense) {
  EXPECT_EQ(refusal("[sim.surface]\naxis_offsets_um = []\n"),
            "machine.toml:5:19: error[config-value]");
  EXPECT_EQ(refusal("[sim.surface]\naxis_offsets_um = 3\n"),
            "machine.toml:5:19: error[config-value]");
  EXPECT_EQ(refusal("[sim.surface]\naxis_offsets_um = [1, \"2\"]\n"),
            "machine.toml:5:23: error[config-value]");
  EXPECT_EQ(refusal("[sim.surface]\nbow_radius_mm = 0\n"),
            "machine.toml:5:17: error[config-value]");
  EXPECT_EQ(refusal("[sim.surface]\nslope_x_ppm = 3\n"),
            "machine.toml:5:1: error[config-key-unknown]");
}

TEST(SimConfig, TheTablesSurfaceMovesFromItsDateOn) {
  const auto config = parse_machine_config(R"([sim]
seed = 3
[sim.table_surface]
height_mm = 0.2
slope_ppm = [80, -30]
noise_um = 3
since = 2026-11-01T00:00:00
height_um_per_day = 2
slope_ppm_per_day = [5, 1]
chip_mm = [180, 100]
chip_radius_mm = 8
chip_depth_um = 300
chip_since = 2026-11-05T00:00:00
)",
                                           "machine.toml");
  ASSERT_TRUE(config) << config.error().text();
  const SimTableSurface& table = *config->sim->table_surface;
  const auto day = [&](int number) { return table.since + std::chrono::days(number); };
  SimulatedProbeOptions now = surface_at(table, day(-7));
  EXPECT_EQ(now.height, mm(0.2));
  EXPECT_EQ(now.slope_x_ppm, 80);
  EXPECT_FALSE(now.chip);
  now = surface_at(table, day(4));
  EXPECT_NEAR(now.height.in_mm(), 0.208, 1e-12);
  EXPECT_EQ(now.slope_x_ppm, 100);
  EXPECT_EQ(now.slope_y_ppm, -26);
  ASSERT_TRUE(now.chip);
  EXPECT_EQ(now.chip->depth, um(300));
  // Another night another noise, the same night the same.
  EXPECT_EQ(now.seed, surface_at(table, day(4)).seed);
  EXPECT_NE(now.seed, surface_at(table, day(5)).seed);
  auto probe = SimulatedProbe::create(now);
  ASSERT_TRUE(probe) << probe.error().text();
  const auto height_mm = [&](double x_mm) {
    return probe->true_height(position_mm<frame::Actual>(x_mm, 100), 0).in_mm();
  };
  EXPECT_NEAR(height_mm(180) - height_mm(190), -0.3 - 10 * 100e-6, 1e-12)
      << "in the chip, beside it";
}

TEST(SimConfig, RefusesTableSurfacesThatMakeNoSense) {
  EXPECT_EQ(refusal("[sim.table_surface]\nheight_um_per_day = 2\n"),
            "machine.toml:5:21: error[config-value]");
}

TEST(SimConfig, RefusesPicturesThatMakeNoSense) {
  EXPECT_EQ(refusal("bit_depth = 12\n"), "machine.toml:4:13: error[config-value]");
  EXPECT_EQ(refusal("tilt_deg = 90\n"), "machine.toml:4:12: error[config-value]");
  EXPECT_EQ(refusal("[sim.debris]\nrim_share = 1\n"), "machine.toml:5:13: error[config-value]");
  EXPECT_EQ(refusal("[sim.debris]\nbrightest = 0.1\ndarkest = 0.5\n"),
            "machine.toml:6:11: error[config-value]");
  EXPECT_EQ(refusal("[sim.debris]\nsize_mm = 1\n"), "machine.toml:5:1: error[config-key-unknown]");
}

TEST(SimConfig, RealCameraIsAsCalibratedWhereNothingElseIsSaid) {
  const auto config = parse("[sim.camera]\nrotation_rad = 0.01\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->sim->camera->rotation_rad, 0.01);
  EXPECT_EQ(config->sim->camera->axis_px, config->camera->parameters.axis_px);
}

TEST(SimConfig, RefusesWhatMakesNoSense) {
  EXPECT_EQ(refusal("panel_offset_um = [1, 2]\n"), "machine.toml:4:1: error[config-key-unknown]");
  EXPECT_EQ(refusal("seed = -1\n"), "machine.toml:4:8: error[config-value]");
  EXPECT_EQ(refusal("noise = -1\n"), "machine.toml:4:9: error[config-value]");
  EXPECT_EQ(refusal("blur_px = 0\n"), "machine.toml:4:11: error[config-value]");
  EXPECT_EQ(refusal("neighbors = 2.5\n"), "machine.toml:4:13: error[config-value]");
  EXPECT_EQ(refusal("stretch_ppm = 200\n"), "machine.toml:4:15: error[config-value]");
  EXPECT_EQ(refusal("picture_px = [640, 480]\n"), "machine.toml:4:14: error[config-value]");
  EXPECT_EQ(refusal("picture_px = [320.5, 240]\n"), "machine.toml:4:14: error[config-value]");
  EXPECT_EQ(refusal("background = 0.8\n"), "machine.toml:4:14: error[config-value]");
  EXPECT_EQ(refusal("target_level = 0.1\n"), "machine.toml:4:16: error[config-value]");
  EXPECT_EQ(refusal("[sim.camera]\nscale_mm_per_px = 0\n"),
            "machine.toml:5:19: error[config-value]");
  EXPECT_EQ(refusal("[sim.camera]\nk1_per_px2 = -1e-4\n"),
            "machine.toml:5:14: error[config-value]");
}

TEST(SimConfig, RealCameraNeedsACalibratedOne) {
  const auto config = parse_machine_config("[sim.camera]\nrotation_rad = 0.01\n", "machine.toml");
  ASSERT_FALSE(config);
  EXPECT_EQ(test::brief(config.error()), "machine.toml:1:1: error[config-value]");
}

}  // namespace
}  // namespace panelcal
