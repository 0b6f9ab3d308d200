// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/checks/warm_up.h"

#include <cmath>
#include <string>
#include <vector>

#include "machine/calibrate/kinds/kinds.h"
#include "machine/sim/sim_coupon.h"
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/machine/nightly/fake_night.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using testing::HasSubstr;

/// A stage that writes down where it goes.
class Log final : public Stage {
 public:
  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    places_mm.push_back(spindle.in_mm());
    return spindle;
  }
  std::vector<Eigen::Vector2d> places_mm;
  double waited_s = 0;
};

TEST(WarmUp, MovesToAndFroForAsLongAsWanted) {
  MachineConfig config;
  config.travel = Travel{position_mm<frame::Machine>(0, 0), position_mm<frame::Machine>(600, 400)};
  NightlyConfig nightly;
  nightly.warm_up = seconds(12);
  Log log;
  test::FakeDevices others;
  const CalibrationDevices devices = {
      log, others, others, [&](Time time) { log.waited_s += time.in_s(); }, {}};
  const auto clock = fixed_clock(std::chrono::sys_seconds(std::chrono::seconds(0)));
  const auto waited = warm_up(config, nightly, devices, clock);
  ASSERT_TRUE(waited) << waited.error().text();
  EXPECT_DOUBLE_EQ(waited->waited.in_s(), 12);
  EXPECT_FALSE(waited->seen);
  EXPECT_DOUBLE_EQ(log.waited_s, 12);
  EXPECT_THAT(log.places_mm,
              testing::ElementsAre(
                  Eigen::Vector2d(150, 100), Eigen::Vector2d(450, 300), Eigen::Vector2d(150, 100)));
  nightly.warm_up = seconds(0);
  log.places_mm.clear();
  ASSERT_TRUE(warm_up(config, nightly, devices, clock));
  EXPECT_TRUE(log.places_mm.empty());
}

TEST(WarmUp, NeedsToKnowWhereTheStageMayMove) {
  const MachineConfig config;
  NightlyConfig nightly;
  nightly.warm_up = seconds(12);
  test::FakeDevices all;
  const auto clock = fixed_clock(std::chrono::sys_seconds(std::chrono::seconds(0)));
  EXPECT_THAT(warm_up(config, nightly, {all, all, all, {}, {}}, clock),
              FailsWith(Code::ConfigValue));
  EXPECT_EQ(all.n_moves, 0);
}

/// The virtual machine, just started.
class ColdMachine : public ::testing::Test {
 protected:
  // Of the truth: the way in x (y is half of it, the other way), and its time constant.
  double cold_um = 40;
  double time_constant_s = 300;
  double noise = 2;
  double warm_up_s = 3600;
  double limit_um = 2;

  MachineConfig config() const {
    const std::string toml = fmt::format(R"([machine]
name = "drill 1"
travel_low_mm = [0, 0]
travel_high_mm = [600, 500]
[ledger]
file = "drill.ledger"
[[vision.tool]]
number = 1
shape = "disc"
size_mm = 0.4
[camera]
calibration = "camera.cal.json"
focus_range_mm = [-1, 1]
focus_mm = 0
[spindle]
camera_offset_mm = [45.0, -3.0]
[nightly]
machine_driver = "sim"
calibrate = ["focus"]
mark_mm = [300, 200]
warm_up_s = {}
warm_up_limit_um = {}
min_disk_mb = 0
[sim]
noise = {}
focus_z_mm = 0.05
[sim.coupon]
mark_mm = [300.02, 199.97]
stage_repeatability_um = 0.5
cold_um = [{}, {}]
warm_up_s = {}
)",
                                         warm_up_s,
                                         limit_um,
                                         noise,
                                         cold_um,
                                         -0.5 * cold_um,
                                         time_constant_s);
    // An input of what is recorded.
    EXPECT_TRUE(write_file(folder_.path() / "machine.toml", toml));
    auto config = test::config_with_camera(folder_.path(), test::test_camera(160, 120), toml);
    EXPECT_TRUE(config) << config.error().text();
    return *std::move(config);
  }

  WarmUpRun run(std::uint64_t seed) {
    const MachineConfig config = this->config();
    SimCoupon machine = this->machine(config, seed);
    auto run = warm_up(config, *config.nightly, machine.devices(), clock_);
    EXPECT_TRUE(run) << run.error().text();
    const Displacement<frame::Machine> still_um =
        machine.true_offset().offset - config.spindle_camera.offset;
    rest_um_ = 1e3 * still_um.in_mm().norm();
    return *std::move(run);
  }
  static SimCoupon machine(const MachineConfig& config, std::uint64_t seed) {
    SimCouponOptions options = config.sim->coupon;
    options.seed = seed;
    auto machine = SimCoupon::create(config, options);
    EXPECT_TRUE(machine) << machine.error().text();
    return *std::move(machine);
  }

  test::TemporaryFolder folder_;
  Clock clock_ = fixed_clock(std::chrono::sys_seconds(std::chrono::seconds(1795302000)));
  double rest_um_ = 0;  ///< rest of the way that was still to come
};

