// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/controls/linuxcnc/linuxcnc.h"

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "calib/base/interruption.h"
#include "machine/config/machine_config.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/machine/devices/controls/linuxcnc/fault_series.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::CncFault;
using test::FailsWith;
using test::FakeLinuxCnc;
using ::testing::Contains;
using ::testing::HasSubstr;

MachineConfig config_of(const FakeLinuxCnc& fake) {
  MachineConfig config;
  config.control = test::control_of_fake(fake.port());
  return config;
}

Position<frame::Machine> place() {
  return position_mm<frame::Machine>(12.5, 40.25);
}

TEST(LinuxCnc, ReturnsWhereTheEncodersSayThatItStands) {
  FakeLinuxCnc fake({.encoder_mm = {0.003, -0.002, 0}});
  const auto control = internal::open_linuxcnc(config_of(fake));
  ASSERT_TRUE(control) << control.error().text();
  const auto standing = control->stage->move_to(place());
  ASSERT_TRUE(standing) << standing.error().text();
  EXPECT_NEAR(standing->in_mm().x(), 12.503, 1e-6);
  EXPECT_NEAR(standing->in_mm().y(), 40.248, 1e-6);
  EXPECT_EQ(control->words, "LinuxCNC at 127.0.0.1:" + std::to_string(fake.port()));
}

TEST(LinuxCnc, ReadsAMachineWhoseUnitIsTheInch) {
  FakeLinuxCnc fake({.is_inch = true,
                     .codes = "G0 G40 G20 G90 G94 G8",
                     .surface_mm = [](double, double) { return -12.125; }});
  const auto control = internal::open_linuxcnc(config_of(fake));
  ASSERT_TRUE(control) << control.error().text();
  const auto standing = control->stage->move_to(place());
  ASSERT_TRUE(standing) << standing.error().text();
  // A millionth of an inch is 25 nm.
  EXPECT_NEAR(standing->in_mm().x(), 12.5, 2e-5);
  const auto reading = control->probe->probe({});
  ASSERT_TRUE(reading) << reading.error().text();
  ASSERT_EQ(reading->heights.size(), 1U);
  EXPECT_NEAR(reading->heights[0].height.in_mm(), -0.125, 5e-5);
}

TEST(LinuxCnc, LiftsZBeforeXAndYMoveAndNeverLowersIt) {
  FakeLinuxCnc fake({});
  const auto control = internal::open_linuxcnc(config_of(fake));
  ASSERT_TRUE(control) << control.error().text();
  const auto drive_z = [&](double z_mm) {
    MachineConfig config = config_of(fake);
    config.control.safe_z = mm(z_mm);
    const auto other = internal::open_linuxcnc(config);
    return other && other->stage->move_to(place());
  };
  ASSERT_TRUE(drive_z(7));
  EXPECT_EQ(fake.place_mm().z(), 7);
  ASSERT_TRUE(drive_z(2));
  EXPECT_EQ(fake.place_mm().z(), 7);
  EXPECT_FALSE(fake.was_low_in_xy());
}

TEST(LinuxCnc, TakesTheTouchAndNotWhereTheAxisHasStopped) {
  FakeLinuxCnc fake({.surface_mm = [](double x, double y) { return -12 + x / 1000 - y / 500; }});
  const auto control = internal::open_linuxcnc(config_of(fake));
  ASSERT_TRUE(control) << control.error().text();
  ProbeRequest request;
  request.expected = position_mm<frame::Actual>(30, 20);
  request.work_zero = position_mm<frame::Machine>(100, 50);
  const auto reading = control->probe->probe(request);
  ASSERT_TRUE(reading) << reading.error().text();
  ASSERT_EQ(reading->heights.size(), 1U);
  EXPECT_NEAR(reading->heights[0].height.in_mm(), 0.13 - 0.14, 2e-6);
  EXPECT_EQ(fake.place_mm().z(), 0) << "lifted again";
}

TEST(LinuxCnc, AnswersThatNothingWasTouched) {
  FakeLinuxCnc fake({});
  const auto control = internal::open_linuxcnc(config_of(fake));
  ASSERT_TRUE(control) << control.error().text();
  const auto reading = control->probe->probe({});
  ASSERT_TRUE(reading) << reading.error().text();
  EXPECT_EQ(reading->status, ProbeStatus::NotFound);
  EXPECT_THAT(reading->reason, HasSubstr("-20"));
  EXPECT_EQ(fake.place_mm().z(), 0) << "lifted again";
}

TEST(LinuxCnc, GivesTheOperatorsModesBack) {
  FakeLinuxCnc fake({.codes = "G1 G40 G21 G91 G93 G8"});
  const auto control = internal::open_linuxcnc(config_of(fake));
  ASSERT_TRUE(control && control->stage->move_to(place()));
  const auto lines = fake.lines();
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(lines.front(), "#<_panelcal_feed>=#<_feed>");
  EXPECT_EQ(lines.back(), "G91 G93 F#<_panelcal_feed>");
}

