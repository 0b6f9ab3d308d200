// SPDX-License-Identifier: Apache-2.0
#include "machine/job/sources.h"

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

TEST(OpenSources, NeedsNoneForAProgramWithoutTargets) {
  const auto sources = open_sources(
      {.camera = "none://"}, {}, nominal_of("M48\nMETRIC,TZ\nT1C0.8\n%\nT1\nX1.0Y2.0\nM30\n"));
  ASSERT_TRUE(sources) << sources.error().text();
  EXPECT_EQ(sources->words, "no targets");
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
