// SPDX-License-Identifier: Apache-2.0
#include "machine/job/sources.h"

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/machine/small_panel.h"
#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

Survey nominal_of(std::string text, const WalkOptions& walk = {}) {
  DiagnosticLog log;
  return check(test::program_of(std::move(text)), walk, log).survey;
}

/// A program that drills one hole behind `block`.
Survey nominal_of_hole(std::string_view block = "", const WalkOptions& walk = {}) {
  return nominal_of("M48\nMETRIC,TZ\nT1C0.8\n%\nT1\n" + std::string(block) + "X1.0Y2.0\nM30\n",
                    walk);
}

/// One source of targets each.
std::vector<SourceChoice> choices_of_targets() {
  return {{.images = "nowhere"},
          {.measurements = "nowhere"},
          {.camera = "none://"},
          {.machine_driver = "sim"}};
}

TEST(OpenSources, NeedsNoneForAProgramWithoutTargets) {
  const auto sources = open_sources({}, {}, nominal_of_hole());
  ASSERT_TRUE(sources) << sources.error().text();
  EXPECT_EQ(sources->words, "no targets");
}

TEST(OpenSources, RefusesASourceThatTheProgramDoesNotUse) {
  for (const SourceChoice& choice : choices_of_targets()) {
    EXPECT_THAT(open_sources(choice, {}, nominal_of_hole()), FailsWith(Code::Usage, ""));
  }
}

TEST(OpenSources, OpensNoneForAProgramThatIsMeantUncorrected) {
  for (SourceChoice choice : choices_of_targets()) {
    choice.uncorrected = true;
    const auto sources = open_sources(choice, {}, nominal_of_hole());
    ASSERT_TRUE(sources) << sources.error().text();
    EXPECT_EQ(sources->words, "no targets");
  }
}

TEST(OpenSources, TakesAnOrderToCalibrateForAUse) {
  const Survey nominal = nominal_of_hole("G39X30.0Y10.0\n", {.has_coupon = true});
  EXPECT_TRUE(open_sources({.camera = "none://"}, {}, nominal));
}

TEST(OpenSources, RefusesToLeaveTargetsUncorrected) {
  EXPECT_THAT(open_sources({.uncorrected = true}, {}, nominal_of(std::string(test::kSmallProgram))),
              FailsWith(Code::Usage, ""));
}

TEST(OpenSources, RefusesTargetsWithoutASource) {
  EXPECT_THAT(open_sources({}, {}, nominal_of(std::string(test::kSmallProgram))),
              FailsWith(Code::Usage, ""));
}

TEST(OpenSources, TakesTargetsOfAVirtualMachineFromTheCheck) {
  const test::TemporaryFolder folder;
  const MachineConfig config = test::small_config(folder.path(), "", "");
  const Survey nominal = nominal_of(std::string(test::kSmallProgram), config.walk);
  const auto sources = open_sources({.machine_driver = "sim"}, config, nominal);
  ASSERT_TRUE(sources) << sources.error().text();
  const auto measured = sources->targets->measure(nominal.measurements.front().request);
  ASSERT_TRUE(measured) << measured.error().text();
  EXPECT_EQ(measured->status, MeasurementStatus::Found);
}

}  // namespace
}  // namespace panelcal
