// SPDX-License-Identifier: Apache-2.0
// SIEB & MEYER manual, chapter 3.1, G45 to G50, and 3.3, G43: figures that the control routs by
// itself. The tool is 2 mm in diameter, as in the manual's calculations of plunge points.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;
using test::IsNearMatrix;
using test::Piece;
using test::pieces_from;
using test::ProgramRun;
using test::run_5000;

constexpr double kRounding_mm = 1e-6;
/// The manual works with 0.707 and 1.707 and prints three decimals.
constexpr double kManualRounding_mm = 1.1e-3;

/// Remembers each figure of a program: where the tool plunged and what it routed then.
class FigureSink final : public OperationSink {
 public:
  struct Figure {
    int line = 0;
    Vector2d plunge_mm = Vector2d::Zero();
    std::vector<Rout> routs;
    bool is_retracted = false;

    std::vector<Piece> pieces() const { return pieces_from(plunge_mm, routs); }
  };

  void put(const Operation& operation) override {
    if (const auto* move = std::get_if<RapidMove>(&operation.what)) {
      at_mm_ = move->actual.in_mm();
      ++n_moves_;
    }
    if (std::holds_alternative<Plunge>(operation.what)) {
      figures_.push_back({operation.line, at_mm_, {}, false});
    }
    if (const auto* rout = std::get_if<Rout>(&operation.what)) {
      at_mm_ = rout->actual.in_mm();
      figures_.back().routs.push_back(*rout);
    }
    if (std::holds_alternative<Retract>(operation.what)) figures_.back().is_retracted = true;
    is_compensated_ |= std::holds_alternative<Compensation>(operation.what) &&
                       std::get<Compensation>(operation.what).side != CompensationSide::Off;
  }

  const std::vector<Figure>& figures() const { return figures_; }
  int n_moves() const { return n_moves_; }
  bool is_compensated() const { return is_compensated_; }

 private:
  Vector2d at_mm_ = Vector2d::Zero();
  std::vector<Figure> figures_;
  int n_moves_ = 0;
  bool is_compensated_ = false;
};

FigureSink figures_of(const std::string& body) {
  DiagnosticLog log;
  const Program program = load_program({"p.exc", test::format_5000(body)}, log);
  NominalSource source;
  const Survey surveyed = survey(program, {}, source, log);
  FigureSink sink;
  if (!log.has_errors()) execute(program, {}, surveyed, sink, log);
  for (const Diagnostic& diagnostic : log.kept()) {
    EXPECT_EQ(diagnostic.severity(), Severity::Warning) << diagnostic.text();
  }
  for (const FigureSink::Figure& figure : sink.figures()) {
    EXPECT_TRUE(figure.is_retracted) << "each figure stands for itself";
  }
  // The path is the cutter's centre already; the control must not move it aside a second time.
  EXPECT_FALSE(sink.is_compensated());
  return sink;
}

/// One turn at least, in one sense only, of the circle with this radius: what makes the edge.
void expect_full_turn(const FigureSink::Figure& figure,
                      RoutKind kind,
                      const Vector2d& center_mm,
                      double radius_mm) {
  double turned_rad = 0;
  for (const Piece& piece : figure.pieces()) {
    if (piece.kind == RoutKind::Line) continue;
    EXPECT_EQ(piece.kind, kind) << "line " << figure.line;
    if ((piece.center_mm - center_mm).norm() > kRounding_mm) continue;
    if (std::abs(piece.radius_mm() - radius_mm) < kRounding_mm) turned_rad += piece.sweep_rad;
  }
  EXPECT_GE(turned_rad, 2 * pi - 1e-6) << "line " << figure.line;
}

/// The farthest that the cutter's centre gets from a point.
double reach_mm(const FigureSink::Figure& figure, const Vector2d& center_mm) {
  double reach = 0;
  for (const Piece& piece : figure.pieces()) {
    reach = std::max(reach, (piece.end_mm - center_mm).norm());
    // No arc of these figures reaches farther than its own circle does.
    if (piece.kind == RoutKind::Line || piece.sweep_rad < pi) continue;
    reach = std::max(reach, (piece.center_mm - center_mm).norm() + piece.radius_mm());
  }
  return reach;
}

