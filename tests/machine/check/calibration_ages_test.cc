// SPDX-License-Identifier: Apache-2.0
#include "machine/check/calibration_ages.h"

#include <chrono>
#include <string>
#include <vector>

#include "calib/base/clock.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::Reports;
using testing::ElementsAre;
using testing::IsEmpty;

std::chrono::sys_seconds at(const std::string& text) {
  return *from_iso_8601(text);
}

/// Camera, one zoom level, offset and table, found on four days.
MachineConfig measured_machine() {
  MachineConfig config;
  config.camera.emplace();
  config.camera->date = at("2026-11-01T02:00:00Z");
  config.zooms[2.0].date = at("2026-11-02T02:00:00Z");
  config.offset_date = {at("2026-11-03T02:00:00Z"), {}, true};
  config.table_date = at("2026-11-04T02:00:00Z");
  config.nightly.emplace();
  config.nightly->place = {"machine.toml", 12, 1};
  config.nightly->calibrate = {"camera", "spindle-camera", "table"};
  return config;
}

std::vector<std::string> warnings_on(const MachineConfig& config, const std::string& now) {
  DiagnosticLog log;
  check_calibration_ages(config, at(now), log);
  std::vector<std::string> texts;
  for (const Diagnostic& diagnostic : log.kept()) texts.push_back(diagnostic.text());
  return texts;
}

TEST(CalibrationAges, AreWithinTrustedDaysUpToTheLastSecond) {
  EXPECT_THAT(warnings_on(measured_machine(), "2026-11-08T02:00:00Z"), IsEmpty());
  EXPECT_THAT(
      warnings_on(measured_machine(), "2026-11-08T02:00:01Z"),
      ElementsAre(Reports("machine.toml:12:1: warning[calibration-old]", "the camera's", "7.0")));
}

TEST(CalibrationAges, AreThoseOfAllThatNightsCalibrate) {
  const std::string place = "machine.toml:12:1: warning[calibration-old]";
  EXPECT_THAT(warnings_on(measured_machine(), "2026-11-12T02:00:00Z"),
              ElementsAre(Reports(place, "the camera's calibration is", "11.0 days"),
                          Reports(place, "at zoom 2 is", "10.0 days"),
                          Reports(place, "spindle-camera offset", "9.0 days"),
                          Reports(place, "the table's", "8.0 days")));
}

TEST(CalibrationAges, HaveTheLimitOfTrustedDays) {
  MachineConfig config = measured_machine();
  config.nightly->limits.old.trusted = seconds(10 * 86400.0);
  EXPECT_THAT(warnings_on(config, "2026-11-12T02:00:00Z"),
              ElementsAre(Reports(
                  "machine.toml:12:1: warning[calibration-old]", "the camera's", "10 days")));
}

/// Such a calibration is a person's own: no night promises to renew it.
TEST(CalibrationAges, OfWhatNoNightCalibratesAreNotHeldAgainstAnything) {
  MachineConfig config = measured_machine();
  config.nightly->calibrate = {"focus"};
  EXPECT_THAT(warnings_on(config, "2027-11-12T02:00:00Z"), IsEmpty());
  config.nightly.reset();
  EXPECT_THAT(warnings_on(config, "2027-11-12T02:00:00Z"), IsEmpty());
}

TEST(CalibrationAges, AreUnknownWithoutADate) {
  MachineConfig config = measured_machine();
  config.offset_date.reset();
  config.table_date.reset();
  config.nightly->calibrate = {"spindle-camera", "table"};
  EXPECT_THAT(warnings_on(config, "2027-11-12T02:00:00Z"), IsEmpty());
}

}  // namespace
}  // namespace panelcal
