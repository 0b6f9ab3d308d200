// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/commands/void_sink.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal::surface {
namespace {

using test::FailsWith;

Position<frame::Nominal> at(double x_mm, double y_mm) {
  return position_mm<frame::Nominal>(x_mm, y_mm);
}

/// Passes operations as a walk on a perfect panel does.
class Walk {
 public:
  Walk() : sink_("panel.exc") {}

  Walk& tool(int number, std::optional<double> diameter_mm) {
    ToolChange change;
    change.tool.number = number;
    if (diameter_mm) change.tool.diameter = mm(*diameter_mm);
    tool_ = number;
    return put(change);
  }
  Walk& drill(double x_mm, double y_mm) {
    Drill drill;
    place(drill, x_mm, y_mm);
    drill.tool = tool_;
    return put(drill);
  }
  Walk& rapid(double x_mm, double y_mm) {
    RapidMove move;
    place(move, x_mm, y_mm);
    return put(move);
  }
  Walk& compensate(CompensationSide side) { return put(Compensation{side, std::nullopt}); }
  Walk& rout(double x_mm, double y_mm) {
    Rout rout;
    place(rout, x_mm, y_mm);
    rout.tool = tool_;
    return put(rout);
  }
  Walk& arc(RoutKind kind, double x_mm, double y_mm, double center_x_mm, double center_y_mm) {
    Rout rout;
    place(rout, x_mm, y_mm);
    rout.tool = tool_;
    rout.kind = kind;
    rout.corrected_center = position_mm<frame::Actual>(center_x_mm, center_y_mm);
    return put(rout);
  }
  Walk& slot(double x0_mm, double y0_mm, double x1_mm, double y1_mm) {
    Slot slot;
    place(slot.start, x0_mm, y0_mm);
    place(slot.end, x1_mm, y1_mm);
    slot.tool = tool_;
    return put(slot);
  }
  Expected<Voids> voids() {
    PANELCAL_TRY(auto all, sink_.take());
    return Voids::make(std::move(all));
  }

 private:
  static void place(PlacedPoint& point, double x_mm, double y_mm) {
    point.nominal = at(x_mm, y_mm);
    point.corrected = position_mm<frame::Actual>(x_mm, y_mm);
  }
  template <class What>
  Walk& put(const What& what) {
    Operation operation;
    operation.line = ++line_;
    operation.what = what;
    sink_.put(operation);
    return *this;
  }

  VoidSink sink_;
  int line_ = 0;
  int tool_ = 0;
};

TEST(VoidSink, TakesHolesOfTheirToolsSize) {
  const auto voids =
      Walk().tool(1, 0.8).drill(10, 10).drill(20, 10).tool(2, 3.0).drill(30, 10).voids();
  ASSERT_TRUE(voids) << voids.error().text();
  ASSERT_EQ(voids->all().size(), 3U);
  EXPECT_EQ(text_of(*voids->at(at(10.39, 10))), "\"hole of tool 1\" (panel.exc:2)");
  EXPECT_EQ(voids->at(at(10.41, 10)), nullptr);
  EXPECT_EQ(text_of(*voids->at(at(30, 11.49))), "\"hole of tool 2\" (panel.exc:5)");
}

TEST(VoidSink, TakesAHoleOnce) {
  const auto voids = Walk().tool(1, 0.8).drill(10, 10).drill(10, 10).voids();
  ASSERT_TRUE(voids) << voids.error().text();
  EXPECT_EQ(voids->all().size(), 1U);
}

TEST(VoidSink, TakesSlotsFromEndToEnd) {
  const auto voids = Walk().tool(4, 2.0).slot(0, 0, 10, 0).voids();
  ASSERT_TRUE(voids) << voids.error().text();
  EXPECT_EQ(text_of(*voids->at(at(5, 0.99))), "\"slot of tool 4\" (panel.exc:2)");
  EXPECT_EQ(voids->at(at(5, 1.01)), nullptr);
  EXPECT_NE(voids->at(at(10.99, 0)), nullptr);
}

TEST(VoidSink, TakesRoutsAsWideAsTheRouter) {
  const auto voids = Walk().tool(4, 2.0).rapid(0, 0).rout(20, 0).rout(20, 10).rapid(50, 50).voids();
  ASSERT_TRUE(voids) << voids.error().text();
  EXPECT_EQ(text_of(*voids->at(at(10, 0.9))), "\"rout of tool 4\" (panel.exc:3)");
  EXPECT_EQ(text_of(*voids->at(at(20.9, 5))), "\"rout of tool 4\" (panel.exc:4)");
  // A rapid move takes nothing away.
  EXPECT_EQ(voids->at(at(35, 30)), nullptr);
}

TEST(VoidSink, FollowsArcs) {
  // From (10, 0) about (0, 0) to (0, 10), counter-clockwise, and on to (-10, 0).
  const auto voids = Walk()
                         .tool(1, 1.0)
                         .rapid(10, 0)
                         .arc(RoutKind::Counterclockwise, 0, 10, 0, 0)
                         .arc(RoutKind::Counterclockwise, -10, 0, 0, 0)
                         .voids();
  ASSERT_TRUE(voids) << voids.error().text();
  for (int k = 0; k <= 18; ++k) {
    const double angle_rad = 0.17453292519943295 * k;
    const Eigen::Vector2d heading(std::cos(angle_rad), std::sin(angle_rad));
    // Chords are up to 2 um inside.
    EXPECT_NE(voids->at(position_mm<frame::Nominal>(10.497 * heading)), nullptr) << k;
    EXPECT_NE(voids->at(position_mm<frame::Nominal>(9.501 * heading)), nullptr) << k;
    EXPECT_EQ(voids->at(position_mm<frame::Nominal>(10.501 * heading)), nullptr) << k;
  }
  EXPECT_EQ(voids->at(at(0, -10)), nullptr);
}

TEST(VoidSink, RunsBesideACompensatedContour) {
  // Clockwise around a square, the tool on the left: outside.
  const auto voids = Walk()
                         .tool(1, 2.0)
                         .rapid(0, 0)
                         .compensate(CompensationSide::Left)
                         .rout(0, 10)
                         .rout(10, 10)
                         .rout(10, 0)
                         .rout(0, 0)
                         .voids();
  ASSERT_TRUE(voids) << voids.error().text();
  EXPECT_NE(voids->at(at(-1.99, 5)), nullptr);
  EXPECT_NE(voids->at(at(-0.01, 5)), nullptr);
  EXPECT_EQ(voids->at(at(0.01, 5)), nullptr);
  EXPECT_EQ(voids->at(at(-2.01, 5)), nullptr);
  // Around the corner at (0, 10) in an arc of 2 mm.
  EXPECT_NE(voids->at(at(-1.38, 11.38)), nullptr);
  EXPECT_EQ(voids->at(at(-1.45, 11.45)), nullptr);
  EXPECT_EQ(voids->at(at(5, 5)), nullptr);
}

TEST(VoidSink, RefusesToolsOfUnknownSize) {
  EXPECT_THAT(Walk().tool(1, 0.8).drill(1, 1).tool(3, {}).drill(2, 2).drill(3, 3).voids(),
              FailsWith(Code::DiameterMissing, "panel.exc:4:1: "));
  EXPECT_TRUE(Walk().tool(3, {}).voids());
}

}  // namespace
}  // namespace panelcal::surface
