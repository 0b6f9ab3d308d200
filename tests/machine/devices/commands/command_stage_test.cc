// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/commands/command_stage.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>

#include "calib/base/files/atomic_file.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

Position<frame::Machine> place() {
  return position_mm<frame::Machine>(12.5, -0.0000001);
}

/// A stage that is a line of shell; {x} and {y} are its $1 and $2.
CommandStage shell(const std::string& script, Time limit = seconds(10)) {
  return CommandStage({.move = {"sh", "-c", script, "sh", "{x}", "{y}"}, .limit = limit});
}

TEST(CommandStage, StandsWhereItWasSentIfTheProgramSaysNothing) {
  auto stage = shell("exit 0");
  const auto standing = stage.move_to(place());
  ASSERT_TRUE(standing) << standing.error().text();
  EXPECT_EQ(*standing, place()) << "to the bit, though the order was rounded to a nanometre";
}

TEST(CommandStage, PassesPlacesOnInMillimetres) {
  const test::TemporaryFolder folder;
  const auto file = (folder.path() / "words").string();
  CommandStage stage(
      {.move = {"sh", "-c", "printf '%s|' \"$@\" >" + file, "sh", "{x}", "y={y} {x}"}});
  ASSERT_TRUE(stage.move_to(place()));
  EXPECT_EQ(*read_file(file), "12.500000|y=0.000000 12.500000|") << "no -0.000000, no shell";
}

TEST(CommandStage, BelievesWhereTheProgramSaysItStands) {
  auto stage = shell("echo ' 12.503 ' -1e-3");
  const auto standing = stage.move_to(place());
  ASSERT_TRUE(standing) << standing.error().text();
  EXPECT_EQ(*standing, position_mm<frame::Machine>(12.503, -0.001));
}

TEST(CommandStage, RefusesAnAnswerThatIsNoPlace) {
  for (const char* answer : {"ok", "1", "1 2 3", "1,2", "1 x", "nan 1", "inf inf", "1e9 0"}) {
    auto stage = shell(std::string("echo '") + answer + "'");
    EXPECT_THAT(stage.move_to(place()), FailsWith(Code::DeviceStage)) << answer;
  }
}

TEST(CommandStage, AFailedOrderIsReportedWithItsLastWords) {
  auto stage = shell("echo moving; echo 'axis 2: limit switch' >&2; exit 4");
  EXPECT_THAT(stage.move_to(place()), FailsWith(Code::DeviceStage, "\"axis 2: limit switch\""));
  auto crash = shell("kill -SEGV $$");
  EXPECT_THAT(crash.move_to(place()), FailsWith(Code::DeviceStage, "signal 11"));
}

TEST(CommandStage, AProgramThatIsNotThereIsNamed) {
  CommandStage stage({.move = {"/nowhere/stage", "{x}", "{y}"}});
  EXPECT_THAT(stage.move_to(place()),
              FailsWith(Code::DeviceStage, "/nowhere/stage: error[device-stage]"));
}

