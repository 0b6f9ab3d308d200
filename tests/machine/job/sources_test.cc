// SPDX-License-Identifier: Apache-2.0
#include "machine/job/sources.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "vision/picture/files/image_io.h"
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

TEST(OpenSources, DrivesTheCameraBackAfterAProbe) {
  const test::TemporaryFolder folder;
  MachineConfig config = test::small_config(folder.path());
  const auto orders = (folder.path() / "orders").string();
  config.stage.move = {"sh", "-c", "echo look $1 $2 >>" + orders, "sh", "{x}", "{y}"};
  config.stage.probe = {"sh", "-c", "echo probe >>" + orders + "; echo 1.5", "sh", "{x}", "{y}"};
  const auto pictures = folder.path() / "pictures";
  ASSERT_TRUE(std::filesystem::create_directory(pictures));
  for (const char* name : {"1.png", "2.png", "3.png"}) {
    ASSERT_TRUE(write_png(pictures / name, Image(280, 240, Image::kFullScale8, 20)));
  }
  Survey nominal = nominal_of(std::string(test::kSmallProgram), config.walk);
  nominal.probes.emplace_back();
  const auto sources = open_sources({.camera = "folder:" + pictures.string()}, config, nominal);
  ASSERT_TRUE(sources) << sources.error().text();
  ASSERT_NE(sources->eye, nullptr);
  const View view{.axis = position_mm<frame::Machine>(150, 80)};
  const auto look = [&] {
    const auto taken = sources->eye->take({}, view);
    EXPECT_TRUE(taken) << taken.error().text();
  };
  look();
  look();
  const auto reading = sources->probes->probe({});
  ASSERT_TRUE(reading) << reading.error().text();
  EXPECT_EQ(reading->heights.at(0).height.in_mm(), 1.5);
  look();
  // The camera is at X45, Y-3 of the spindle.
  EXPECT_EQ(*read_file(orders), "look 105.000000 83.000000\nprobe\nlook 105.000000 83.000000\n");
}

}  // namespace
}  // namespace panelcal
