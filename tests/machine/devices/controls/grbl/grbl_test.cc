// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/controls/grbl/grbl.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "calib/base/interruption.h"
#include "machine/devices/controls/grbl/machine.h"
#include "machine/devices/controls/open/open_control.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/machine/devices/controls/grbl/fake_grbl.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using grbl::Machine;
using test::FailsWith;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// The fake's moves are quick; only a control that is silent takes the time for an answer.
constexpr grbl::Talk::Patience kPatience{
    .quiet = seconds(0.003), .unread = seconds(0.01), .between_reports = seconds(0.001)};
/// Reports have three decimals.
constexpr double kReport_mm = 0.0006;

ControlSetting setting(Homing homing = Homing::Required) {
  ControlSetting out;
  out.driver = ControlKind::Grbl;
  out.homing = homing;
  out.safe_z = mm(-5);
  out.limit = seconds(20);
  out.probe = ControlProbe{100, mm(-8), mm(-20), mm(-15)};
  return out;
}

Expected<Machine> open(const FakeGrbl& control,
                       const ControlSetting& stated = setting(),
                       const grbl::Talk::Patience& patience = kPatience) {
  auto link = LineLink::tcp("127.0.0.1", control.port(), seconds(5));
  if (!link) return failure(std::move(link).error());
  return Machine::open(grbl::Talk(*std::move(link), patience), stated);
}

/// The orders that move something.
std::vector<std::string> moves(const FakeGrbl& control) {
  std::vector<std::string> out;
  for (const std::string& line : control.received()) {
    if (line.starts_with("$J") || line.find("G38") != std::string::npos) out.push_back(line);
  }
  return out;
}

TEST(Grbl, DrivesInMachineCoordinatesAndSaysWhereItStands) {
  FakeGrbl control({});
  auto machine = open(control);
  ASSERT_TRUE(machine) << machine.error().text();
  const auto at_mm = machine->move_to({-12.5, -40.125});
  ASSERT_TRUE(at_mm) << at_mm.error().text();
  EXPECT_NEAR(at_mm->x(), -12.5, kReport_mm);
  EXPECT_NEAR(at_mm->y(), -40.125, kReport_mm);
  EXPECT_THAT(moves(control), ElementsAre("$J=G53G21G90X-12.5000Y-40.1250F500.0"))
      << "Z stands above safe_z_mm and is not lowered";
  EXPECT_EQ(machine->words(),
            "GRBL 1.1h.20190830 at 127.0.0.1:" + std::to_string(control.port()) +
                " (no soft limits ($20=0))");
}

TEST(Grbl, LiftsZBeforeXAndYMove) {
  FakeGrbl control({.at_mm = {-100, -100, -9}});
  auto machine = open(control);
  ASSERT_TRUE(machine) << machine.error().text();
  ASSERT_TRUE(machine->move_to({-12, -40}));
  EXPECT_THAT(moves(control),
              ElementsAre("$J=G53G21G90Z-5.0000F500.0", "$J=G53G21G90X-12.0000Y-40.0000F500.0"));
}

TEST(Grbl, UnderstandsReportsInInches) {
  FakeGrbl control({.inches = true});
  auto machine = open(control);
  ASSERT_TRUE(machine) << machine.error().text();
  const auto at_mm = machine->move_to({-25.4, -50.8});
  ASSERT_TRUE(at_mm) << at_mm.error().text();
  EXPECT_NEAR(at_mm->x(), -25.4, 0.0013) << "four decimals of an inch";
  const auto z_mm = machine->probe_at({-25.4, -50.8});
  ASSERT_TRUE(z_mm) << z_mm.error().text();
  EXPECT_NEAR(*z_mm, -12.34, 0.0013);
}

TEST(Grbl, TakesTheWorkZeroBackWhereReportsStateWorkCoordinates) {
  FakeGrbl control({.work_only = true, .offset_mm = {10, 20, 30}});
  auto machine = open(control);
  ASSERT_TRUE(machine) << machine.error().text();
  const auto at_mm = machine->move_to({-12.5, -40});
  ASSERT_TRUE(at_mm) << at_mm.error().text();
  EXPECT_NEAR(at_mm->x(), -12.5, kReport_mm);
}

