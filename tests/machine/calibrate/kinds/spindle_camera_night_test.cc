// SPDX-License-Identifier: Apache-2.0
// The nightly run with the calibration that it is for, through pictures.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>

#include "calib/camera/calibration/calibration_file.h"
#include "machine/calibrate/kinds/kinds.h"
#include "machine/calibrate/kinds/spindle_camera.h"
#include "machine/nightly/record/night_history.h"
#include "machine/sources/device_set.h"
#include <gmock/gmock.h>

#include "tests/machine/nightly/picture_night.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using testing::Contains;
using testing::HasSubstr;

TEST(SpindleCameraNight, MeasuresInstallsAndReportsWhatAPersonWantsToSee) {
  const test::PictureNights nights;
  const auto record = nights.run(5, {});
  ASSERT_TRUE(record) << record.error().text();
  ASSERT_EQ(exit_code(*record), 0) << record->verdict;
  const NightStep& step = record->steps.at(0);
  EXPECT_EQ(step.subject, "spindle 1 station 1");
  // 5 sigma of 1.2 um.
  ASSERT_TRUE(nights.installed_mm());
  EXPECT_NEAR(nights.installed_mm()->x(), 45.02, 0.006);
  EXPECT_NEAR(nights.installed_mm()->y(), -3.0, 0.006);
  EXPECT_EQ(*step.axes[0].new_value, nights.installed_mm()->x());
  EXPECT_EQ(step.holes.size(), 9u);
  EXPECT_FALSE(step.fit_report.empty());
  ASSERT_EQ(step.qualities.size(), 4u);
  // Drill wander of 3 um, two stops of 1 um; 16 degrees of freedom, 4 sigma.
  EXPECT_EQ(step.qualities[0].name, "holes about the fit");
  EXPECT_NEAR(step.qualities[0].value, 0.0033, 4 * 0.0033 / std::sqrt(2 * 16.0));
  EXPECT_EQ(step.qualities[1].name, "looks at a hole");
  EXPECT_EQ(step.qualities[2].name, "contrast of holes");
  // [sim] target_level against background.
  EXPECT_NEAR(step.qualities[2].value, 0.3, 0.02);
  const auto ledger = Ledger::open_to_read(nights.ledger_file());
  ASSERT_TRUE(ledger) << ledger.error().text();
  const auto entry = ledger->entry(*step.ledger_id);
  ASSERT_TRUE(entry);
  EXPECT_EQ(entry->record.verdict, LedgerVerdict::Installed);
  EXPECT_EQ(entry->record.inputs.size(), 2u);
}

/// The holes are drilled by then: nothing but the offset itself may keep it from being recorded.
TEST(SpindleCameraNight, HashesItsInputsBeforeItDrills) {
  const test::PictureNights nights;
  const auto config = nights.config();
  ASSERT_TRUE(config) << config.error().text();
  const auto set = DeviceSet::simulated(*config, nights.now);
  ASSERT_TRUE(set) << set.error().text();
  CalibrationDevices devices = set->devices();
  devices.observer = [&](const SeenView&) { std::filesystem::remove(config->camera_file); };
  const std::string before = input_of(config->camera_file).value().sha256;
  const auto result = spindle_camera_kind(std::make_shared<MachineConfig>(*config))
                          ->measure(devices, {nights.now, {}, "", "timer", "panelcal test"});
  ASSERT_TRUE(result) << result.error().text();
  EXPECT_FALSE(std::filesystem::exists(config->camera_file));
  EXPECT_EQ(result->draft.record.inputs.at(1).sha256, before);
}

TEST(SpindleCameraNight, AnUsedUpCouponKeepsOrHoldsAndTheNightStaysOpen) {
  test::PictureNights nights;
  for (int run = 0; run < 3; ++run) {
    ASSERT_TRUE(nights.run(static_cast<std::uint64_t>(run), {}));
    nights.now += std::chrono::days(1);
  }
  auto record = nights.run(9, {});
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_EQ(exit_code(*record), 1);
  EXPECT_THAT(record->verdict, HasSubstr("1 of 10"));
  nights.coupon = "B";
  record = nights.run(9, {});
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_EQ(exit_code(*record), 0) << record->verdict;
}

TEST(SpindleCameraNight, RowsOfARunThatWasCutOffAreSaid) {
  const test::PictureNights nights;
  ASSERT_TRUE(nights.run(1, {}));
  const auto config = nights.config();
  ASSERT_TRUE(config && take_rows(*config, {fixed_clock(nights.now), "a person", "panelcal test"}));
  const auto record = nights.run(2, {});
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_THAT(record->notes, Contains(HasSubstr("3 rows of the coupon")));
}