TEST_F(ColdMachine, IsMovedUntilItIsWarm) {
  constexpr int kRuns = 10;
  // 44.7 um exp(-t / 300 s) = 2 um.
  const double warm_s = time_constant_s * std::log(std::hypot(40, 20) / limit_um);
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    SCOPED_TRACE(seed);
    const WarmUpRun run = this->run(seed);
    ASSERT_TRUE(run.seen);
    ASSERT_TRUE(run.seen->is_warm) << run.seen->text;
    EXPECT_NEAR(run.seen->fit->wait.in_s(), warm_s, 4 * run.seen->fit->wait_sigma.in_s());
    // Not long after it was, and not before.
    EXPECT_LT(rest_um_, limit_um);
    EXPECT_LT(run.waited.in_s(), warm_s + 600);
    EXPECT_THAT(run.seen->text, HasSubstr("warm after 15"));
    EXPECT_TRUE(warm_up_check(*run.seen).passed);
  }
}

TEST_F(ColdMachine, IsNotWarmWhereTheTimeEndsBefore) {
  warm_up_s = 600;
  const WarmUpRun run = this->run(1);
  EXPECT_FALSE(run.seen->is_warm);
  EXPECT_GE(run.waited.in_s(), 600);
  EXPECT_THAT(run.seen->text, HasSubstr("that the machine is warm"));
  EXPECT_FALSE(warm_up_check(*run.seen).passed);
}

TEST_F(ColdMachine, ThatDoesNotMoveIsWarmAsSoonAsNothingCanBeToCome) {
  cold_um = 0;
  WarmUpRun run = this->run(1);
  EXPECT_TRUE(run.seen->is_warm) << run.seen->text;
  EXPECT_THAT(run.seen->text, HasSubstr("no warming up is seen in"));
  // Not at the first looks.
  EXPECT_GT(run.seen->looks.size(), 6u);
  EXPECT_LT(run.waited.in_s(), warm_up_s);
  // Looks that scatter by half a micrometre cannot tell of a tenth.
  limit_um = 0.1;
  run = this->run(1);
  EXPECT_FALSE(run.seen->is_warm);
  EXPECT_THAT(run.seen->text, HasSubstr("is still to come, limit 0.1 um"));
}

TEST_F(ColdMachine, IsRecordedWithTheNightAndSaidInTheMorning) {
  const MachineConfig config = this->config();
  SimCoupon machine = this->machine(config, 1);
  const auto record =
      run_nightly({config, *config.nightly, machine.devices(), clock_, "panelcal test", "timer"});
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_EQ(exit_code(*record), 0) << record->verdict;
  EXPECT_THAT(record->verdict, HasSubstr("after a cold start warm up for 16 min first"));
  const auto ledger = Ledger::open_to_read(config.ledger_file);
  ASSERT_TRUE(ledger);
  LedgerFilter filter;
  filter.kind = LedgerKind::Night;
  const auto entries = ledger->list(filter);
  ASSERT_TRUE(entries);
  ASSERT_EQ(entries->size(), 1u);
  const auto json = nlohmann::json::parse(*ledger->result(entries->front().id));
  EXPECT_TRUE(json["warm_up"]["warm"].get<bool>());
  EXPECT_EQ(json["warm_up"]["looks"].size(), record->warm_up->looks.size());
  EXPECT_NEAR(json["warm_up"]["fit"]["time_constant_s"].get<double>(), time_constant_s, 60);
  // Whoever asks whether the machine may drill now is told as well.
  NightJob job = {config, *config.nightly, machine.devices(), clock_, "panelcal test", "timer"};
  job.is_dry_run = true;
  const auto asked = run_nightly(job);
  ASSERT_TRUE(asked) << asked.error().text();
  EXPECT_THAT(asked->notes, testing::Contains(HasSubstr("warm after 15")));
}

TEST_F(ColdMachine, IsNotCalibrated) {
  warm_up_s = 600;
  const MachineConfig config = this->config();
  SimCoupon machine = this->machine(config, 1);
  const auto record =
      run_nightly({config, *config.nightly, machine.devices(), clock_, "panelcal test", "timer"});
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_EQ(exit_code(*record), 1);
  EXPECT_EQ(record->steps.at(0).state, NightState::Held);
  EXPECT_FALSE(record->steps.at(0).axes.at(0).new_value);
  EXPECT_THAT(record->verdict, HasSubstr("that the machine is warm"));
}

TEST_F(ColdMachine, NeedsAClockToBeMeasured) {
  const MachineConfig config = this->config();
  SimCoupon machine = this->machine(config, 1);
  CalibrationDevices devices = machine.devices();
  devices.now = {};
  EXPECT_THAT(warm_up(config, *config.nightly, devices, clock_),
              FailsWith(Code::ConfigValue, "clock"));
}

}  // namespace
}  // namespace panelcal
