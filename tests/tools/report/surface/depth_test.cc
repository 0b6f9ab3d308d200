// SPDX-License-Identifier: Apache-2.0
#include "tools/report/surface/depth.h"

#include "machine/job/summary/depth_summary.h"
#include "tools/report/surface/depth_map.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

Expected<ZonedMap> no_map() {
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

/// A board that rises 20 um in 100 mm along x.
HeightMap sloping() {
  std::vector<ProbePoint> points;
  for (int i = 0; i < 36; ++i) {
    const Eigen::Vector2d p_mm = 20.0 * Eigen::Vector2d(i % 6, i / 6);
    const double wobble_mm = i % 2 == 0 ? 0.001 : -0.001;
    points.push_back({position_mm<frame::Nominal>(p_mm),
                      {mm(1.6 + 2e-4 * p_mm.x() + wobble_mm), um(2)},
                      "probe",
                      {}});
  }
  HeightMapOptions options;
  options.model = SurfaceModel::Plane;
  return HeightMap::of_probes(points, options).value();
}

TEST(ReportDepth, DrawsTheSurfaceOfEveryAxisWithWorstPlaces) {
  Drill drill;
  drill.nominal = position_mm<frame::Nominal>(80, 50);
  drill.tool = 3;
  drill.cut.depth = mm(0.2);
  drill.cut.surface = mm(1.6);
  drill.cut.other_surfaces = {mm(1.7)};
  DepthVerdict verdict(within(um(20), um(20)),
                       DepthErrors(um(3), {ZonedMap(sloping()), ZonedMap(sloping())}));
  verdict.put({.line = 7, .path = {}, .what = drill, .file = {}, .origin = nullptr});
  const std::string html = report::depth_section(&verdict);
  EXPECT_THAT(html, HasSubstr("Z axis 0. The surface that depths are judged by"));
  EXPECT_THAT(html, HasSubstr("Z axis 1. The surface that depths are judged by"));
  // The second axis counts on a height that is 84 um too high there: much too shallow.
  EXPECT_THAT(html, HasSubstr(" on Z axis 1</td>"));
  const auto second = html.find("Height above", html.find("Height above") + 1);
  const auto mark = html.find("<title>");
  EXPECT_GT(mark, second);
  EXPECT_EQ(html.find("<title>", mark + 1), std::string::npos);
  EXPECT_FALSE(report::depth_map_style(&verdict).empty());
}

TEST(ReportDepth, HasNoPictureOfWhatNobodyKnows) {
  DepthVerdict verdict(within(um(20), um(60)), um(10), no_map());
  EXPECT_EQ(report::depth_map_figures(verdict), "");
  EXPECT_TRUE(report::depth_map_style(&verdict).empty());
  EXPECT_TRUE(report::depth_map_style(nullptr).empty());
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
