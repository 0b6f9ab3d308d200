// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <string>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include <gmock/gmock.h>

#include "tests/machine/calibrate/spindle/coupon_toml.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using testing::HasSubstr;

SpindleCameraOffset offset_of(double x_mm) {
  SpindleCameraOffset offset;
  offset.offset = displacement_mm<frame::Machine>(x_mm, 1);
  offset.cov_mm2 = 4e-6 * Eigen::Matrix2d::Identity();
  return offset;
}

class SpindleConfigTest : public ::testing::Test {
 protected:
  Expected<MachineConfig> parse(const std::string& toml) {
    return parse_machine_config(toml, folder_.path() / "machine.toml");
  }
  std::string refusal(const std::string& toml) {
    const auto config = parse(toml);
    return config ? "accepted" : config.error().text();
  }
  /// Spindle 1 at station 1 and spindle 2 at station 2; the latter a day older.
  void write_calibration() {
    SpindleCalibration calibration;
    calibration.offsets.set({1, 1}, offset_of(45));
    calibration.offsets.set({2, 2}, offset_of(-60));
    calibration.date = *from_iso_8601("2026-11-21T02:00:00Z");
    calibration.records[{2, 2}].date = *from_iso_8601("2026-11-20T02:00:00Z");
    ASSERT_TRUE(write_spindle_calibration(folder_.path() / "s.cal.json", calibration));
  }

  test::TemporaryFolder folder_;
};

