// SPDX-License-Identifier: Apache-2.0
// 120 nights of a virtual machine that really drills and sees, with everything that goes wrong on
// such machines.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <iostream>

#include "machine/calibrate/kinds/spindle_camera.h"
#include "machine/nightly/record/night_history.h"
#include <gmock/gmock.h>

#include "tests/machine/nightly/cut_night.h"
#include "tests/machine/nightly/picture_night.h"

namespace panelcal {
namespace {

using std::chrono::steady_clock;
using testing::HasSubstr;

constexpr int kNights = 120;
constexpr int kDirtyLens = 30;
constexpr int kWornDrill = 45;
constexpr int kBrokenStage = 60;
constexpr int kMoved = 75;
constexpr int kSlowDrift = 95;
/// The power goes in the middle of these.
constexpr std::array kPowerCuts = {12, 38, 52, 66, 84, 90, 108};
constexpr double kSlowDrift_mm = 0.0008;
constexpr double kWalk_mm = 0.0003;

bool is_faulty(int night) {
  return night == kDirtyLens || night == kWornDrill || night == kBrokenStage || night == kMoved;
}

test::PictureFaults faults_of(int night) {
  test::PictureFaults faults;
  faults.is_lens_dirty = night == kDirtyLens;
  if (night == kWornDrill) faults.wander = um(9);
  if (night == kBrokenStage) faults.stage_fails_after = 30;
  return faults;
}

void mark_fresh_start_of(const test::PictureNights& nights) {
  const auto config = nights.config();
  ASSERT_TRUE(config) << config.error().text();
  auto ledger = Ledger::open(nights.ledger_file(), fixed_clock(nights.now));
  ASSERT_TRUE(ledger) << ledger.error().text();
  const auto marked = mark_fresh_start(
      *ledger, spindle_camera_key(*config), {"mounted anew", "operator", "panelcal test"});
  ASSERT_TRUE(marked) << marked.error().text();
}

class NightlyPictures : public ::testing::Test {
 protected:
  /// Changes the machine as it changes before a night.
  void live_through(int night) {
    nights_.coupon = "of night " + std::to_string(night);
    nights_.truth_mm += kWalk_mm * Eigen::Vector2d(random_.normal(), random_.normal());
    if (night == kMoved) nights_.truth_mm += Eigen::Vector2d(0.040, 0.010);
    if (night == kMoved + 1) mark_fresh_start_of(nights_);
    if (night < kSlowDrift) return;
    nights_.truth_mm.y() += kSlowDrift_mm;
    drifted_mm_ += kSlowDrift_mm;
  }

  /// A run of this night that is killed at a random moment: what was recorded before is all there,
  /// and what is in force was once installed.
  void cut_the_power(int night) {
    const auto before = lines();
    const double part = random_.uniform(0, 1);
    n_cut_ +=
        test::is_killed(std::chrono::microseconds(static_cast<std::int64_t>(part * usual_us_)),
                        [&] { return nights_.run(seed_of(night), faults_of(night)).has_value(); });
    const auto after = lines();
    ASSERT_GE(after.size(), before.size());
    EXPECT_TRUE(std::equal(before.begin(), before.end(), after.begin()));
    if (const auto installed = nights_.installed_mm()) {
      EXPECT_LT((*installed - nights_.truth_mm).norm(), 0.0012 * 5);
    }
  }

  std::vector<std::string> lines() const {
    const auto ledger = Ledger::open(nights_.ledger_file(), fixed_clock(nights_.now));
    if (!ledger) ADD_FAILURE() << ledger.error().text();
    if (!ledger) return {};
    EXPECT_TRUE(ledger->verify());
    return test::ledger_lines(*ledger);
  }

  static std::uint64_t seed_of(int night) { return static_cast<std::uint64_t>(1000 + night); }

  void check_installation(const NightStep& step, const std::optional<Eigen::Vector2d>& before) {
    const auto after = nights_.installed_mm();
    if (step.state != NightState::Installed) {
      EXPECT_EQ(before, after);
      return;
    }
    ASSERT_TRUE(after);
    worst_mm_ = std::max(worst_mm_, (*after - nights_.truth_mm).norm());
  }

  void check_verdict(int night, const NightRecord& record) {
    const NightStep& step = record.steps.at(0);
    const bool is_installed = step.state == NightState::Installed;
    if (is_faulty(night)) {
      EXPECT_FALSE(is_installed) << record.verdict;
      EXPECT_NE(exit_code(record), 0);
      check_words(night, record);
    } else if (night < kSlowDrift) {
      n_refused_ += !is_installed;
    } else if (!said_mm_ && (!is_installed || !step.alarms.empty())) {
      said_mm_ = drifted_mm_;
    }
  }

  static void check_words(int night, const NightRecord& record) {
    switch (night) {
      case kDirtyLens:
        EXPECT_THAT(record.verdict, HasSubstr("contrast of holes"));
        break;
      case kWornDrill:
        EXPECT_THAT(record.verdict, HasSubstr("holes about the fit"));
        break;
      case kBrokenStage:
        EXPECT_EQ(exit_code(record), 3);
        break;
      default:
        EXPECT_EQ(record.steps.at(0).state, NightState::Held);
        EXPECT_FALSE(record.may_drill);
    }
  }

  double usual_us_ = 0;  ///< that the last night took
  int n_cut_ = 0;

  test::PictureNights nights_;
  Random random_{3};
  int n_refused_ = 0;
  double worst_mm_ = 0;
  double drifted_mm_ = 0;
  std::optional<double> said_mm_;
};

TEST_F(NightlyPictures, FlagEveryFaultOnItsNightAndInstallNothingBadIn120Nights) {
  for (int night = 0; night < kNights; ++night) {
    SCOPED_TRACE("night " + std::to_string(night));
    live_through(night);
    const auto before = nights_.installed_mm();
    const bool is_cut = std::ranges::find(kPowerCuts, night) != kPowerCuts.end();
    if (is_cut) cut_the_power(night);
    const auto begin = steady_clock::now();
    const auto record = nights_.run(seed_of(night), faults_of(night));
    usual_us_ = std::chrono::duration<double, std::micro>(steady_clock::now() - begin).count();
    ASSERT_TRUE(record) << record.error().text();
    // Not even a night that was cut off leaves the one after it without a result.
    EXPECT_EQ(record->steps.at(0).ledger_id.has_value(), night != kBrokenStage);
    check_installation(record->steps.at(0), before);
    check_verdict(night, *record);
    nights_.now += std::chrono::days(1);
  }
  std::cout << n_refused_ << " of " << kSlowDrift - 4
            << " healthy nights refused; worst error in force " << 1e3 * worst_mm_
            << " um; the slow drift was said at " << 1e3 * said_mm_.value_or(-1) << " um; "
            << n_cut_ << " nights cut off\n";
  ASSERT_TRUE(said_mm_);
  // Some may have ended just before.
  EXPECT_GE(n_cut_, static_cast<int>(kPowerCuts.size()) / 2);
  // Each night takes the drift up; what it costs is the error in force, below. With holes that
  // wander by 3 um it is said after a few nights.
  EXPECT_LT(*said_mm_, 0.015);
  // 91 healthy nights at 3.5 in 1000: more than two have a chance of 1 in 250.
  EXPECT_LE(n_refused_, 2);
  // 1.2 um an axis; 5 sigma.
  EXPECT_LE(worst_mm_, 0.0012 * 5);
}

}  // namespace
}  // namespace panelcal
