// SPDX-License-Identifier: Apache-2.0
#include "panelcal/tools/report_depth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panelcal/tools/depth_summary.h"

namespace panelcal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Operation hole(int line, std::string_view file) {
  Drill drill;
  drill.tool = 1;
  drill.cut.depth = mm(0.2);
  return {.line = line, .path = {}, .what = drill, .file = file, .origin = nullptr};
}

/// Holes of which the machine finds the surface itself, to 10 um.
void judge(DepthVerdict& verdict, std::string_view file = {}) {
  verdict.put(hole(7, file));
  verdict.put(hole(8, file));
}

Expected<HeightMap> no_map() {
  return failure({Code::GridInvalid, {}, "there are 0 probes", "3 or more"});
}

Tolerances within(Length shallow, Length deep) {
  Tolerances tolerances;
  tolerances.depth = {shallow, deep};
  return tolerances;
}

TEST(ReportDepth, ShowsWhichSideIsAtRisk) {
  // 2 sigma to the one side, 6 to the other.
  DepthVerdict verdict(within(um(20), um(60)), um(10), no_map());
  judge(verdict);
  const std::string html = report::depth_section(&verdict);
  EXPECT_THAT(html, HasSubstr("<p><b>Hold: 2 depths are more likely than 0.01"));
  EXPECT_THAT(html, HasSubstr("<span class=\"chip refused\">0.023</span>"));
  EXPECT_THAT(html, HasSubstr("<span class=\"chip\">9.9 &#215; 10<sup>-10</sup></span>"));
  EXPECT_THAT(html, HasSubstr("no map of the surface: there are 0 probes"));
  EXPECT_THAT(report::depth_tile(&verdict), HasSubstr("0.046<small>of 2; "));
}

TEST(ReportDepth, IsNotThereWhereNothingIsAsked) {
  EXPECT_EQ(report::depth_section(nullptr), "");
  EXPECT_EQ(report::depth_tile(nullptr), "");
}

TEST(ReportDepth, EscapesNamesOfFiles) {
  DepthVerdict verdict(within(um(20), um(60)), um(10), no_map());
  judge(verdict, "<b>.sm");
  EXPECT_THAT(report::depth_section(&verdict), HasSubstr("line 7 of &lt;b&gt;.sm"));
  EXPECT_THAT(report::depth_section(&verdict), Not(HasSubstr("<b>.sm")));
}

TEST(DepthSummary, HasARowForEachTool) {
  DepthVerdict verdict(within(um(20), um(60)), um(10), no_map());
  judge(verdict);
  EXPECT_THAT(depth_summary(verdict),
              HasSubstr("    T1        2     20.0 / 60.0    +0.00    10.00      2      2   2.3e-02 "
                        "  9.9e-10\n"));
  EXPECT_THAT(depth_summary(verdict), HasSubstr("depth verdict: hold: 2 depths are"));
}

}  // namespace
}  // namespace panelcal
