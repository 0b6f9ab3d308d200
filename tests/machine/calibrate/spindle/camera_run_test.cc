// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/spindle/camera_run.h"

#include <filesystem>
#include <string>

#include "calib/base/files/atomic_file.h"
#include "machine/sources/device_set.h"
#include <gmock/gmock.h>

#include "tests/calib/ledger/drafts.h"
#include "tests/calib/spindle/simulated_coupon.h"
#include "tests/machine/calibrate/spindle/coupon_toml.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using testing::HasSubstr;

/// 1 in 1000 of a chi-square of two degrees of freedom.
constexpr double kFarthest = 13.8;

std::string replaced(std::string text, const std::string& old_text, const std::string& new_text) {
  const auto at = text.find(old_text);
  EXPECT_NE(at, std::string::npos) << old_text;
  return text.replace(at, old_text.size(), new_text);
}

class SpindleCameraRunTest : public ::testing::Test {
 protected:
  MachineConfig config(const std::string& toml = test::spindle_toml()) {
    auto read = test::spindle_machine(folder_.path(), toml);
    EXPECT_TRUE(read) << read.error().text();
    // Rows that a ledger has are not free again without the coupon's file: the last test.
    read->ledger_file.clear();
    return *std::move(read);
  }
  Expected<SpindleCameraRun> calibrate(const MachineConfig& config, Prompt prompt = {}) {
    PANELCAL_TRY(const DeviceSet set, DeviceSet::simulated(config));
    return calibrate_spindle_camera(config, set.devices(std::move(prompt)));
  }

  test::TemporaryFolder folder_;
};

TEST_F(SpindleCameraRunTest, FindsTheTrueOffsetOnTheNextFreeRows) {
  const MachineConfig config = this->config();
  for (const int i_row : {0, 3}) {
    const auto run = calibrate(config);
    ASSERT_TRUE(run) << run.error().text();
    EXPECT_EQ(run->i_row, i_row);
    EXPECT_EQ(run->places, places_of_row(*config.coupon, i_row));
    EXPECT_TRUE(run->sights.missed.empty());
    EXPECT_LT(test::squared_error(run->fit.offset, {45.03, -2.98}), kFarthest);
  }
  EXPECT_THAT(calibrate(config), FailsWith(Code::ConfigValue, "6 rows of coupon \"A\""));
}

TEST_F(SpindleCameraRunTest, TwoNightsDifferAndOneNightRepeats) {
  const MachineConfig config = this->config();
  const auto first = calibrate(config);
  const auto second = calibrate(config);
  ASSERT_TRUE(first && second);
  EXPECT_NE(first->fit.offset.offset.in_mm(), second->fit.offset.offset.in_mm());
  std::filesystem::remove(config.coupon->state_file);
  const auto again = calibrate(config);
  ASSERT_TRUE(again);
  EXPECT_EQ(first->fit.offset.offset.in_mm(), again->fit.offset.offset.in_mm());
  EXPECT_EQ(report_text(*first), report_text(*again));
}

TEST_F(SpindleCameraRunTest, PlacesOfTheCallersChoiceTakeNoRow) {
  const MachineConfig config = this->config();
  const auto set = DeviceSet::simulated(config);
  ASSERT_TRUE(set);
  const auto places = places_from(*config.coupon, position_mm<frame::Machine>(120, 220));
  const auto run = calibrate_spindle_camera_at(config, set->devices(), places);
  ASSERT_TRUE(run) << run.error().text();
  EXPECT_EQ(run->places, places);
  EXPECT_LT(test::squared_error(run->fit.offset, {45.03, -2.98}), kFarthest);
  EXPECT_FALSE(std::filesystem::exists(config.coupon->state_file));
}

