// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/commands/command_probe.h"

#include <string>

#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

/// A probe that is a line of shell; {x} and {y} are its $1 and $2.
CommandProbe shell(const std::string& script) {
  return CommandProbe({.probe = {"sh", "-c", script, "sh", "{x}", "{y}"}});
}

ProbeRequest request() {
  ProbeRequest out;
  out.expected = position_mm<frame::Actual>(12.5, -3);
  out.work_zero = position_mm<frame::Machine>(100, 200);
  return out;
}

TEST(CommandProbe, DrivesToMachineCoordinatesAndReadsTheHeight) {
  const auto reading =
      shell("[ $1 = 112.500000 -a $2 = 197.000000 ] && echo ' 1.6012'").probe(request());
  ASSERT_TRUE(reading) << reading.error().text();
  EXPECT_EQ(reading->status, ProbeStatus::Found);
  ASSERT_EQ(reading->heights.size(), 1U);
  EXPECT_EQ(reading->heights[0].height.in_mm(), 1.6012);
  EXPECT_EQ(reading->heights[0].sigma, Length()) << "the program does not say it";
}

TEST(CommandProbe, BelievesWhatTheProgramSaysOfItsScatter) {
  const auto reading = shell("echo -0.25 0.003").probe(request());
  ASSERT_TRUE(reading) << reading.error().text();
  EXPECT_EQ(reading->heights.at(0).height.in_mm(), -0.25);
  EXPECT_EQ(reading->heights.at(0).sigma.in_mm(), 0.003);
}

TEST(CommandProbe, ASurfaceThatIsNotTouchedIsAnAnswer) {
  const auto reading = shell("echo none").probe(request());
  ASSERT_TRUE(reading) << reading.error().text();
  EXPECT_EQ(reading->status, ProbeStatus::NotFound);
  EXPECT_EQ(reading->reason, "nothing was touched");
}

TEST(CommandProbe, RefusesWhatIsNoHeight) {
  for (const char* answer : {"", "ok", "1 2 3", "1,2", "nan", "inf", "1 -0.1", "1e9", "none 1"}) {
    EXPECT_THAT(shell(std::string("echo '") + answer + "'").probe(request()),
                FailsWith(Code::DeviceStage, "mm"))
        << answer;
  }
  EXPECT_THAT(shell("echo broken >&2; exit 4").probe(request()),
              FailsWith(Code::DeviceStage, "broken"));
}

}  // namespace
}  // namespace panelcal