// --- G45, G46 ------------------------------------------------------------------------------------

std::string circles(const std::string& command) {
  return "X35.Y50.T0 T5\nX35.Y50." + command + "R20. F1.2\nX75.Y30.R15.\nX75.Y30.T0\n";
}

TEST(ManualG46, TwoFullCirclesClockwise) {
  const FigureSink sink = figures_of(circles("G46"));
  ASSERT_EQ(sink.figures().size(), 2U);
  EXPECT_THAT(sink.figures()[0].plunge_mm,
              IsNearMatrix(Vector2d(28.283, 66.217), kManualRounding_mm));
  // 75 - 0.707 (15/2 - 2/4) and 30 + 1.707 (15/2 - 2/4)
  EXPECT_THAT(sink.figures()[1].plunge_mm,
              IsNearMatrix(Vector2d(70.051, 41.949), kManualRounding_mm));
  expect_full_turn(sink.figures()[0], RoutKind::Clockwise, {35, 50}, 20 - 1);
  expect_full_turn(sink.figures()[1], RoutKind::Clockwise, {75, 30}, 15 - 1);
  // To the first centre, and to both plunge points; T0 at the end finds the tool up already.
  EXPECT_EQ(sink.n_moves(), 3);
}

TEST(ManualG45, TwoFullCirclesCounterclockwise) {
  const FigureSink sink = figures_of(circles("G45"));
  ASSERT_EQ(sink.figures().size(), 2U);
  // G45's plunge point lies to the right: X + 0.707 x (r/2 - FD/4).
  EXPECT_THAT(sink.figures()[0].plunge_mm,
              IsNearMatrix(Vector2d(41.717, 66.217), kManualRounding_mm));
  EXPECT_THAT(sink.figures()[1].plunge_mm,
              IsNearMatrix(Vector2d(79.949, 41.949), kManualRounding_mm));
  expect_full_turn(sink.figures()[0], RoutKind::Counterclockwise, {35, 50}, 19);
  expect_full_turn(sink.figures()[1], RoutKind::Counterclockwise, {75, 30}, 14);
}

/// "The cutter plunges into the inner area of the part to be routed out and moves via an arc to the
/// edge of the circle": the plunge point lies on the circle of half the radius through the topmost
/// point of the edge, so it arrives there without a corner.
TEST(ManualG46, ReachesTheEdgeViaAnArc) {
  const FigureSink sink = figures_of(circles("G46"));
  ASSERT_FALSE(sink.figures().empty());
  const std::vector<Piece> pieces = sink.figures()[0].pieces();
  ASSERT_GE(pieces.size(), 2U);
  EXPECT_EQ(pieces[0].kind, RoutKind::Clockwise);
  EXPECT_THAT(pieces[0].end_mm, IsNearMatrix(Vector2d(35, 69), kRounding_mm));
  EXPECT_NEAR(pieces[0].radius_mm(), 9.5, 0.01);
  EXPECT_THAT(pieces[0].direction_at({35, 69}), IsNearMatrix(Vector2d(1, 0), 0.01));
}

// --- G47, G48 ------------------------------------------------------------------------------------

std::string disks(const std::string& command) {
  return "X35.Y50.T0 T2\nX35.Y50." + command + "R20. F1.2\nX75.Y30.R15.\nX75.Y30.T0\n";
}