TEST(Grbl, NamesTheOffsetsThatDoNotMatter) {
  FakeGrbl control({.modes = "G0 G55 G17 G21 G90 G94",
                    .offsets = "[G54:1.000,0.000,0.000]\r\n[G55:2.000,0.000,0.000]\r\n"
                               "[G92:0.000,3.000,0.000]\r\n[TLO:1.500]\r\n"});
  const auto machine = open(control);
  ASSERT_TRUE(machine) << machine.error().text();
  EXPECT_THAT(machine->words(),
              HasSubstr("G55, G92, tool length not used: moves are in machine coordinates"));
}

TEST(Grbl, DoesNotCarryOutALineThatAnotherProgramHasLeftHalfWritten) {
  for (const std::string half : {"$J=G53G21G90X-50.0000F500.0", "$H", "G21G91G94G38.2Z-1F10"}) {
    FakeGrbl control({.half_line = half});
    const auto machine = open(control);
    ASSERT_TRUE(machine) << machine.error().text();
    EXPECT_EQ(control.received().front(), half + "$");
    EXPECT_EQ(control.end_mm(), (std::array<double, 3>{-100, -100, -1}));
  }
}

TEST(Grbl, RefusesAStateInWhichNothingMayMove) {
  for (const auto& [state, words] : {std::pair("Alarm", "locked by an alarm"),
                                     std::pair("Hold:0", "in feed hold"),
                                     std::pair("Door:1", "safety door"),
                                     std::pair("Check", "nothing moves"),
                                     std::pair("Sleep", "asleep"),
                                     std::pair("Alarm:11", "has to be homed"),
                                     std::pair("Run", "by another's order")}) {
    FakeGrbl control({.state = state});
    EXPECT_THAT(open(control), FailsWith(Code::DeviceStage, words));
    EXPECT_THAT(control.received(), ElementsAre()) << "nothing is unlocked";
  }
}

TEST(Grbl, HomesOnlyWhereTheMachineFileSaysSo) {
  FakeGrbl control({.state = "Alarm"});
  ASSERT_TRUE(open(control, setting(Homing::WhenLocked)));
  EXPECT_EQ(control.received().front(), "$H");
}

TEST(Grbl, RefusesAMachineWithoutHomeUnlessTheMachineFileKnows) {
  FakeGrbl control({.homing = false});
  EXPECT_THAT(open(control), FailsWith(Code::DeviceStage, "$22=0"));
  FakeGrbl other({.homing = false});
  const auto machine = open(other, setting(Homing::None));
  ASSERT_TRUE(machine) << machine.error().text();
  EXPECT_THAT(machine->words(), HasSubstr("not homed"));
}

TEST(Grbl, RefusesCoordinatesThatOpeningHasSetToZero) {
  FakeGrbl reset({.homing = false, .at_mm = {0, 0, 0}});
  EXPECT_THAT(open(reset, setting(Homing::None)),
              FailsWith(Code::DeviceStage, "was reset when its connection was opened"));
  EXPECT_THAT(moves(reset), ElementsAre());
  FakeGrbl again({.homing = false, .greets = false, .at_mm = {0, 0, 0}});
  EXPECT_TRUE(open(again, setting(Homing::None))) << "its serial device was open before";
  FakeGrbl kept({.homing = false, .at_mm = {0, 0, -0.004}});
  EXPECT_TRUE(open(kept, setting(Homing::None))) << "a greeting without a reset";
  FakeGrbl homed({.at_mm = {0, 0, 0}});
  EXPECT_TRUE(open(homed)) << "a reset would have locked it";
}

