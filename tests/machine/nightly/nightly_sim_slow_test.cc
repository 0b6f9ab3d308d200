// SPDX-License-Identifier: Apache-2.0
// Nights of the virtual machine that machine_driver = "sim" names, with all that is tried at a
// mark: a focus that creeps away, a lamp that ages, a stage that comes loose.

#include <algorithm>
#include <iostream>
#include <map>
#include <string>
#include <string_view>

#include "calib/base/files/atomic_file.h"
#include "calib/base/statistics/random.h"
#include "machine/nightly/nightly.h"
#include "machine/sources/device_set.h"
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/machine/virtual_machine.h"

namespace panelcal {
namespace {

constexpr int kNights = 46;
/// A change that begins on a night, and the number of nights within which it has to be reported.
struct Story {
  std::string_view kind;
  int begins = 0;
  int said_within = 0;
};
// Before it matters: the focus creeps by 12 of 100 um a night, the contrast falls by 1.5 %, and the
// settle time grows by 9 of 50 ms.
constexpr Story kFocus = {"focus", 16, 6};
constexpr Story kLamp = {"light", 26, 6};
constexpr Story kStage = {"settle", 36, 6};

class NightlySim : public ::testing::Test {
 protected:
  // The truth, and what a person wrote into machine.toml.
  double focus_z_mm_ = 0;
  double lamp_ = 0;
  double swing_decay_s_ = 0;
  double stated_focus_mm_ = 0.137;
  double stated_lamp_ = 50;
  double settle_s_ = 0.5;

  Expected<MachineConfig> config(int night) const {
    const std::string toml = fmt::format(R"([machine]
name = "drill 1"
settle_s = {}
[vision]
search_radius_mm = 0.4
[[vision.tool]]
number = 1
shape = "hole"
size_mm = 0.8
[[vision.tool]]
number = 2
shape = "disc"
size_mm = 0.4
[camera]
calibration = "camera.cal.json"
focus_range_mm = [-1, 1]
focus_mm = {}
lamp = {}
[spindle]
camera_offset_mm = [45.0, -3.0]
calibration = "spindle.cal.json"
[coupon]
name = "of night {}"
origin_mm = [300, 100]
approaches = ["+x+y", "-x-y"]
[uncertainty]
stage_repeatability_um = 0.5
[ledger]
file = "drill.ledger"
[nightly]
machine_driver = "sim"
calibrate = ["focus", "light", "settle", "spindle-camera"]
mark_mm = [200, 300]
mark_tool = 2
min_disk_mb = 0
[nightly.drift]
min_nights = 8
[nightly.settle]
longest_s = 0.6
[sim]
seed = {}
noise = 2
background = 0.3
target_level = 0.7
lamp = {}
focus_z_mm = {}
focus_depth_mm = 0.2
spindle_camera_offset_mm = [45.01, -3.0]
[sim.coupon]
drill_wander_um = 3
stage_repeatability_um = 0.5
mark_mm = [200.01, 299.98]
mark_tool = 2
swing_um = 20
swing_decay_s = {}
swing_hz = 11
)",
                                         settle_s_,
                                         stated_focus_mm_,
                                         stated_lamp_,
                                         night,
                                         1000 + night,
                                         lamp_,
                                         focus_z_mm_,
                                         swing_decay_s_);
    PANELCAL_CHECK(write_file(folder_.path() / "machine.toml", toml));
    const auto camera = folder_.path() / "camera.cal.json";
    PANELCAL_CHECK(write_camera_calibration(camera, test::test_camera(160, 140)));
    return read_machine_config(folder_.path() / "machine.toml");
  }

  Expected<NightRecord> run(int night) const {
    PANELCAL_TRY(const MachineConfig config, this->config(night));
    PANELCAL_TRY(const DeviceSet devices, DeviceSet::simulated(config));
    const auto now =
        std::chrono::sys_seconds(std::chrono::seconds(1795302000)) + std::chrono::days(night);
    return run_nightly(
        {config, *config.nightly, devices.devices(), fixed_clock(now), "panelcal test", "timer"});
  }

  /// Nothing is quite the same in two nights; and what creeps goes on until an operator is told
  /// and sees to it.
  void live_through(int night) {
    const auto crept = [&](const Story& story) {
      return said_.contains(story.kind) ? 0 : std::max(0, night - story.begins + 1);
    };
    focus_z_mm_ = 0.137 + 0.003 * random_.normal() + 0.012 * crept(kFocus);
    lamp_ = 50 * (1 + 0.004 * random_.normal() + 0.015 * crept(kLamp));
    swing_decay_s_ = 0.05 + 0.0005 * random_.normal() + 0.003 * crept(kStage);
  }

  /// True if a night reports this story.
  static bool is_said(const NightRecord& record, std::string_view kind) {
    const auto step = std::ranges::find(record.steps, kind, &NightStep::kind);
    return step != record.steps.end() &&
           (!step->alarms.empty() || step->state != NightState::Installed);
  }

  void listen(int night, const NightRecord& record) {
    for (const Story& story : {kFocus, kLamp, kStage}) {
      const bool is_begun = night >= story.begins && !said_.contains(story.kind);
      if (!is_said(record, story.kind)) continue;
      // Bad pictures of another story keep this one from being measured.
      if (!is_begun && is_measured_alone(record)) ++n_false_;
      if (!is_begun) continue;
      said_[story.kind] = night;
      std::cout << story.kind << " is said " << night - story.begins + 1
                << " nights after it began: " << record.verdict << "\n";
    }
  }
  static bool is_measured_alone(const NightRecord& record) {
    return std::ranges::all_of(record.checks, &SelfTestCheck::passed);
  }

  test::TemporaryFolder folder_;
  Random random_{7};
  std::map<std::string_view, int> said_;
  int n_false_ = 0;
};

TEST_F(NightlySim, SayACreepingFocusAnAgeingLampAndALooseStageOnTheirNights) {
  for (int night = 0; night < kNights; ++night) {
    SCOPED_TRACE("night " + std::to_string(night));
    live_through(night);
    const auto record = run(night);
    ASSERT_TRUE(record) << record.error().text();
    ASSERT_NE(record->outcome, NightOutcome::Failed) << record->verdict;
    ASSERT_EQ(record->steps.size(), 4u);
    // Nothing of this touches the offset.
    EXPECT_EQ(record->steps.back().kind, "spindle-camera");
    listen(night, *record);
  }
  for (const Story& story : {kFocus, kLamp, kStage}) {
    ASSERT_TRUE(said_.contains(story.kind)) << story.kind;
    EXPECT_LT(said_[story.kind] - story.begins, story.said_within) << story.kind;
  }
  // Of a thousand nights one alarms falsely, and of 2000 one is refused for its change.
  EXPECT_LE(n_false_, 1);
}

}  // namespace
}  // namespace panelcal