TEST_F(SpindleCameraRunTest, NoRowIsTakenWhereSomethingIsMissing) {
  const std::string toml = test::spindle_toml();
  const auto refusal = [&](const MachineConfig& config) {
    const auto run = calibrate(config);
    EXPECT_FALSE(run);
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "coupon.json"));
    return run ? "accepted" : run.error().text();
  };
  EXPECT_THAT(refusal(config(replaced(toml, "[300, 100]", "[30, 100]"))),
              HasSubstr("[travel-exceeded]"));
  EXPECT_THAT(refusal(config(replaced(toml, "rows = 6", "rows = 6\nvision_tool = 4"))),
              HasSubstr("[vision-tool-undefined]"));
  EXPECT_THAT(refusal(config(replaced(toml, "[\"+x+y\", \"-x-y\"]", "[\"+x-y\", \"-x-y\"]"))),
              HasSubstr("(+x+y)"));
  MachineConfig without = config();
  without.coupon.reset();
  EXPECT_THAT(refusal(without), HasSubstr("[coupon]"));
  without = config();
  without.camera.reset();
  EXPECT_THAT(refusal(without), HasSubstr("[camera]"));
}

/// A spindle without an order to drill.
class NoDrill final : public Spindle {
 public:
  bool can_drill() const override { return false; }
  Expected<void> drill(int /*tool*/) override {
    return failure({Code::NotSupported, {}, "must not be asked", ""});
  }
};

TEST_F(SpindleCameraRunTest, NoRowIsTakenWithoutADrill) {
  const MachineConfig config = this->config();
  auto machine = SimCoupon::create(config, {});
  ASSERT_TRUE(machine);
  NoDrill spindle;
  EXPECT_THAT(calibrate_spindle_camera(config, {*machine, spindle, *machine, {}, {}}),
              FailsWith(Code::ConfigValue, "drill_command"));
  EXPECT_FALSE(std::filesystem::exists(config.coupon->state_file));
}

/// Drills nothing from the n-th hole on.
class BrokenDrill final : public Spindle {
 public:
  BrokenDrill(SimCoupon& machine, int n_holes) : machine_(machine), n_left_(n_holes) {}
  Expected<void> drill(int tool) override {
    return n_left_-- > 0 ? machine_.drill(tool) : Expected<void>();
  }

 private:
  SimCoupon& machine_;
  int n_left_;
};

TEST_F(SpindleCameraRunTest, SaysWhichHolesWereNotSeen) {
  const MachineConfig config = this->config();
  auto machine = SimCoupon::create(config, test::usual_scatter(3));
  ASSERT_TRUE(machine);
  BrokenDrill drill(*machine, 8);
  const auto run = calibrate_spindle_camera(config, {*machine, drill, *machine, {}, {}});
  ASSERT_TRUE(run) << run.error().text();
  EXPECT_EQ(run->fit.n_used, 8);
  EXPECT_THAT(report_text(*run), HasSubstr("(310.000, 110.000) mm, look 1"));
}

TEST_F(SpindleCameraRunTest, ADrillThatBreaksAtOnceIsRefusedWithTheReason) {
  const MachineConfig config = this->config();
  auto machine = SimCoupon::create(config, test::usual_scatter(3));
  ASSERT_TRUE(machine);
  BrokenDrill drill(*machine, 2);
  const auto run = calibrate_spindle_camera(config, {*machine, drill, *machine, {}, {}});
  EXPECT_THAT(run, FailsWith(Code::CalibrationRefused, "2 of 9 holes of coupon \"A\""));
  // The rows are spoiled all the same.
  EXPECT_EQ(used_rows(config)->count(), 3);
}

