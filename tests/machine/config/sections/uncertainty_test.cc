// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "calib/base/clock.h"
#include <gmock/gmock.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kUm2 = 1e-6;  // in mm^2

Expected<MachineConfig> parse(std::string_view text) {
  return parse_machine_config(text, "machine.toml");
}

std::string refusal(std::string_view text) {
  const auto config = parse(text);
  return config ? "accepted" : config.error().text();
}

std::chrono::sys_seconds at(std::string_view time) {
  return *from_iso_8601(std::string(time) + "Z");
}

constexpr std::string_view kAll = R"([spindle]
camera_offset_sigma_um = 0.5
camera_offset_date = 2026-11-01T06:00:00
[uncertainty]
stage_repeatability_um = 1.5
table_residual_um = 2
drill_wander_um = 3
depth_um = 6
drift_um_per_sqrt_day = 0.25
)";

TEST(UncertaintyConfig, IsNothingUnlessStated) {
  const auto config = parse("");
  ASSERT_TRUE(config) << config.error().text();
  const MachineUncertainty& machine = config->walk.uncertainty;
  EXPECT_EQ(machine.of_target_mm2(), Eigen::Matrix2d::Zero());
  EXPECT_EQ(machine.of_hole_mm2(), Eigen::Matrix2d::Zero());
  EXPECT_EQ(machine.shared_mm2(), Eigen::Matrix2d::Zero());
  EXPECT_EQ(machine.camera, CameraCovariance::Zero());
  EXPECT_EQ(machine.n_cameras(), 1);
}

TEST(UncertaintyConfig, KnowsAZeroThatIsStated) {
  using testing::ElementsAre;
  EXPECT_THAT(parse("")->walk.uncertainty.unstated(),
              ElementsAre("stage repeatability", "table residual", "drill wander"));
  EXPECT_THAT(parse("[uncertainty]\nstage_repeatability_um = 0\ntable_residual_um = 2\n")
                  ->walk.uncertainty.unstated(),
              ElementsAre("drill wander"));
  EXPECT_THAT(parse(kAll)->walk.uncertainty.unstated(), testing::IsEmpty());
}

TEST(UncertaintyConfig, ReadsEveryTerm) {
  auto config = parse(kAll);
  ASSERT_TRUE(config) << config.error().text();
  const MachineUncertainty& machine = config->walk.uncertainty;
  EXPECT_EQ(machine.stage_repeatability, um(1.5));
  EXPECT_EQ(machine.table_residual, um(2));
  EXPECT_EQ(machine.drill_wander, um(3));
  EXPECT_EQ(machine.depth, um(6));
  EXPECT_DOUBLE_EQ(machine.spindle_camera_mm2(0, 0), 0.25 * kUm2);
  EXPECT_DOUBLE_EQ(machine.of_target_mm2()(0, 0), 6.25 * kUm2);
  EXPECT_DOUBLE_EQ(machine.of_hole_mm2()(1, 1), 15.25 * kUm2);
  EXPECT_EQ(machine.drift_mm2, Eigen::Matrix2d::Zero());
}

TEST(UncertaintyConfig, TheOffsetDriftsAsARandomWalkFromItsDate) {
  auto config = parse(kAll);
  ASSERT_TRUE(config) << config.error().text();
  // 9 days: 3 times 0.25 um. 6 hours: half of it.
  ASSERT_TRUE(age_spindle_camera(*config, at("2026-11-10T06:00:00")));
  EXPECT_NEAR(config->walk.uncertainty.drift_mm2(0, 0), 0.5625 * kUm2, 1e-18);
  EXPECT_EQ(config->walk.uncertainty.drift_mm2(0, 1), 0);
  ASSERT_TRUE(age_spindle_camera(*config, at("2026-11-01T12:00:00")));
  EXPECT_NEAR(config->walk.uncertainty.drift_mm2(1, 1), 0.015625 * kUm2, 1e-18);
  ASSERT_TRUE(age_spindle_camera(*config, at("2026-11-01T06:00:00")));
  EXPECT_EQ(config->walk.uncertainty.drift_mm2, Eigen::Matrix2d::Zero());
}

TEST(UncertaintyConfig, RefusesADateInTheFuture) {
  auto config = parse(kAll);
  ASSERT_TRUE(config) << config.error().text();
  const auto aged = age_spindle_camera(*config, at("2026-11-01T05:59:59"));
  ASSERT_FALSE(aged);
  EXPECT_THAT(aged.error().text(),
              AllOf(HasSubstr("machine.toml:3:"), HasSubstr("2026-11-01T06:00:00")));
}

TEST(UncertaintyConfig, RefusesDatesThatNoWallShows) {
  for (const char* date : {"2026-11-01T06:00:00Z",
                           "2026-11-01T06:00:00+01:00",
                           "2026-11-01",
                           "06:00:00",
                           "\"2026-11-01T06:00:00\"",
                           "20261101"}) {
    EXPECT_THAT(refusal(std::string("[spindle]\ncamera_offset_date = ") + date + "\n"),
                AllOf(HasSubstr("machine.toml:2:"), HasSubstr("error[config-value]")))
        << date;
  }
}

TEST(UncertaintyConfig, RefusesADriftSinceNobodyKnowsWhen) {
  EXPECT_THAT(refusal("[uncertainty]\ndrift_um_per_sqrt_day = 1\n"),
              AllOf(HasSubstr("machine.toml:2:"), HasSubstr("camera_offset_date")));
  EXPECT_EQ(refusal("[uncertainty]\ndrift_um_per_sqrt_day = 0\n"), "accepted");
}

TEST(UncertaintyConfig, RefusesBadNumbersAndUnknownKeys) {
  EXPECT_THAT(refusal("[uncertainty]\ndrill_wander_um = -1\n"), HasSubstr("machine.toml:2:"));
  EXPECT_THAT(refusal("[uncertainty]\nstage_repeatability_um = nan\n"),
              HasSubstr("machine.toml:2:"));
  EXPECT_THAT(refusal("[uncertainty]\ntable_residuals_um = 1\n"),
              HasSubstr("\"table_residual_um\""));
  EXPECT_THAT(refusal("[uncertainties]\n"), HasSubstr("\"uncertainty\""));
}

TEST(UncertaintyConfig, TakesTheCovariancesOfAllCameras) {
  const test::TemporaryFolder folder;
  CameraCalibration camera = test::test_camera(320, 240);
  camera.covariance(2, 2) = 0.01;
  ASSERT_TRUE(write_camera_calibration(folder.path() / "zoom.cal.json", camera));
  camera.covariance(2, 2) = 0.04;
  const auto config = test::config_with_camera(folder.path(), camera, R"(
[camera]
calibration = "camera.cal.json"
[[camera.zoom]]
level = 3
calibration = "zoom.cal.json"
)");
  ASSERT_TRUE(config) << config.error().text();
  const MachineUncertainty& machine = config->walk.uncertainty;
  EXPECT_EQ(machine.camera(2, 2), 0.04);
  EXPECT_EQ(machine.camera_of(machine.camera_index(3.0))(2, 2), 0.01);
}

}  // namespace
}  // namespace panelcal