TEST(Grbl, WaitsForGrblHalToSayThatItIsHomed) {
  const std::string identity = "[VER:1.1f.20260817:]\r\n[FIRMWARE:grblHAL]\r\n";
  const auto stated = [](Homing homing) {
    ControlSetting out = setting(homing);
    out.probe.reset();
    return out;
  };
  FakeGrbl homed({.identity = identity, .full_extra = "|H:1"});
  EXPECT_TRUE(open(homed, stated(Homing::Required)));
  for (const auto& [extra, full_extra] : {std::pair("", "|H:0"), std::pair("|H:0", "")}) {
    FakeGrbl other({.identity = identity, .extra = extra, .full_extra = full_extra});
    EXPECT_THAT(open(other, stated(Homing::Required)),
                FailsWith(Code::DeviceStage, "the machine is not homed"));
  }
  grbl::Talk::Patience patience = kPatience;
  patience.answer = seconds(0.2);
  FakeGrbl silent({.identity = identity});
  EXPECT_THAT(open(silent, stated(Homing::Required), patience),
              FailsWith(Code::DeviceStage, "does not say whether the machine is homed"));
  FakeGrbl unhomed({.identity = identity});
  EXPECT_TRUE(open(unhomed, stated(Homing::None)));
}

TEST(Grbl, RefusesModesThatScaleOrTurnMoves) {
  FakeGrbl control({.modes = "G0 G54 G17 G21 G90 G94 G51"});
  EXPECT_THAT(open(control), FailsWith(Code::DeviceStage, "G51"));
}

TEST(Grbl, RefusesAPlaceOutsideTheTravelAndMovesOn) {
  FakeGrbl control({.travel_mm = 150});
  auto machine = open(control);
  ASSERT_TRUE(machine) << machine.error().text();
  EXPECT_THAT(machine->move_to({-151, -10}), FailsWith(Code::TravelExceeded, "$130"));
  EXPECT_THAT(machine->move_to({-10, 1}), FailsWith(Code::TravelExceeded, "$131"));
  EXPECT_THAT(moves(control), ElementsAre());
  EXPECT_TRUE(machine->move_to({-149, -10}));
}

TEST(Grbl, ProbesAndSetsItsModesBack) {
  FakeGrbl control({.modes = "G1 G54 G17 G20 G90 G94 M5"});
  auto machine = open(control);
  ASSERT_TRUE(machine) << machine.error().text();
  const auto z_mm = machine->probe_at({-30, -40});
  ASSERT_TRUE(z_mm) << z_mm.error().text();
  EXPECT_NEAR(*z_mm, -12.34, kReport_mm);
  EXPECT_THAT(moves(control),
              ElementsAre("$J=G53G21G90X-30.0000Y-40.0000F500.0",
                          "$J=G53G21G90Z-8.0000F500.0",
                          "G21G91G94G38.2Z-12.0000F100.0",
                          "$J=G53G21G90Z-5.0000F500.0"));
  EXPECT_EQ(control.modes(), "G90G20G94G1");
  EXPECT_NEAR(control.end_mm()[2], -5, kReport_mm);
}

TEST(Grbl, AProbeThatTouchesNothingStopsTheJob) {
  FakeGrbl control({.surface_mm = -100});
  auto machine = open(control);
  ASSERT_TRUE(machine) << machine.error().text();
  EXPECT_THAT(machine->probe_at({-30, -40}),
              FailsWith(Code::DeviceStage,
                        "ALARM:5 (the probe touched nothing on its way); the "
                        "machine stands at X-30.000 Y-40.000 Z-20.000 (Alarm)"));
  const auto before = control.received();
  EXPECT_THAT(machine->move_to({-31, -40}),
              FailsWith(Code::DeviceStage, "after an earlier failure"));
  EXPECT_EQ(control.received(), before) << "nothing is unlocked, nothing moves";
}

TEST(Grbl, AProbeThatIsTrippedDoesNotMove) {
  FakeGrbl control({.probe_is_tripped = true});
  auto machine = open(control);
  ASSERT_TRUE(machine) << machine.error().text();
  EXPECT_THAT(machine->probe_at({-30, -40}),
              FailsWith(Code::DeviceStage, "tripped before it moves"));
  EXPECT_THAT(moves(control), ElementsAre());
}

TEST(Grbl, AProbeThatStaysTrippedIsNamed) {
  FakeGrbl control({.probe_sticks = true});
  auto machine = open(control);
  ASSERT_TRUE(machine) << machine.error().text();
  EXPECT_THAT(machine->probe_at({-30, -40}), FailsWith(Code::DeviceStage, "though it was lifted"));
}

