// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/checks/self_test.h"

#include <cmath>
#include <vector>

#include <gmock/gmock.h>

#include "tests/machine/calibrate/spindle/coupon_job.h"
#include "tests/machine/nightly/fake_night.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

TEST(SelfTest, AFullDiskDoesNotPass) {
  const test::TemporaryFolder folder;
  const std::filesystem::path ledger = folder.path() / "a.ledger";
  EXPECT_TRUE(check_disk(ledger, 0).passed);
  EXPECT_GT(*check_disk(ledger, 0).value, 0);
  EXPECT_FALSE(check_disk(ledger, 1e12).passed);
  EXPECT_FALSE(check_disk("/nowhere/a.ledger", 0).passed);
}

/// Commands to the stage.
struct Log final : public Stage {
  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    places_mm.push_back(spindle.in_mm());
    return spindle;
  }
  std::vector<Eigen::Vector2d> places_mm;
};

std::optional<double> temperature(const NightlyConfig& nightly) {
  const auto read = read_temperature(nightly);
  if (!read) ADD_FAILURE() << read.error().text();
  return read ? *read : std::nullopt;
}

TEST(Temperature, IsReadFromAFileOrAProgram) {
  const test::TemporaryFolder folder;
  NightlyConfig nightly;
  EXPECT_EQ(temperature(nightly), std::nullopt);
  nightly.temperature_file = folder.path() / "temperature";
  EXPECT_THAT(read_temperature(nightly), FailsWith(Code::FileUnreadable, "temperature"));
  ASSERT_TRUE(write_file(nightly.temperature_file, " 21.5\n"));
  EXPECT_EQ(temperature(nightly), 21.5);
  for (const char* bad : {"", "warm", "21.5 C", "nan", "1e9", "-300"}) {
    ASSERT_TRUE(write_file(nightly.temperature_file, bad));
    EXPECT_THAT(read_temperature(nightly), FailsWith(Code::ConfigValue, "temperature"));
  }
  nightly.temperature_file.clear();
  nightly.temperature_command = {"echo", "19.25"};
  EXPECT_EQ(temperature(nightly), 19.25);
}

/// A hole, drilled before, is the mark.
class MarkTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto config = test::coupon_machine(folder_.path());
    ASSERT_TRUE(config) << config.error().text();
    config_ = *config;
    nightly_.mark = position_mm<frame::Machine>(300, 100);
  }
  SimCoupon machine(bool has_mark) const {
    SimCouponOptions options;
    options.stage_repeatability = um(2);
    auto machine = SimCoupon::create(config_, options);
    EXPECT_TRUE(machine) << machine.error().text();
    if (has_mark) {
      EXPECT_TRUE(machine->move_to(*nightly_.mark));
      EXPECT_TRUE(machine->drill(1));
    }
    return *std::move(machine);
  }

  test::TemporaryFolder folder_;
  MachineConfig config_;
  NightlyConfig nightly_;
};

TEST_F(MarkTest, SaysHowFarLooksScatterAndHowGoodThePictureIs) {
  SimCoupon machine = this->machine(true);
  const auto looks = test_mark(config_, nightly_, {machine, machine, machine, {}, {}});
  ASSERT_TRUE(looks) << looks.error().text();
  for (const SelfTestCheck& check : looks->checks) EXPECT_TRUE(check.passed) << check.text;
  ASSERT_EQ(looks->quality.spreads.size(), 1u);
  EXPECT_EQ(looks->quality.spreads[0].degrees_of_freedom, 8);
  // 2 um of the stage; of 8 degrees of freedom, 1 in 1000 on either side.
  const double ratio = looks->quality.spreads[0].variance / 4e-6;
  EXPECT_GT(ratio, 0.86 / 8);
  EXPECT_LT(ratio, 26.1 / 8);
  ASSERT_EQ(looks->quality.levels.size(), 2u);
  EXPECT_NEAR(looks->quality.levels[0].value, 0.3, 0.02);
  EXPECT_TRUE(looks->quality.levels[0].low_is_bad);
  EXPECT_FALSE(looks->quality.levels[1].low_is_bad);
}

TEST_F(MarkTest, AMarkThatIsNotThereDoesNotPass) {
  SimCoupon machine = this->machine(false);
  const auto looks = test_mark(config_, nightly_, {machine, machine, machine, {}, {}});
  ASSERT_TRUE(looks) << looks.error().text();
  EXPECT_FALSE(looks->checks.at(0).passed);
  EXPECT_TRUE(looks->quality.spreads.empty());
}

TEST_F(MarkTest, OutsideOfTheTravelNothingMoves) {
  SimCoupon machine = this->machine(false);
  nightly_.mark = position_mm<frame::Machine>(20, 100);  // the spindle would have to be at x < 0
  Log log;
  EXPECT_THAT(test_mark(config_, nightly_, {log, machine, machine, {}, {}}),
              FailsWith(Code::TravelExceeded, "mark_mm"));
  EXPECT_TRUE(log.places_mm.empty());
}

}  // namespace
}  // namespace panelcal