/// An older file put back, or none: the holes are there all the same.
TEST(SpindleCameraNight, NeverDrillsIntoRowsThatTheLedgerHas) {
  test::PictureNights nights;
  ASSERT_TRUE(nights.run(1, {}));
  auto config = nights.config();
  ASSERT_TRUE(config);
  const std::filesystem::path state = config->coupon->state_file;
  const std::string older = read_file(state).value();
  nights.now += std::chrono::days(1);
  ASSERT_TRUE(nights.run(2, {}));
  nights.now += std::chrono::days(1);
  ASSERT_TRUE(write_file(state, older));
  const auto record = nights.run(3, {});
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_EQ(exit_code(*record), 0) << record->verdict;
  EXPECT_EQ(used_rows(*config)->by_file, 9);
  const auto coupon = std::ranges::find(record->checks, "coupon", &SelfTestCheck::name);
  ASSERT_NE(coupon, record->checks.end());
  EXPECT_THAT(coupon->text, HasSubstr("3 rows used, the ledger 6"));
  std::filesystem::remove(state);
  nights.now += std::chrono::days(1);
  const auto full = nights.run(4, {});
  ASSERT_TRUE(full) << full.error().text();
  EXPECT_EQ(exit_code(*full), 1);
  EXPECT_THAT(full->verdict, HasSubstr("1 of 10"));
}

TEST(CameraNight, ComesBeforeTheOffsetAndIsInstalledForIt) {
  test::PictureNights nights;
  // Views of the mark have to come near the corners, for k1 to be known there.
  nights.width_px = 480;
  nights.height_px = 420;
  nights.nightly =
      "[nightly]\nmachine_driver = \"sim\"\nmin_disk_mb = 0\nmark_mm = [280, 100]\n"
      "calibrate = [\"spindle-camera\", \"camera\"]\n"
      "[uncertainty]\nstage_repeatability_um = 1\n";
  auto record = nights.run(4, {});
  ASSERT_TRUE(record) << record.error().text();
  ASSERT_EQ(exit_code(*record), 0) << record->verdict;
  ASSERT_EQ(record->steps.size(), 2u);
  EXPECT_EQ(record->steps[0].kind, "camera");
  EXPECT_EQ(record->steps[1].kind, "spindle-camera");
  const auto camera = read_camera_calibration(nights.camera_file());
  ASSERT_TRUE(camera) << camera.error().text();
  ASSERT_TRUE(camera->full);
  // Half the diagonal of the picture at 10 um a pixel; the turn is 4 mrad.
  const NightStep& step = record->steps[0];
  const double radius_mm = 0.01 * 0.5 * std::hypot(nights.width_px, nights.height_px);
  EXPECT_NEAR(*step.axes[0].new_value, radius_mm, 5 * *step.axes[0].new_sigma);
  EXPECT_NEAR(*step.axes[1].new_value, 0.004 * radius_mm, 5 * *step.axes[1].new_sigma);
  EXPECT_LT(*step.axes[0].new_sigma, 0.003);
  // The mark's own looks are there, and the file is what the ledger says.
  EXPECT_GE(record->checks.size(), 6u);
  const auto ledger = Ledger::open_to_read(nights.ledger_file());
  ASSERT_TRUE(ledger);
  EXPECT_EQ(ledger->result(*step.ledger_id).value_or(""),
            read_file(nights.camera_file()).value_or("none"));
  record = nights.run(5, {});
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_TRUE(record->steps[0].is_from_earlier_run);
}

/// Nights of the camera alone, with what the real one is like and the limits.
void set_up_camera_nights(const std::string& gates,
                          const std::string& camera,
                          test::PictureNights& nights) {
  nights.nightly = "[sim.camera]\n" + camera +
                   "[nightly]\nmachine_driver = \"sim\"\nmin_disk_mb = 0\n"
                   "mark_mm = [280, 100]\ncalibrate = [\"camera\"]\n[nightly.gates]\n" +
                   gates;
}

std::string refused_gates(const NightStep& step) {
  std::string names;
  if (!step.decision) return "no decision";
  for (const NightGate& gate : step.decision->gates) {
    if (!gate.passed) names += gate.name + " ";
  }
  return names;
}

TEST(CameraNight, HoldsALensThatHasChangedThoughScaleAndRotationHaveNot) {
  // At the corner, 106 px from the axis, 2.4 px or 24 um.
  test::PictureNights nights;
  set_up_camera_nights("change_um = 10",
                       "scale_mm_per_px = 0.01\nrotation_rad = 0.004\nk1_per_px2 = 2e-6\n",
                       nights);
  ASSERT_TRUE(nights.config());
  const auto before = read_file(nights.camera_file());
  const auto record = nights.run(6, {});
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_EQ(record->steps[0].state, NightState::Held) << record->verdict;
  EXPECT_THAT(refused_gates(record->steps[0]), HasSubstr("change")) << record->verdict;
  EXPECT_THAT(record->verdict, HasSubstr("corner of the picture"));
  EXPECT_EQ(read_file(nights.camera_file()).value_or("none"), before.value_or("nothing"));
}