TEST(ManualG47, TwoDisksCounterclockwise) {
  const FigureSink sink = figures_of(disks("G47"));
  ASSERT_EQ(sink.figures().size(), 2U);
  EXPECT_THAT(sink.figures()[0].plunge_mm, IsNearMatrix(Vector2d(14, 51), kRounding_mm));
  // 75 - (15 + 2/2) and 30 + 2/2
  EXPECT_THAT(sink.figures()[1].plunge_mm, IsNearMatrix(Vector2d(59, 31), kRounding_mm));
  expect_full_turn(sink.figures()[0], RoutKind::Counterclockwise, {35, 50}, 20 + 1);
  expect_full_turn(sink.figures()[1], RoutKind::Counterclockwise, {75, 30}, 15 + 1);
}

TEST(ManualG48, PlungesBelowTheCenter) {
  const FigureSink sink = figures_of(disks("G48"));
  ASSERT_EQ(sink.figures().size(), 2U);
  EXPECT_THAT(sink.figures()[0].plunge_mm, IsNearMatrix(Vector2d(14, 49), kRounding_mm));
  EXPECT_THAT(sink.figures()[1].plunge_mm, IsNearMatrix(Vector2d(59, 29), kRounding_mm));
  expect_full_turn(sink.figures()[0], RoutKind::Clockwise, {35, 50}, 21);
  expect_full_turn(sink.figures()[1], RoutKind::Clockwise, {75, 30}, 16);
}

// --- G49, G50 ------------------------------------------------------------------------------------

std::string rectangles(const std::string& command) {
  return "X30.Y50.T0 T5\nX30.Y50." + command + "I40.J30. F1.2\nX75.Y50.R40.\nX75.Y50.T0\n";
}

/// The corners of the cutter's centre path, and twice the area that it goes round: positive if
/// counter-clockwise.
struct Outline {
  Vector2d low_mm = Vector2d::Constant(1e9);
  Vector2d high_mm = Vector2d::Constant(-1e9);
  double turn_mm2 = 0;
};

Outline outline(const FigureSink::Figure& figure, const Vector2d& center_mm) {
  Outline out;
  for (const Piece& piece : figure.pieces()) {
    out.low_mm = out.low_mm.cwiseMin(piece.end_mm);
    out.high_mm = out.high_mm.cwiseMax(piece.end_mm);
    const Vector2d from = piece.start_mm - center_mm;
    const Vector2d to = piece.end_mm - center_mm;
    out.turn_mm2 += from.x() * to.y() - from.y() * to.x();
  }
  return out;
}

void expect_rectangle(const FigureSink::Figure& figure,
                      const Vector2d& center_mm,
                      const Vector2d& sides_mm,
                      int sense) {
  const Outline found = outline(figure, center_mm);
  const Vector2d half_mm = sides_mm / 2 - Vector2d(1, 1);  // the cutter's radius inside
  EXPECT_THAT(found.low_mm, IsNearMatrix(Vector2d(center_mm - half_mm), kRounding_mm));
  EXPECT_THAT(found.high_mm, IsNearMatrix(Vector2d(center_mm + half_mm), kRounding_mm));
  EXPECT_GT(sense * found.turn_mm2, 0);
}

TEST(ManualG50, RectangleAndSquareClockwise) {
  const FigureSink sink = figures_of(rectangles("G50"));
  ASSERT_EQ(sink.figures().size(), 2U);
  EXPECT_THAT(sink.figures()[0].plunge_mm, IsNearMatrix(Vector2d(30, 57), kRounding_mm));
  // 50 + 40/4 - 2/4
  EXPECT_THAT(sink.figures()[1].plunge_mm, IsNearMatrix(Vector2d(75, 59.5), kRounding_mm));
  expect_rectangle(sink.figures()[0], {30, 50}, {40, 30}, -1);
  expect_rectangle(sink.figures()[1], {75, 50}, {40, 40}, -1);
}

TEST(ManualG49, RectangleAndSquareCounterclockwise) {
  const FigureSink sink = figures_of(rectangles("G49"));
  ASSERT_EQ(sink.figures().size(), 2U);
  EXPECT_THAT(sink.figures()[0].plunge_mm, IsNearMatrix(Vector2d(30, 57), kRounding_mm));
  EXPECT_THAT(sink.figures()[1].plunge_mm, IsNearMatrix(Vector2d(75, 59.5), kRounding_mm));
  expect_rectangle(sink.figures()[0], {30, 50}, {40, 30}, +1);
  expect_rectangle(sink.figures()[1], {75, 50}, {40, 40}, +1);
}

