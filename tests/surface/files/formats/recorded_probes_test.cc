// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "surface/files/probe_file.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using ::testing::ElementsAre;

/// As `run --save-probes` writes it, docs/formats/probes.md.
const std::string kRequest =
    R"("line":4,"command":"G73","tool":5,"nominal":[165,15],"expected":[165.4,14.9],"path":[0,1],"L":1,"reference":1.6)";
const std::string kTwoAxes = R"({"probe":0,)" + kRequest +
                             R"(,"zaxis":1,"height":1.6187,"sigma":0.003,"status":"found"})"
                             "\n"
                             R"({"probe":0,)" +
                             kRequest +
                             R"(,"zaxis":0,"height":1.6123,"sigma":0.002,"status":"found"})"
                             "\n"
                             R"({"probe":1,"nominal":[1,2],"status":"not_found","reason":"air"})"
                             "\n";

Expected<ProbeFile> read(const std::string& text, const ProbeFileOptions& options = {}) {
  return parse_probe_file(text, "probes.jsonl", options);
}

TEST(RecordedProbes, GivesTheChosenAxis) {
  const auto found = read(kTwoAxes, {.z_axis = 0});
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(found->points.size(), 1U);
  EXPECT_THAT(found->points[0].place.in_mm(), ElementsAre(165, 15));
  EXPECT_EQ(found->points[0].measured.height, mm(1.6123));
  EXPECT_EQ(found->points[0].measured.sigma, mm(0.002));
  EXPECT_EQ(found->points[0].name, "probe 0");
  EXPECT_EQ(found->points[0].from.line, 2);
  ASSERT_EQ(found->missing.size(), 1U);
  EXPECT_EQ(found->missing[0].name, "probe 1");
  EXPECT_EQ(found->missing[0].reason, "air");
}

TEST(RecordedProbes, DoesNotChooseAnAxisByItself) {
  EXPECT_THAT(read(kTwoAxes),
              FailsWith(Code::MeasurementFile, "probes.jsonl:1:1: error[measurement-file]"));
  EXPECT_THAT(read(kTwoAxes, {.z_axis = 2}), FailsWith(Code::MeasurementFile, "zaxis 2"));
}

/// A machine with one Z axis calls it 0, whichever of the machine's spindles that is.
TEST(RecordedProbes, SaysWhoseHeightsTheyAre) {
  const std::string head =
      R"({"probe":0,"nominal":[1,2],"status":"found","height":1,"sigma":0.01,)";
  const auto axis_of = [](const std::string& text, const ProbeFileOptions& options = {}) {
    const auto found = read(text, options);
    return found ? found->z_axis.value_or(-1) : -2;
  };
  EXPECT_EQ(axis_of(kTwoAxes, {.z_axis = 1}), 1);
  EXPECT_EQ(axis_of(kTwoAxes, {.z_axis = 0}), 0);
  EXPECT_EQ(axis_of(head + R"("zaxis":1})"), 1);
  EXPECT_EQ(axis_of(head + R"("zaxis":0})"), -1);
  EXPECT_EQ(axis_of(head + R"("zaxis":0})", {.z_axis = 0}), 0);
}

TEST(RecordedProbes, IsInMillimetersWithItsOwnSigma) {
  const auto found = read(kTwoAxes, {.sigma = mm(1), .unit = mm(1), .z_axis = 1});
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->points[0].measured.height, mm(1.6187));
  EXPECT_EQ(found->points[0].measured.sigma, mm(0.003));
  EXPECT_THAT(read(kTwoAxes, {.unit = inch(1), .z_axis = 1}),
              FailsWith(Code::MeasurementFile, "--unit inch"));
}

TEST(RecordedProbes, RefusesWhatContradictsItself) {
  const auto found_at = [](const char* nominal, int axis) {
    return R"({"probe":3,"nominal":)" + std::string(nominal) +
           R"(,"status":"found","height":1,"sigma":0.01,"zaxis":)" + std::to_string(axis) + "}\n";
  };
  const auto refused = [](const std::string& text, Code code, const char* message) {
    EXPECT_THAT(read(text), FailsWith(code, message));
  };
  refused(found_at("[1,2]", 0) + found_at("[1,2]", 0),
          Code::MeasurementFile,
          "probes.jsonl:2:77: error[measurement-file]");
  refused(found_at("[1,2]", 0) + found_at("[1,3]", 1),
          Code::MeasurementFile,
          "probes.jsonl:2:22: error[measurement-file]");
  refused(found_at("[1,2]", 0) + R"({"probe":3,"nominal":[1,2],"status":"not_found"})",
          Code::MeasurementFile,
          "probes.jsonl:2:");
  refused(R"({"probe":3,"nominal":[1,2],"status":"lost"})", Code::MeasurementFile, "\"lost\"");
  refused(R"({"probe":3,"nominal":[1,2],"status":"not_found","height":2})",
          Code::MeasurementFile,
          "probes.jsonl:1:");
  refused(R"({"probe":3,"nominal":[1,2],"status":"found","height":2,"sigma":0,"zaxis":0})",
          Code::MeasurementInvalid,
          "sigma");
  refused(R"({"probe":3,"nominal":[1,2],"status":"found","hight":2})",
          Code::MeasurementFile,
          "\"hight\"");
  refused("{\"probe\":", Code::JsonSyntax, "probes.jsonl:1:10: ");
}

}  // namespace
}  // namespace panelcal
