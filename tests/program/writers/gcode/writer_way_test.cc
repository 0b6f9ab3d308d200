// SPDX-License-Identifier: Apache-2.0
// The written program leads the tool the way that the operations say, as our own reader has it.
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "program/gcode/block.h"
#include "program/gcode/motion.h"
#include "program/writers/gcode/writer.h"

#include "tests/program/operations.h"

namespace panelcal {
namespace {

using namespace test;

/// Rounding to nanometres, at both ends of an arc and at its centre.
constexpr double kRounding_mm = 5e-6;

GcodeSetting setting() {
  GcodeSetting setting;
  setting.safe_z = mm(5);
  setting.approach_z = mm(1);
  setting.usual.drill_z = mm(-1.8);
  setting.usual.rout_z = mm(-2);
  setting.usual.infeed = mm_per_s(20);
  setting.usual.speed = rpm(30'000);
  return setting;
}

std::vector<gcode::Motion> motions_of(const std::vector<What>& operations) {
  StringSink bytes;
  GcodeWriter writer(bytes, {.work_zero = position_mm<frame::Machine>(100, 200)}, setting());
  writer.begin(metric_info());
  put_all(writer, operations);
  const auto done = writer.finish();
  EXPECT_TRUE(done) << done.error().text();
  std::vector<gcode::Motion> motions;
  gcode::MotionReader reader("out.ngc");
  LineCursor cursor(bytes.text());
  while (!cursor.at_end()) {
    const auto block = gcode::read_gcode_block(cursor.next(), "out.ngc");
    if (!block) {
      ADD_FAILURE() << block.error().text();
      break;
    }
    const auto motion = reader.read(*block);
    if (!motion) {
      ADD_FAILURE() << motion.error().text() << "\n" << block->text;
      break;
    }
    if (*motion) motions.push_back(**motion);
  }
  EXPECT_TRUE(reader.has_ended());
  return motions;
}

TEST(GcodeWriterWay, HolesAreWhereTheMachineIsTold) {
  const std::uint64_t seed = 1;
  SCOPED_TRACE(seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> anywhere_mm(-400, 400);
  std::vector<What> operations = {ToolChange{{.number = 1, .diameter = mm(1)}, {}}};
  std::vector<Eigen::Vector2d> holes_mm;
  for (int i = 0; i < 400; ++i) {
    holes_mm.emplace_back(anywhere_mm(random), anywhere_mm(random));
    operations.emplace_back(drill(1, holes_mm.back().x(), holes_mm.back().y()));
  }
  std::size_t n = 0;
  for (const gcode::Motion& motion : motions_of(operations)) {
    if (motion.kind != gcode::MotionKind::Cycle) continue;
    ASSERT_LT(n, holes_mm.size());
    EXPECT_LT((motion.to.xy_mm() - holes_mm[n++]).norm(), kRounding_mm);
    EXPECT_EQ(motion.to.z_mm, -1.8);
    EXPECT_EQ(motion.retract_mm, 1);
    EXPECT_EQ(motion.travel_mm, 5);
  }
  EXPECT_EQ(n, holes_mm.size());
}

/// Chords from a thousandth of the shortest that is written as an arc up to half circles.
TEST(GcodeWriterWay, ArcsKeepTheirSenseAndSweep) {
  const std::uint64_t seed = 2;
  SCOPED_TRACE(seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  int n_arcs = 0;
  for (int i = 0; i < 20'000; ++i) {
    const double radius_mm = std::pow(10, -3 + 6 * unit(random));
    const double sweep_rad = std::numbers::pi * std::pow(10, -8 * unit(random));
    const double begin_rad = 2 * std::numbers::pi * unit(random);
    const bool is_clockwise = unit(random) < 0.5;
    const double end_rad = begin_rad + (is_clockwise ? -sweep_rad : sweep_rad);
    const Eigen::Vector2d center_mm(100 * unit(random), 100 * unit(random));
    const auto at = [&](double angle_rad) -> Eigen::Vector2d {
      return center_mm + radius_mm * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
    };
    const Eigen::Vector2d from_mm = at(begin_rad), to_mm = at(end_rad);
    const auto motions =
        motions_of({ToolChange{{.number = 1}, {}},
                    rapid_move(from_mm.x(), from_mm.y()),
                    Plunge{1, PlungeKind::Plain, {}, {}},
                    rout_arc(is_clockwise ? RoutKind::Clockwise : RoutKind::Counterclockwise,
                             1,
                             to_mm.x(),
                             to_mm.y(),
                             center_mm.x(),
                             center_mm.y()),
                    Retract{}});
    ASSERT_GE(motions.size(), 2u);
    const gcode::Motion& motion = motions[motions.size() - 2];
    if (!motion.is_arc()) {
      // A line, or nothing at all: the arc bulges by less than 0.1 um.
      const double bulge_mm = radius_mm * (1 - std::cos(sweep_rad / 2));
      EXPECT_LT(bulge_mm, 1e-4) << "radius " << radius_mm << ", sweep " << sweep_rad;
      EXPECT_LT((motion.to.xy_mm() - to_mm).norm(), kRounding_mm);
      continue;
    }
    ++n_arcs;
    EXPECT_EQ(motion.sweep_rad < 0, is_clockwise);
    EXPECT_LT((motion.to.xy_mm() - to_mm).norm(), kRounding_mm);
    const double begin_mm = (motion.from.xy_mm() - motion.center_mm).norm();
    const double end_mm = (motion.to.xy_mm() - motion.center_mm).norm();
    EXPECT_NEAR(begin_mm, end_mm, kRounding_mm);
    // Half way, which says that neither sweep nor centre is another one.
    const Eigen::Vector2d start_mm = motion.from.xy_mm() - motion.center_mm;
    const double half_rad = std::atan2(start_mm.y(), start_mm.x()) + motion.sweep_rad / 2;
    const Eigen::Vector2d half_mm =
        motion.center_mm + begin_mm * Eigen::Vector2d(std::cos(half_rad), std::sin(half_rad));
    EXPECT_LT((half_mm - at((begin_rad + end_rad) / 2)).norm(), 1e-4)
        << "radius " << radius_mm << ", sweep " << sweep_rad;
  }
  EXPECT_GT(n_arcs, 5000);
}

}  // namespace
}  // namespace panelcal