TEST(Grbl, DoesNotProbeWithATurningSpindle) {
  FakeGrbl control({.modes = "G0 G54 G17 G21 G90 G94 M3 S1000"});
  auto machine = open(control);
  ASSERT_TRUE(machine) << machine.error().text();
  EXPECT_THAT(machine->probe_at({-30, -40}), FailsWith(Code::DeviceStage, "spindle runs"));
  EXPECT_THAT(moves(control), ElementsAre());
}

TEST(Grbl, AMoveThatTakesTooLongIsCancelled) {
  FakeGrbl control({.mm_s = 1});
  ControlSetting stated = setting();
  stated.limit = seconds(0.1);
  auto machine = open(control, stated);
  ASSERT_TRUE(machine) << machine.error().text();
  EXPECT_THAT(machine->move_to({-10, -10}), FailsWith(Code::DeviceStage, "within 0.1 s"));
  EXPECT_EQ(control.received().back(), "jog cancel");
  EXPECT_FALSE(control.is_moving());
}

TEST(Grbl, ALostConnectionSaysThatTheMoveGoesOn) {
  // The first message during the jog is the question after it.
  FakeGrbl count({});
  {
    auto machine = open(count);
    ASSERT_TRUE(machine) << machine.error().text();
  }
  FakeGrbl control({.mm_s = 50, .fault = GrblFault::Close, .at_message = count.n_messages() + 3});
  auto machine = open(control);
  ASSERT_TRUE(machine) << machine.error().text();
  EXPECT_THAT(machine->move_to({-90, -100}),
              FailsWith(Code::DeviceStage,
                        "lost connection: the control has closed it; it could not "
                        "be stopped, and the move in hand may go on to X-90.000"));
}

// Exit code 0: a move is cancelled when a signal asks to end, and a probing move is held.
void stop_on_signal(bool is_probing) {
  heed_interruptions();
  FakeGrbl control({.mm_s = is_probing ? 5.0 : 1.0, .surface_mm = -100});
  ControlSetting stated = setting();
  stated.probe->from = stated.safe_z;
  auto machine = open(control, stated);
  if (!machine) std::_Exit(2);
  std::jthread killer([&] {
    const std::string_view awaited = is_probing ? "G38" : "$J";
    for (;;) {
      const auto sent = control.received();
      if (!sent.empty() && sent.back().find(awaited) != std::string::npos) break;
      std::this_thread::yield();
    }
    kill(getpid(), SIGTERM);
  });
  Expected<void> ended;
  if (is_probing) {
    ended = machine->probe_at({-100, -100}).map([](double) {});
  } else {
    ended = machine->move_to({-10, -10}).map([](const auto&) {});
  }
  killer.join();
  if (ended || ended.error().code != Code::Interrupted) std::_Exit(3);
  if (ended.error().what.find("the machine stands at") == std::string::npos) std::_Exit(4);
  const auto sent = control.received();
  const std::string_view awaited = is_probing ? "!" : "jog cancel";
  if (std::ranges::find(sent, awaited) == sent.end()) std::_Exit(5);
  std::_Exit(control.is_moving() ? 6 : 0);
}

TEST(GrblDeathTest, ASignalStopsTheMove) {
  EXPECT_EXIT(stop_on_signal(false), ::testing::ExitedWithCode(0), "");
}

TEST(GrblDeathTest, ASignalStopsTheProbe) {
  EXPECT_EXIT(stop_on_signal(true), ::testing::ExitedWithCode(0), "");
}

/// Drives, probes and drives; the failure, if there is one.
std::optional<Diagnostic> session(const FakeGrbl& control,
                                  const grbl::Talk::Patience& patience = kPatience) {
  auto machine = open(control, setting(), patience);
  if (!machine) return machine.error();
  for (const double x_mm : {-10.0, -20.0}) {
    if (const auto moved = machine->move_to({x_mm, -30}); !moved) return moved.error();
    if (const auto touched = machine->probe_at({x_mm, -40}); !touched) return touched.error();
  }
  return std::nullopt;
}