/// Nothing has been sent that moves, and an operator's program is not aborted.
TEST(LinuxCnc, RefusesAMachineThatMustNotBeMoved) {
  const auto refusal = [](const FakeLinuxCnc::Setting& setting,
                          const std::function<void(FakeLinuxCnc&)>& change) {
    FakeLinuxCnc fake(setting);
    fake.set(change);
    const auto control = internal::open_linuxcnc(config_of(fake));
    EXPECT_THAT(control, FailsWith(Code::DeviceStage));
    EXPECT_TRUE(fake.lines().empty());
    return control ? std::string() : control.error().text();
  };
  const auto nothing = [](FakeLinuxCnc&) {};
  EXPECT_THAT(refusal({.is_homed = false}, nothing), HasSubstr("joint 1 is not homed"));
  EXPECT_THAT(refusal({.codes = "G0 G41 G8"}, nothing), HasSubstr("cutter compensation"));
  EXPECT_THAT(refusal({.codes = "G0 G40 G7"}, nothing), HasSubstr("diameter"));
  EXPECT_THAT(refusal({}, [](FakeLinuxCnc& fake) { fake.estop = true; }),
              HasSubstr("emergency stop"));
  EXPECT_THAT(refusal({}, [](FakeLinuxCnc& fake) { fake.is_on = false; }),
              HasSubstr("switched off"));
  EXPECT_THAT(refusal({}, [](FakeLinuxCnc& fake) { fake.has_program = true; }),
              HasSubstr("something else"));
  EXPECT_THAT(refusal({}, [](FakeLinuxCnc& fake) { fake.connect_password = "other"; }),
              HasSubstr("connect_password"));
  EXPECT_THAT(refusal({}, [](FakeLinuxCnc& fake) { fake.enable_password = "other"; }),
              HasSubstr("enable_password"));
}

TEST(LinuxCnc, MovesAMachineWithoutHomeIfTheMachineFileSaysSo) {
  FakeLinuxCnc fake({.is_homed = false});
  MachineConfig config = config_of(fake);
  config.control.homing = Homing::None;
  const auto control = internal::open_linuxcnc(config);
  ASSERT_TRUE(control) << control.error().text();
  EXPECT_TRUE(control->stage->move_to(place()));
}

TEST(LinuxCnc, NamesTheLimitThatTheControlNames) {
  FakeLinuxCnc fake({});
  const auto control = internal::open_linuxcnc(config_of(fake));
  ASSERT_TRUE(control) << control.error().text();
  EXPECT_THAT(control->stage->move_to(position_mm<frame::Machine>(900, 0)),
              FailsWith(Code::DeviceStage, "exceed X's positive limit"));
  EXPECT_TRUE(control->stage->move_to(place())) << "the next one goes";
}

TEST(LinuxCnc, RefusesToProbeWithAProbeThatTouchesAlready) {
  FakeLinuxCnc fake({.surface_mm = [](double, double) { return -9.0; }});
  const auto control = internal::open_linuxcnc(config_of(fake));
  ASSERT_TRUE(control) << control.error().text();
  EXPECT_THAT(control->probe->probe({}), FailsWith(Code::DeviceStage, "touches"));
}

TEST(LinuxCnc, ConnectsAgainBetweenTwoMoves) {
  FakeLinuxCnc fake({.fault_at = 24, .fault = CncFault::Close});
  const auto control = internal::open_linuxcnc(config_of(fake));
  ASSERT_TRUE(control) << control.error().text();
  int n_failed = 0;
  for (int i = 0; i < 4; ++i) n_failed += control->stage->move_to(place()) ? 0 : 1;
  EXPECT_EQ(n_failed, 1);
}

TEST(LinuxCnc, SaysSoIfItCannotStopTheMachine) {
  ASSERT_EQ(test::run_with_fault(CncFault::None, -1).text, "");
  const auto gone = test::run_with_fault(CncFault::Gone, -1, 2);
  EXPECT_THAT(gone.text, HasSubstr("could not be stopped"));
  EXPECT_THAT(gone.text, HasSubstr("stopped by hand"));
}

// Exit code 0: the machine is stopped although the signal is still there when the new connection
// is made.
void stop_over_a_new_connection() {
  heed_interruptions();
  FakeLinuxCnc fake(
      {.fault_in_move = 2, .fault = CncFault::Close, .at_fault = [] { kill(getpid(), SIGTERM); }});
  const auto control = internal::open_linuxcnc(config_of(fake));
  if (!control) std::_Exit(2);
  const auto moved = control->stage->move_to(position_mm<frame::Machine>(140, 90));
  if (moved) std::_Exit(3);
  if (interruption() != SIGTERM) std::_Exit(4);
  if (moved.error().text().find("the machine stands") == std::string::npos) {
    std::fputs(moved.error().text().c_str(), stderr);
    std::_Exit(5);
  }
  std::_Exit(fake.moves() ? 6 : 0);
}

TEST(LinuxCncDeathTest, ASignalDoesNotKeepItFromStoppingOverANewConnection) {
  EXPECT_EXIT(stop_over_a_new_connection(), ::testing::ExitedWithCode(0), "");
}

/// Faults that are noticed at once, in the second move and in the probing one; the slow series has
/// all, all over a job.
TEST(LinuxCnc, EndsEachFaultWithItsCauseAndTheMachineStanding) {
  for (const CncFault fault : {CncFault::Close,
                               CncFault::Garbage,
                               CncFault::Estop,
                               CncFault::Limit,
                               CncFault::Pause,
                               CncFault::Error}) {
    for (const int in_move : {2, 5}) {
      SCOPED_TRACE(::testing::Message() << static_cast<int>(fault) << " in move " << in_move);
      const auto job = test::run_with_fault(fault, -1, in_move);
      EXPECT_FALSE(job.moves_on);
      EXPECT_FALSE(job.was_low);
      EXPECT_THAT(job.text, HasSubstr(std::string(test::cause_of(fault))));
      EXPECT_THAT(job.text, HasSubstr("the machine stands"));
    }
  }
}

}  // namespace
}  // namespace panelcal