TEST(CameraNight, HoldsWhatViewsOfTheMiddleDoNotSayOfTheCorners) {
  // The mark fills more than half of the picture: its views are up to 25 px from the axis, the
  // corner is 106 px from it. What k1 does there is a guess, though a flat camera would do.
  test::PictureNights nights;
  set_up_camera_nights("", "rotation_rad = 0.004\n", nights);
  ASSERT_TRUE(nights.config());
  const auto record = nights.run(4, {});
  ASSERT_TRUE(record) << record.error().text();
  const NightStep& step = record->steps.at(0);
  EXPECT_EQ(step.state, NightState::Held);
  EXPECT_EQ(refused_gates(step), "corners ");
  EXPECT_THAT(record->verdict, HasSubstr("limit 3.0 um; a mark that is smaller in the picture"));
  EXPECT_THAT(step.fit_report, testing::Contains(HasSubstr("; a flat camera would do")));
}

TEST(CameraNight, NamesTheScatterThatNoSmallerMarkCures) {
  // Views come near the corners; the stage comes back by 1 um along x and y, 1.4 um in all.
  test::PictureNights nights;
  nights.width_px = 480;
  nights.height_px = 420;
  set_up_camera_nights("sigma_um = 1\n[uncertainty]\nstage_repeatability_um = 1\n",
                       "rotation_rad = 0.004\n",
                       nights);
  const auto record = nights.run(4, {});
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_EQ(refused_gates(record->steps.at(0)), "uncertainty corners ");
  EXPECT_THAT(record->verdict, HasSubstr("limit 1.0 um; the views scatter by more than that"));
}

TEST(CameraNight, RefusesOneThatIsNotSureAtTheCorners) {
  test::PictureNights nights;
  set_up_camera_nights("sigma_um = 0.001", "rotation_rad = 0.004\n", nights);
  ASSERT_TRUE(nights.config());
  const auto before = read_file(nights.camera_file());
  const auto record = nights.run(7, {});
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_THAT(refused_gates(record->steps.at(0)), HasSubstr("corners"));
  EXPECT_NE(record->steps[0].state, NightState::Installed);
  EXPECT_EQ(read_file(nights.camera_file()).value_or("none"), before.value_or("nothing"));
}

TEST(CameraNight, SaysWhatTheMarkDoesThoughItRefusesNothing) {
  test::PictureNights nights;
  set_up_camera_nights("", "rotation_rad = 0.004\n", nights);
  const auto config = nights.config();
  ASSERT_TRUE(config) << config.error().text();
  {
    // 20 nights of half the contrast: tonight is a step to the good side.
    auto time = nights.now - std::chrono::days(30);
    auto ledger = Ledger::open(nights.ledger_file(), [&] { return time; });
    ASSERT_TRUE(ledger) << ledger.error().text();
    for (int night = 0; night < 20; ++night) {
      time += std::chrono::days(1);
      QualityNight quality;
      quality.levels = {{"contrast of the mark", "1", 0.15 + 0.0003 * (night % 3), true}};
      const auto entry =
          ledger->append(self_test_draft(machine_name(*config),
                                         quality,
                                         {.date = time, .asked_by = "timer", .software = "test"},
                                         ""));
      ASSERT_TRUE(entry) << entry.error().text();
    }
  }
  const auto record = nights.run(8, {});
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_THAT(record->notes, Contains(HasSubstr("contrast of the mark has jumped to the good")));
  const auto check =
      std::ranges::find(record->checks, "contrast of the mark", &SelfTestCheck::name);
  ASSERT_NE(check, record->checks.end());
  EXPECT_TRUE(check->passed);
  EXPECT_THAT(check->text, HasSubstr("jumped"));
}

TEST(SpindleCameraNight, NamesWhatMachineTomlLacks) {
  const test::PictureNights nights;
  auto config = nights.config();
  ASSERT_TRUE(config) << config.error().text();
  const auto refusal = [&](const MachineConfig& lacking) {
    const auto made = NightCalibrations::make(lacking, *lacking.nightly);
    return made ? std::string("made") : made.error().text();
  };
  MachineConfig lacking = *config;
  lacking.coupon.reset();
  EXPECT_THAT(refusal(lacking), HasSubstr("[coupon]"));
  lacking = *config;
  lacking.coupon->has_entry_material = true;
  EXPECT_EQ(refusal(lacking), "made");  // a simulated coupon has no entry material
  lacking.nightly->is_simulated = false;
  EXPECT_THAT(refusal(lacking), HasSubstr("entry material"));
  lacking = *config;
  lacking.camera.reset();
  EXPECT_THAT(refusal(lacking), HasSubstr("[camera]"));
  lacking = *config;
  lacking.spindle_setting.file.clear();
  EXPECT_THAT(refusal(lacking), HasSubstr("[spindle] calibration"));
  lacking = *config;
  lacking.vision_tools.clear();
  EXPECT_THAT(refusal(lacking), HasSubstr("vision tool 1"));
}

}  // namespace
}  // namespace panelcal