TEST(Grbl, EndsEachFaultAtEachMessageWithItsCauseAndTheMachineStopped) {
  FakeGrbl sound({});
  ASSERT_FALSE(session(sound));
  const int n_messages = sound.n_messages();
  int n_faults = 0;
  for (const auto& [fault, cause] : {std::pair(GrblFault::Close, "lost connection"),
                                     std::pair(GrblFault::Garbage, "answers \"<Id"),
                                     std::pair(GrblFault::Error, "error:20"),
                                     std::pair(GrblFault::Alarm, "ALARM:1 (a limit switch was hit"),
                                     std::pair(GrblFault::Reset, "reset"),
                                     std::pair(GrblFault::Hold, "Hold:0"),
                                     std::pair(GrblFault::Door, "Door:0")}) {
    // Before message 4 the control wakes up, and anything but silence and its end is passed over.
    const int first = fault == GrblFault::Close ? 1 : 4;
    for (int at = first; at <= n_messages; ++at, ++n_faults) {
      FakeGrbl control({.fault = fault, .at_message = at});
      const auto ended = session(control);
      if (!ended && control.n_messages() < at) break;  // fewer questions were asked than before
      ASSERT_TRUE(ended) << cause << " at message " << at;
      EXPECT_EQ(ended->code, Code::DeviceStage) << ended->text();
      EXPECT_THAT(ended->what, HasSubstr(cause)) << "at message " << at;
      if (fault != GrblFault::Close) {
        EXPECT_FALSE(control.is_moving()) << ended->text();
        EXPECT_THAT(ended->what, Not(HasSubstr("could not be stopped")));
      }
    }
  }
  EXPECT_GE(n_faults, 200);
}

TEST(Grbl, AControlThatFallsSilentIsNotTakenForStopped) {
  FakeGrbl sound({});
  ASSERT_FALSE(session(sound));
  for (int at = 1; at <= sound.n_messages(); at += 9) {
    FakeGrbl control({.fault = GrblFault::Silence, .at_message = at});
    const auto ended = session(control, {.answer = seconds(0.1), .quiet = seconds(0.003)});
    if (!ended && control.n_messages() < at) break;
    ASSERT_TRUE(ended) << at;
    EXPECT_EQ(ended->code, Code::DeviceStage) << ended->text();
    EXPECT_THAT(ended->what, HasSubstr("answer")) << at;
    EXPECT_THAT(ended->what, Not(HasSubstr("stands"))) << at;
  }
}

TEST(Grbl, OpensAsTheMachineFileSays) {
  FakeGrbl control({});
  MachineConfig config;
  config.control = setting();
  config.control.host = "127.0.0.1";
  config.control.port = control.port();
  config.travel =
      Travel{position_mm<frame::Machine>(-150, -150), position_mm<frame::Machine>(0, 0)};
  config.stage.lamp = {"true", "{lamp}"};
  const auto opened = open_control(config);
  ASSERT_TRUE(opened) << opened.error().text();
  EXPECT_THAT(opened->words, HasSubstr("GRBL 1.1h.20190830 at 127.0.0.1"));
  EXPECT_TRUE(opened->stage->can_set(CameraSetting::Lamp));
  EXPECT_FALSE(opened->stage->can_set(CameraSetting::Zoom));
  EXPECT_TRUE(opened->stage->move_to(position_mm<frame::Machine>(-10, -20)));
  EXPECT_THAT(opened->stage->move_to(position_mm<frame::Machine>(-151, -20)),
              FailsWith(Code::TravelExceeded, "travel_low_mm"));
  ProbeRequest request;
  request.expected = position_mm<frame::Actual>(12.5, -3);
  request.work_zero = position_mm<frame::Machine>(-100, -50);
  const auto reading = opened->probe->probe(request);
  ASSERT_TRUE(reading) << reading.error().text();
  EXPECT_NEAR(reading->heights.at(0).height.in_mm(), -12.34 - -15, kReport_mm);
  EXPECT_THAT(moves(control), ::testing::Contains("$J=G53G21G90X-87.5000Y-53.0000F500.0"));
  request.expected = position_mm<frame::Actual>(-60, 0);
  EXPECT_THAT(opened->probe->probe(request), FailsWith(Code::TravelExceeded));
}

}  // namespace
}  // namespace panelcal