// --- G43 -----------------------------------------------------------------------------------------

/// "The material in the inner area of a routing contour is cut out completely"; "the G43 function
/// is not saved. It only applies in the programmed block."
TEST(ManualG43, CutsTheAreaOfItsOwnLineOnly) {
  const FigureSink plain = figures_of(circles("G46"));
  const FigureSink whole = figures_of(circles("G46G43"));
  ASSERT_EQ(plain.figures().size(), 2U);
  ASSERT_GE(whole.figures().size(), 2U);
  std::size_t n_whole = 0;
  for (const FigureSink::Figure& figure : whole.figures()) {
    if (figure.line == 3) n_whole += figure.routs.size();
  }
  EXPECT_GT(n_whole, plain.figures()[0].routs.size());
  expect_full_turn(whole.figures().back(), RoutKind::Clockwise, {75, 30}, 14);
  EXPECT_EQ(whole.figures().back().routs.size(), plain.figures()[1].routs.size());
  EXPECT_NEAR(reach_mm(whole.figures()[0], {35, 50}), 19, kRounding_mm);
}

/// Every place of the circle is within the cutter's radius of what the cutter's centre passed.
TEST(ManualG43, LeavesNoMaterialInTheCircle) {
  const FigureSink sink = figures_of("X35.Y50.T0T5\nX35.Y50.G46G43R20.F1.2\nX35.Y50.T0\n");
  ASSERT_FALSE(sink.figures().empty());
  std::vector<Vector2d> passed;
  for (const FigureSink::Figure& figure : sink.figures()) {
    for (const Piece& piece : figure.pieces()) {
      constexpr int kSteps = 180;
      for (int i = 0; i <= kSteps; ++i) {
        const double t = static_cast<double>(i) / kSteps;
        if (piece.kind == RoutKind::Line) {
          passed.emplace_back((1 - t) * piece.start_mm + t * piece.end_mm);
          continue;
        }
        const double sense = piece.kind == RoutKind::Clockwise ? -1 : 1;
        const Vector2d out = piece.start_mm - piece.center_mm;
        const double angle_rad = sense * t * piece.sweep_rad;
        passed.emplace_back(
            piece.center_mm +
            Vector2d(std::cos(angle_rad) * out.x() - std::sin(angle_rad) * out.y(),
                     std::sin(angle_rad) * out.x() + std::cos(angle_rad) * out.y()));
      }
    }
  }
  constexpr double kSampling_mm = 0.2;  // of the path, at its widest turns
  for (double x_mm = -19.5; x_mm < 20; x_mm += 1.3) {
    for (double y_mm = -19.5; y_mm < 20; y_mm += 1.3) {
      if (x_mm * x_mm + y_mm * y_mm > 19.7 * 19.7) continue;
      const Vector2d p_mm(35 + x_mm, 50 + y_mm);
      const bool is_cut = std::ranges::any_of(
          passed, [&](const Vector2d& q_mm) { return (p_mm - q_mm).norm() < 1 + kSampling_mm; });
      ASSERT_TRUE(is_cut) << p_mm.transpose();
    }
  }
}

TEST(ManualG43, CutsARectangleOut) {
  const FigureSink plain = figures_of(rectangles("G50"));
  const FigureSink whole = figures_of(rectangles("G50G43"));
  ASSERT_EQ(plain.figures().size(), 2U);
  ASSERT_EQ(whole.figures().size(), 2U);
  EXPECT_GT(whole.figures()[0].routs.size(), plain.figures()[0].routs.size());
  expect_rectangle(whole.figures()[0], {30, 50}, {40, 30}, -1);
}

}  // namespace
}  // namespace panelcal