TEST_F(SpindleCameraRunTest, NeighboursAreNotTakenForEachOther) {
  // The offset to begin with is wrong by a pitch of 5 mm, either way along x and y.
  for (const char* begin :
       {"[50.03, -2.98]", "[40.03, -2.98]", "[45.03, 2.02]", "[45.03, -7.98]", "[50.03, 2.02]"}) {
    SCOPED_TRACE(begin);
    std::filesystem::remove(folder_.path() / "coupon.json");
    const MachineConfig config =
        this->config(replaced(test::spindle_toml(), "[45.0, -3.0]", begin));
    auto machine = SimCoupon::create(config, test::usual_scatter(3));
    ASSERT_TRUE(machine);
    EXPECT_THAT(calibrate_spindle_camera(config, {*machine, *machine, *machine, {}, {}}),
                FailsWith(Code::CalibrationRefused, "pitch"));
  }
}

TEST_F(SpindleCameraRunTest, ACouponThatIsDrilledAlreadyIsNotDrilledAgain) {
  const MachineConfig config = this->config();
  auto machine = SimCoupon::create(config, test::usual_scatter(3));
  ASSERT_TRUE(machine);
  const CalibrationDevices devices{*machine, *machine, *machine, {}, {}};
  ASSERT_TRUE(calibrate_spindle_camera(config, devices));
  const std::size_t n_holes = machine->holes().size();
  // The state is thrown away.
  std::filesystem::remove(config.coupon->state_file);
  EXPECT_THAT(calibrate_spindle_camera(config, devices),
              FailsWith(Code::CalibrationRefused, "\"coupon.json\""));
  EXPECT_EQ(machine->holes().size(), n_holes);
  EXPECT_FALSE(std::filesystem::exists(config.coupon->state_file));
}

TEST_F(SpindleCameraRunTest, EarlierRowsAreNotTakenForTheNext) {
  MachineConfig config = this->config();
  auto machine = SimCoupon::create(config, test::usual_scatter(3));
  ASSERT_TRUE(machine);
  const CalibrationDevices devices{*machine, *machine, *machine, {}, {}};
  ASSERT_TRUE(calibrate_spindle_camera(config, devices));
  // The camera now stands 5 mm lower than anybody knows: it would see the row before each.
  config.spindle_camera.offset = displacement_mm<frame::Machine>(45.03, 2.02);
  EXPECT_THAT(calibrate_spindle_camera(config, devices), FailsWith(Code::CalibrationRefused));
}

TEST_F(SpindleCameraRunTest, ThePromptMayRefuse) {
  const MachineConfig config =
      this->config(replaced(test::spindle_toml(), "rows = 6", "rows = 6\nentry_material = true"));
  const Prompt nobody = [](std::string_view what) -> Expected<void> {
    return failure({Code::Usage, {"coupon", 0, 0}, "no person at the terminal", std::string(what)});
  };
  EXPECT_THAT(calibrate(config, nobody), FailsWith(Code::Usage));
  int n_prompts = 0;
  const Prompt somebody = [&](std::string_view) -> Expected<void> {
    ++n_prompts;
    return {};
  };
  EXPECT_TRUE(calibrate(config, somebody));
  EXPECT_EQ(n_prompts, 2);
}

TEST_F(SpindleCameraRunTest, ALostStateFreesNoRowThatTheLedgerHas) {
  MachineConfig config = this->config();
  config.ledger_file = folder_.path() / "drill 1.ledger";
  auto machine = SimCoupon::create(config, test::usual_scatter(3));
  ASSERT_TRUE(machine);
  CalibrationDevices devices{*machine, *machine, *machine, {}, {}};
  EXPECT_THAT(calibrate_spindle_camera(config, devices),
              FailsWith(Code::LedgerEntryInvalid, "taken_by"));
  EXPECT_TRUE(machine->holes().empty());
  devices.taken_by = {test::first_night(), "timer", "panelcal test"};
  ASSERT_TRUE(calibrate_spindle_camera(config, devices));
  std::filesystem::remove(config.coupon->state_file);
  const auto next = calibrate_spindle_camera(config, devices);
  ASSERT_TRUE(next) << next.error().text();
  EXPECT_EQ(next->i_row, 3);
  EXPECT_EQ(machine->holes().size(), 18U);
}

}  // namespace
}  // namespace panelcal
