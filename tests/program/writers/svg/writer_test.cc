// SPDX-License-Identifier: Apache-2.0
#include "program/writers/svg/writer.h"

#include <array>
#include <cmath>

#include "tests/program/operations.h"

namespace panelcal {
namespace {

using namespace test;
using ::testing::HasSubstr;
using ::testing::Not;

std::string svg_of(const std::vector<What>& operations, SvgScene scene = {}) {
  return written<SvgWriter>(operations, metric_info(), std::move(scene));
}

std::size_t count(std::string_view text, std::string_view part) {
  std::size_t n = 0;
  for (auto at = text.find(part); at != std::string_view::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

/// Every element that is opened is closed in order; no attribute holds a bare mark.
void expect_well_formed(std::string_view text) {
  std::vector<std::string> open;
  for (auto at = text.find('<'); at != std::string_view::npos; at = text.find('<', at)) {
    const auto end = text.find('>', at);
    ASSERT_NE(end, std::string_view::npos);
    const std::string_view tag = text.substr(at + 1, end - at - 1);
    ASSERT_EQ(tag.find('<'), std::string_view::npos) << tag;
    ASSERT_EQ(count(tag, "\"") % 2, 0U) << tag;
    const std::string name(tag.substr(0, tag.find_first_of(" /", 1)));
    if (tag.starts_with('/')) {
      ASSERT_FALSE(open.empty());
      ASSERT_EQ("/" + open.back(), name);
      open.pop_back();
    } else if (!tag.ends_with('/')) {
      open.push_back(name);
    }
    at = end;
  }
  EXPECT_TRUE(open.empty()) << open.back();
}

/// x, y, width and height of the view box.
std::array<double, 4> view_box(const std::string& svg) {
  std::array<double, 4> box{};
  std::size_t at = svg.find("viewBox=\"") + 9;
  for (double& number : box) {
    std::size_t length = 0;
    number = std::stod(svg.substr(at), &length);
    at += length;
  }
  return box;
}

TEST(SvgWriter, DrawsHolesToScaleAboveTheirGround) {
  const std::string svg = svg_of({drill(1, 5, 7), drill(1, 6, 7.1234567), drill(2, 50, 60)});
  expect_well_formed(svg);
  EXPECT_THAT(svg,
              HasSubstr("<g transform=\"scale(1,-1)\">\n<g class=\"t1\" fill=\"#3314b0\">\n"
                        "<circle cx=\"5\" cy=\"7\" r=\"0.5\"/>\n"
                        "<circle cx=\"6\" cy=\"7.123\" r=\"0.5\"/>\n</g>\n"
                        "<g class=\"t2\" fill=\"#ff7f13\">\n"
                        "<circle cx=\"50\" cy=\"60\" r=\"1.25\"/>\n</g>\n</g>\n"));
  const auto [x, y, width, height] = view_box(svg);
  EXPECT_LT(x, 5 - 0.5);
  EXPECT_GT(x + width, 50 + 1.25);
  EXPECT_LT(y, -60 - 1.25);
  EXPECT_GT(y + height, -7 + 0.5);
}

TEST(SvgWriter, ListsToolsWithCounts) {
  const std::string svg = svg_of({ToolChange{{.number = 9}, {}},
                                  drill(1, 0, 0),
                                  drill(1, 1, 1),
                                  Slot{1, place(0, 0), place(5, 0)},
                                  drill(9, 2, 2)});
  EXPECT_THAT(svg, HasSubstr(">T1, 1 mm</text>"));
  EXPECT_THAT(svg, HasSubstr(">2 holes, 1 slot</text>"));
  EXPECT_THAT(svg, HasSubstr(">T9, diameter unknown, drawn 0.5 mm</text>"));
  EXPECT_THAT(svg, HasSubstr("cx=\"2\" cy=\"2\" r=\"0.25\""));
  EXPECT_THAT(svg, Not(HasSubstr("T2,")));
}

TEST(SvgWriter, DataOfTheBodyCount) {
  const std::string svg =
      svg_of({ToolChange{{.number = 9, .diameter = mm(3)}, {}}, drill(9, 2, 2)});
  EXPECT_THAT(svg, HasSubstr("cx=\"2\" cy=\"2\" r=\"1.5\""));
  EXPECT_THAT(svg, HasSubstr(">T9, 3 mm</text>"));
}

TEST(SvgWriter, HolesWithoutAToolAreOutlines) {
  const std::string svg = svg_of({drill(0, 1, 2)});
  EXPECT_THAT(svg, HasSubstr("<g class=\"untooled\">\n<circle cx=\"1\" cy=\"2\" r=\"0.25\"/>"));
  EXPECT_THAT(svg, HasSubstr(">no tool, diameter unknown"));
}

TEST(SvgWriter, DrawsContoursWithTheirCenterLine) {
  const std::string svg = svg_of({rapid_move(0, 0),
                                  Plunge{2},
                                  rout_line(2, 10, 0),
                                  rout_arc(RoutKind::Counterclockwise, 2, 10, 4, 10, 2),
                                  rout_arc(RoutKind::Clockwise, 2, 8, 6, 10, 6),
                                  Retract{},
                                  drill(1, 3, 3)});
  expect_well_formed(svg);
  const std::string path = "d=\"M0 0L10 0A2 2 0 0 1 10 4A2 2 0 0 0 8 6\"";
  EXPECT_THAT(
      svg,
      HasSubstr("<path " + path + " class=\"rout\" stroke=\"#ff7f13\" stroke-width=\"2.5\"/>"));
  EXPECT_EQ(count(svg, path), 2U);
  EXPECT_THAT(svg, HasSubstr(">3 rout moves</text>"));
  EXPECT_THAT(svg, Not(HasSubstr("center of the router")));
}

TEST(SvgWriter, ShiftsCompensatedRoutsByHalfOfTheValue) {
  const auto contour = [](CompensationSide side) {
    return svg_of({rapid_move(0, 0),
                   Compensation{side, mm(2)},
                   Plunge{2},
                   rout_line(2, 10, 0),
                   rout_arc(RoutKind::Counterclockwise, 2, 10, 8, 10, 4),
                   rout_arc(RoutKind::Clockwise, 2, 10, 12, 10, 10),
                   Retract{},
                   rapid_move(20, 0),
                   Plunge{2},
                   rout_line(2, 30, 0),
                   Retract{}});
  };
  const std::string left = contour(CompensationSide::Left);
  EXPECT_THAT(left, HasSubstr("d=\"M0 1L10 1M10 1A3 3 0 0 1 10 7M10 7A3 3 0 0 0 10 13\""));
  EXPECT_THAT(left, HasSubstr("d=\"M20 0L30 0\""));  // the rapid move ended it
  EXPECT_THAT(left, HasSubstr("center of the router"));
  EXPECT_THAT(contour(CompensationSide::Right),
              HasSubstr("d=\"M0 -1L10 -1M10 -1A5 5 0 0 1 10 9M10 9A1 1 0 0 0 10 11\""));
}

TEST(SvgWriter, InsideArcsThatTheRouterFillsShrinkToAPoint) {
  const std::string svg = svg_of({rapid_move(1, 0),
                                  Compensation{CompensationSide::Left, mm(4)},
                                  Plunge{2},
                                  rout_arc(RoutKind::Counterclockwise, 2, -1, 0, 0, 0),
                                  Retract{}});
  EXPECT_THAT(svg, HasSubstr("d=\"M0 0A0 0 0 0 1 0 0\""));
}

TEST(SvgWriter, DrawsSlotsAsWideLines) {
  const std::string svg = svg_of(
      {Slot{1, place(1, 2), place(5, 2)}, StepSlot{2, place(1, 6), place(5, 6), mm(1), mm(-1)}});
  EXPECT_THAT(svg,
              HasSubstr("<path d=\"M1 2L5 2\" class=\"way\" stroke=\"#3314b0\" "
                        "stroke-width=\"1\"/>"));
  EXPECT_THAT(svg,
              HasSubstr("<path d=\"M1 6L5 6\" class=\"way\" stroke=\"#ff7f13\" "
                        "stroke-width=\"2.5\"/>"));
}

TEST(SvgWriter, ShowsRapidMovesIfAsked) {
  const std::vector<What> operations = {rapid_move(0, 0),
                                        Plunge{2},
                                        rout_line(2, 4, 0),
                                        Retract{},
                                        rapid_move(9, 9),
                                        Plunge{2},
                                        rout_line(2, 8, 0),
                                        Retract{}};
  SvgScene scene;
  EXPECT_THAT(svg_of(operations, scene), HasSubstr("<path class=\"rapid\" d=\"M4 0L9 9\"/>"));
  scene.shows_rapid_moves = false;
  EXPECT_THAT(svg_of(operations, scene), Not(HasSubstr("class=\"rapid\"")));
}

TEST(SvgWriter, MarksTargetsAndMagnifiesResiduals) {
  const std::vector<What> operations = {drill(1, 0, 0), drill(1, 100, 100)};
  SvgScene scene;
  scene.targets = {
      {position_mm<frame::Actual>(-20, 50), "A<1>", {}},
      {position_mm<frame::Actual>(90, 50), "", displacement_mm<frame::Actual>(0.01, 0)}};
  const std::string svg = svg_of(operations, scene);
  expect_well_formed(svg);
  EXPECT_EQ(count(svg, "class=\"target\""), 2U);
  EXPECT_THAT(svg, HasSubstr(">A&lt;1&gt;</text>"));
  EXPECT_THAT(svg, HasSubstr("<path class=\"residual\" d=\"M90 50L100 50M"));
  EXPECT_THAT(svg, HasSubstr(">residual, drawn 1,000 times longer</text>"));
  EXPECT_THAT(svg, HasSubstr(">longest 10 um</text>"));
  EXPECT_LT(view_box(svg)[0], -20);
}

TEST(SvgWriter, EscapesTextsAndKeepsProvenance) {
  SvgScene scene;
  scene.title = "a<b>&\"c\".exc";
  scene.provenance = {"made by: panelcal", std::string(1000, 'x') + "&\x01\xff"};
  const std::string svg = svg_of({drill(1, 0, 0)}, scene);
  expect_well_formed(svg);
  EXPECT_THAT(svg, HasSubstr("<title>a&lt;b&gt;&amp;&quot;c&quot;.exc</title>"));
  EXPECT_THAT(svg, HasSubstr("class=\"title\">a&lt;b&gt;&amp;"));
  EXPECT_THAT(svg, HasSubstr("<desc>made by: panelcal\n" + std::string(1000, 'x') + "&amp;??\n"));
  EXPECT_GT(count(svg, "class=\"small\""), 2U);  // long lines are broken
}

TEST(SvgWriter, AnEmptyJobIsAPictureToo) {
  const std::string svg = svg_of({});
  expect_well_formed(svg);
  const auto [x, y, width, height] = view_box(svg);
  EXPECT_GT(width, 0);
  EXPECT_GT(height, 0);
  EXPECT_TRUE(std::isfinite(x) && std::isfinite(y));
}

class SvgInstances : public ::testing::Test {
 protected:
  void drill_at(std::vector<int> path, double x_mm, double y_mm, double placed_x_mm) {
    const Placement placement(Eigen::Matrix2d::Identity(), Eigen::Vector2d(placed_x_mm, 0));
    Origin origin;
    origin.placement = &placement;
    const Drill hole = drill(1, x_mm, y_mm);
    instances_.add({1, path, hole, {}, &origin}, hole, 0.5);
  }

  svg::Instances instances_;
};

TEST_F(SvgInstances, FrameTheHolesOfEachPlacement) {
  for (const double y_mm : {0.0, 5.0}) {
    drill_at({0}, 1, y_mm, 0);
    drill_at({1}, 11, y_mm, 10);
  }
  EXPECT_EQ(instances_.n(), 2U);
  EXPECT_EQ(instances_.frames(), "M0.5 -0.5H1.5V5.5H0.5zM10.5 -0.5H11.5V5.5H10.5z");
}

TEST_F(SvgInstances, TheSamePathInAnotherSectionMayBeAnotherPlace) {
  drill_at({1}, 11, 0, 10);
  drill_at({1}, 12, 0, 10);
  drill_at({1}, 51, 0, 50);
  EXPECT_EQ(instances_.n(), 2U);
  EXPECT_EQ(instances_.frames(), "M10.5 -0.5H12.5V0.5H10.5z");  // none around a single hole
}

TEST_F(SvgInstances, AreAtMostTwoThousand) {
  drill_at({}, 0, 0, 0);
  EXPECT_EQ(instances_.n(), 0U);
  for (int i = 0; i < 2000; ++i) drill_at({i}, i, 0, i);
  EXPECT_TRUE(instances_.is_complete());
  drill_at({2000}, 0, 0, 0);
  drill_at({1999}, 1999, 4, 1999);
  EXPECT_FALSE(instances_.is_complete());
  EXPECT_EQ(instances_.n(), 2000U);
  EXPECT_EQ(instances_.frames(), "M1998.5 -0.5H1999.5V4.5H1998.5z");
}

TEST(SvgSheet, ToolColorsDifferAndShowOnWhite) {
  std::vector<std::string> seen;
  for (std::size_t i = 0; i < 40; ++i) {
    const svg::Color color = svg::tool_color(i);
    const double luma = 0.3 * color.red + 0.59 * color.green + 0.11 * color.blue;
    EXPECT_LT(luma, 0.73 * 255) << i;
    EXPECT_EQ(color.hex().size(), 7U);
    EXPECT_EQ(count(::testing::PrintToString(seen), color.hex()), 0U) << i;
    seen.push_back(color.hex());
  }
}

TEST(SvgSheet, NiceNumbersAreBelow) {
  EXPECT_DOUBLE_EQ(svg::nice_below(1), 1);
  EXPECT_DOUBLE_EQ(svg::nice_below(0.99), 0.5);
  EXPECT_DOUBLE_EQ(svg::nice_below(4999), 2000);
  EXPECT_DOUBLE_EQ(svg::nice_below(5e-3), 5e-3);
}

}  // namespace
}  // namespace panelcal