TEST_F(SpindleConfigTest, TheOffsetComesFromTheCalibration) {
  write_calibration();
  const auto config = parse("[spindle]\ncalibration = \"s.cal.json\"\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_TRUE(config->spindle_setting.is_calibrated);
  EXPECT_EQ(config->spindle_setting.file, folder_.path() / "s.cal.json");
  EXPECT_EQ(config->spindle_camera.offset.in_mm(), Eigen::Vector2d(45, 1));
  EXPECT_EQ(config->walk.uncertainty.spindle_camera_mm2, 4e-6 * Eigen::Matrix2d::Identity());
  ASSERT_TRUE(config->offset_date);
  EXPECT_TRUE(config->offset_date->is_utc);
  EXPECT_EQ(iso_8601(config->offset_date->date), "2026-11-21T02:00:00Z");
  EXPECT_TRUE(check_spindle_is_calibrated(*config));
}

TEST_F(SpindleConfigTest, EachSpindleHasItsOwnOffsetAndDate) {
  write_calibration();
  auto config = parse("[spindle]\ncalibration = \"s.cal.json\"\nnumber = 2\nstation = 2\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->spindle_camera.offset.in_mm(), Eigen::Vector2d(-60, 1));
  EXPECT_EQ(iso_8601(config->offset_date->date), "2026-11-20T02:00:00Z");
  ASSERT_TRUE(select_spindle(*config, {1, 1}));
  EXPECT_EQ(config->spindle_camera.offset.in_mm(), Eigen::Vector2d(45, 1));
  EXPECT_EQ(iso_8601(config->offset_date->date), "2026-11-21T02:00:00Z");
  ASSERT_TRUE(select_spindle(*config, {1, 2}));
  EXPECT_FALSE(config->spindle_setting.is_calibrated);
  EXPECT_FALSE(config->offset_date);
  EXPECT_THAT(select_spindle(*config, {13, 1}), FailsWith(Code::ConfigValue, "spindle 13"));
  EXPECT_THAT(select_spindle(*config, {1, 0}), FailsWith(Code::ConfigValue, "station 0"));
}

TEST_F(SpindleConfigTest, AnUncalibratedSpindleBeginsWhereMachineTomlSays) {
  write_calibration();
  auto config = parse("[spindle]\ncalibration = \"s.cal.json\"\ncamera_offset_mm = [44, 7]\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->spindle_camera.offset.in_mm(), Eigen::Vector2d(45, 1));
  ASSERT_TRUE(select_spindle(*config, {3, 1}));
  EXPECT_FALSE(config->spindle_setting.is_calibrated);
  EXPECT_EQ(config->spindle_camera.offset.in_mm(), Eigen::Vector2d(44, 7));
  ASSERT_TRUE(select_spindle(*config, {2, 2}));
  EXPECT_EQ(config->spindle_camera.offset.in_mm(), Eigen::Vector2d(-60, 1));
}

TEST_F(SpindleConfigTest, BeforeTheFirstCalibrationNoHoleIsPlaced) {
  const auto config = parse(
      "[spindle]\ncalibration = \"s.cal.json\"\ncamera_offset_mm = [44, 0]\n"
      "[uncertainty]\ndrift_um_per_sqrt_day = 1\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_FALSE(config->spindle_setting.is_calibrated);
  EXPECT_EQ(config->spindle_camera.offset.in_mm(), Eigen::Vector2d(44, 0));
  EXPECT_THAT(check_spindle_is_calibrated(*config),
              FailsWith(Code::ConfigValue, "spindle 1 at station 1"));
}

TEST_F(SpindleConfigTest, RefusesWhatContradictsACalibration) {
  EXPECT_THAT(refusal("[spindle]\ncalibration = \"s.cal.json\"\n"), HasSubstr("camera_offset_mm"));
  write_calibration();
  EXPECT_THAT(refusal("[spindle]\ncalibration = \"s.cal.json\"\nnumber = 3\n"),
              HasSubstr("spindle 3 at station 1"));
  EXPECT_THAT(refusal("[spindle]\ncalibration = \"s.cal.json\"\ncamera_offset_sigma_um = 2\n"),
              HasSubstr("machine.toml:3:"));
  EXPECT_THAT(
      refusal(
          "[spindle]\ncalibration = \"s.cal.json\"\ncamera_offset_date = 2026-11-01T00:00:00\n"),
      HasSubstr("camera_offset_date"));
  EXPECT_THAT(refusal("[spindle]\ncalibration = \"\"\n"), HasSubstr("machine.toml:2:"));
  EXPECT_THAT(refusal("[spindle]\nnumber = 13\n"), HasSubstr("machine.toml:2:"));
  EXPECT_THAT(refusal("[spindle]\nstation = 3\n"), HasSubstr("machine.toml:2:"));
}

TEST_F(SpindleConfigTest, ADamagedCalibrationIsNotTakenForNone) {
  ASSERT_TRUE(write_file(folder_.path() / "s.cal.json", "{"));
  EXPECT_THAT(refusal("[spindle]\ncalibration = \"s.cal.json\"\ncamera_offset_mm = [44, 0]\n"),
              HasSubstr("[json-syntax]"));
  // A link to nowhere is there, and cannot be read.
  std::filesystem::remove(folder_.path() / "s.cal.json");
  std::filesystem::create_symlink(folder_.path() / "gone", folder_.path() / "s.cal.json");
  EXPECT_THAT(refusal("[spindle]\ncalibration = \"s.cal.json\"\ncamera_offset_mm = [44, 0]\n"),
              HasSubstr("[file-unreadable]"));
}

TEST_F(SpindleConfigTest, TheCalibrationsDateAgesByUtc) {
  write_calibration();
  auto config = parse(
      "[spindle]\ncalibration = \"s.cal.json\"\n[uncertainty]\ndrift_um_per_sqrt_day = 0.5\n");
  ASSERT_TRUE(config) << config.error().text();
  ASSERT_TRUE(age_spindle_camera(*config, *from_iso_8601("2026-11-25T02:00:00Z")));
  // Four days: twice half a micrometre.
  EXPECT_NEAR(config->walk.uncertainty.drift_mm2(0, 0), 1e-6, 1e-15);
  EXPECT_THAT(age_spindle_camera(*config, *from_iso_8601("2026-11-21T01:59:59Z")),
              FailsWith(Code::ConfigValue, "2026-11-21T02:00:00Z"));
}

TEST_F(SpindleConfigTest, ReadsTheLedgerAndTheCoupon) {
  const auto config =
      parse("[ledger]\nfile = \"a.ledger\"\n[coupon]\norigin_mm = [1, 2]\ncolumns = 4\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->ledger_file, folder_.path() / "a.ledger");
  ASSERT_TRUE(config->coupon);
  EXPECT_EQ(config->coupon->columns, 4);
  EXPECT_EQ(config->coupon->state_file, folder_.path() / "coupon.json");
  EXPECT_THAT(refusal("[ledger]\n"), HasSubstr("file = "));
  EXPECT_THAT(refusal("[ledger]\nfile = \"\"\n"), HasSubstr("machine.toml:2:"));
  EXPECT_THAT(refusal("[ledger]\nfiles = \"a\"\n"), HasSubstr("\"file\""));
}

TEST_F(SpindleConfigTest, ReadsTheSimulatedScatterAndTheDrillCommand) {
  auto config = parse(
      "[machine]\ndrill_command = [\"./drill\", \"--tool={tool}\"]\n"
      "[sim]\nseed = 7\n[sim.coupon]\ndrill_wander_um = 3\nstage_repeatability_um = 1\n"
      "backlash_um = [2, 4]\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->sim->coupon.seed, 7u);
  EXPECT_EQ(config->sim->coupon.wander, um(3));
  EXPECT_EQ(config->sim->coupon.stage_repeatability, um(1));
  EXPECT_NEAR(config->sim->coupon.backlash.in_mm().y(), 0.004, 1e-15);
  ASSERT_EQ(config->stage.drill.size(), 2u);
  EXPECT_EQ(config->stage.drill[0], (folder_.path() / "./drill").string());
  EXPECT_THAT(refusal("[machine]\ndrill_command = [\"drill\"]\n"), HasSubstr("{tool}"));
  EXPECT_THAT(refusal("[machine]\ndrill_command = [\"drill\", \"{tool}\", \"{x}\"]\n"),
              HasSubstr("{x}"));
  EXPECT_THAT(refusal("[sim]\n[sim.coupon]\ndrill_wander_um = -1\n"), HasSubstr("drill_wander_um"));
  EXPECT_THAT(refusal("[sim]\n[sim.coupon]\nwander_um = 1\n"), HasSubstr("drill_wander_um"));
}

}  // namespace
}  // namespace panelcal