TEST(CommandStage, AnOrderThatTakesTooLongIsStopped) {
  const test::TemporaryFolder folder;
  const auto file = (folder.path() / "halted").string();
  // The machine is told to halt before the program is ended.
  auto stage =
      shell("trap 'touch " + file + "; kill $!; exit' TERM; sleep 60 & wait", seconds(0.3));
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(stage.move_to(place()), FailsWith(Code::DeviceStage, "0.3 s"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
  EXPECT_TRUE(std::filesystem::exists(file));
}

TEST(CommandStage, AChildLeftBehindDoesNotHoldUpTheJob) {
  auto stage = shell("sleep 3 & exit 0");
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_TRUE(stage.move_to(place()));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(2));
}

/// From now on this thread may signal no program of root. Its saved user stays root, to come back.
extern "C" void become_another_user(int) {
  syscall(SYS_setresuid, 65534, 65534, -1);
}

/// A program under sudo is another user's: kill() has no effect. As root, which may signal all,
/// this process becomes another user while the program runs.
TEST(CommandStage, SaysThatAProgramOfAnotherUserCouldNotBeHalted) {
  const bool is_root = geteuid() == 0;
  struct sigaction action {};
  struct sigaction before {};
  action.sa_handler = become_another_user;
  sigaction(SIGALRM, &action, &before);
  const itimerval soon = {.it_interval = {}, .it_value = {.tv_sec = 0, .tv_usec = 200'000}};
  if (is_root) setitimer(ITIMER_REAL, &soon, nullptr);
  const CommandWords under_sudo = {"sudo", "-n", "sleep", "4"};
  CommandStage stage(
      {.move = is_root ? CommandWords{"sleep", "4"} : under_sudo, .limit = seconds(0.5)});
  const auto moved = stage.move_to(place());
  if (is_root) {
    ASSERT_EQ(syscall(SYS_setresuid, 0, 0, -1), 0);
  }
  sigaction(SIGALRM, &before, nullptr);
  EXPECT_THAT(moved, FailsWith(Code::DeviceStage, "could not be halted"));
  EXPECT_THAT(moved.error().text(), testing::HasSubstr("the machine may still move"));
}

TEST(CommandStage, AFloodOfOutputIsRefused) {
  auto stage = shell("yes | head -c 1000000");
  EXPECT_THAT(stage.move_to(place()), FailsWith(Code::DeviceStage, "64 KiB"));
}

TEST(CommandStage, SetsWhatItHasACommandFor) {
  const test::TemporaryFolder folder;
  const auto file = (folder.path() / "set").string();
  const auto append = [&](const char* what) {
    return CommandWords{"sh", "-c", "printf '%s ' \"$1\" >>" + file, "sh", what};
  };
  CommandStage stage(
      {.move = {"true", "{x}", "{y}"}, .lamp = append("L{lamp}"), .focus = append("Z{z}")});
  EXPECT_TRUE(stage.can_set(CameraSetting::Lamp));
  EXPECT_FALSE(stage.can_set(CameraSetting::Zoom));
  EXPECT_TRUE(stage.can_set(CameraSetting::Focus));
  EXPECT_TRUE(stage.set(CameraSetting::Lamp, 0.5));
  EXPECT_TRUE(stage.set(CameraSetting::Focus, -1.25));
  EXPECT_THAT(stage.set(CameraSetting::Zoom, 3), FailsWith(Code::NotSupported, "zoom"));
  EXPECT_EQ(*read_file(file), "L0.5 Z-1.250000 ");
}

TEST(Placeholders, AreCheckedBeforeAnythingMoves) {
  EXPECT_EQ(placeholder_problem({"move", "X{x}Y{y}"}, {"{x}", "{y}"}), "");
  EXPECT_EQ(placeholder_problem({"move", "{x}"}, {"{x}", "{y}"}), "{y} is missing");
  EXPECT_EQ(placeholder_problem({"move", "{x}", "{y}", "{z}"}, {"{x}", "{y}"}),
            "{z} has no meaning here");
  EXPECT_EQ(placeholder_problem({"move", "{x}", "{yy}"}, {"{x}", "{y}"}), "there is no \"{yy}\"");
  EXPECT_EQ(placeholder_problem({"awk", "{x}", "{y}", "{ print $1 }"}, {"{x}", "{y}"}), "")
      << "other braces belong to the program";
}

TEST(StageConfig, IsReadFromMachineToml) {
  const auto config = parse_machine_config(R"([machine]
stage_command = ["./drive", "{x}", "{y}"]
lamp_command = ["lamp", "{lamp}"]
command_limit_s = 2.5
settle_s = 0.25
)",
                                           "folder/machine.toml");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_THAT(config->stage.move, ::testing::ElementsAre("folder/./drive", "{x}", "{y}"));
  EXPECT_THAT(config->stage.lamp, ::testing::ElementsAre("lamp", "{lamp}"));
  EXPECT_TRUE(config->stage.zoom.empty());
  EXPECT_EQ(config->stage.limit.in_s(), 2.5);
  EXPECT_EQ(config->settle.in_s(), 0.25);
}

TEST(StageConfig, RefusesCommandsThatCannotWork) {
  const auto parse = [](const std::string& line) {
    return parse_machine_config("[machine]\n" + line + "\n", "machine.toml");
  };
  EXPECT_THAT(parse("stage_command = []"), FailsWith(Code::ConfigValue, "stage_command"));
  EXPECT_THAT(parse("stage_command = \"drive {x} {y}\""),
              FailsWith(Code::ConfigValue, "stage_command"));
  EXPECT_THAT(parse("stage_command = [\"drive\", \"{x}\"]"), FailsWith(Code::ConfigValue, "{y}"));
  EXPECT_THAT(parse("zoom_command = [\"zoom\", \"{lamp}\"]"),
              FailsWith(Code::ConfigValue, "{lamp}"));
  EXPECT_THAT(parse("settle_s = -1"), FailsWith(Code::ConfigValue, "settle_s"));
  EXPECT_THAT(parse("command_limit_s = 0"), FailsWith(Code::ConfigValue, "command_limit_s"));
}

}  // namespace
}  // namespace panelcal
