// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/measuring/offset_deviation.h"

#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/statistics/random.h"
#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"
#include "tests/support/matchers.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using sieb_meyer::offset_deviation;
using sieb_meyer::offset_order;
using sieb_meyer::scatter_chance;
using test::format_5000;
using test::FunctionSource;
using test::IsNearMatrix;
using test::ProgramRun;
using testing::Contains;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kRounding = 1e-15;
constexpr double kUm2 = 1e-6;

Measurement seen(const Vector2d& nominal_mm, const Vector2d& off_mm, double variance_um2) {
  Measurement m;
  m.request.nominal = position_mm<frame::Nominal>(nominal_mm);
  m.request.expected = position_mm<frame::Actual>(nominal_mm);
  m.status = MeasurementStatus::Found;
  m.measured = {position_mm<frame::Actual>(Vector2d(nominal_mm + off_mm)),
                variance_um2 * kUm2 * Eigen::Matrix2d::Identity()};
  return m;
}

/// SIEB & MEYER manual, 9, G39: the table of commands.
TEST(ManualG39, NamesTheOffsetThatIsCorrected) {
  using Of = OffsetOrder::Of;
  const auto is = [](std::string_view text, Of of, int number) {
    const auto order = offset_order(text);
    return order && order->of == of && order->number == number;
  };
  EXPECT_TRUE(is("SPOP", Of::Station, 1));
  EXPECT_TRUE(is("SPOP1", Of::Station, 1));
  EXPECT_TRUE(is("SPOP2", Of::Station, 2));
  EXPECT_TRUE(is("SPISPI", Of::SpindleToSpindle, 1));
  EXPECT_TRUE(is("SPOF1", Of::Spindle, 1));
  EXPECT_TRUE(is("SPOF12", Of::Spindle, 12));
  for (const char* text : {"SPOF", "SPOF0", "SPOF13", "SPOFs", "SPOP3", "SPISPI1", ""}) {
    EXPECT_FALSE(offset_order(text)) << text;
  }
}

TEST(OffsetDeviation, IsTheMeanOfWhatWasSeen) {
  const std::vector<Measurement> measured = {seen({0, 0}, {0.03, -0.01}, 4),
                                             seen({9, 0}, {0.01, -0.03}, 4)};
  const auto deviation = offset_deviation(measured, {});
  ASSERT_TRUE(deviation);
  EXPECT_THAT(deviation->deviation.in_mm(), IsNearMatrix(Vector2d(0.02, -0.02), kRounding));
}

TEST(OffsetDeviation, CountsTheMachineAtEveryHole) {
  MachineUncertainty machine;
  machine.stage_repeatability = um(2);
  machine.table_residual = um(1);
  machine.drill_wander = um(3);
  // Seen: 4 and the stage's 4. The hole: the stage's 4, the table's 1 when drilled and 1 when
  // looked at, the drill's 9. Two equal sights do not scatter.
  const std::vector<Measurement> one = {seen({0, 0}, {0.03, 0}, 4)};
  EXPECT_THAT(offset_deviation(one, machine)->cov_mm2,
              IsNearMatrix(Eigen::Matrix2d(23 * kUm2 * Eigen::Matrix2d::Identity()), kRounding));
  const std::vector<Measurement> two = {seen({0, 0}, {0.03, 0}, 4), seen({9, 0}, {0.03, 0}, 4)};
  EXPECT_THAT(offset_deviation(two, machine)->cov_mm2,
              IsNearMatrix(Eigen::Matrix2d(11.5 * kUm2 * Eigen::Matrix2d::Identity()), kRounding));
  // Two layers of one hole: 8 / 2 of the sights, 15 of the hole.
  const std::vector<Measurement> layers = {seen({0, 0}, {0.03, 0}, 4), seen({0, 0}, {0.03, 0}, 4)};
  EXPECT_THAT(offset_deviation(layers, machine)->cov_mm2,
              IsNearMatrix(Eigen::Matrix2d(19 * kUm2 * Eigen::Matrix2d::Identity()), kRounding));
}

TEST(OffsetDeviation, OfSlotsIsPutTogetherFromBothCoordinates) {
  Measurement x = seen({0, 0}, {0.03, 7}, 4);
  x.request.axes = ObservedAxes::X;
  Measurement y = seen({9, 0}, {7, -0.02}, 9);
  y.request.axes = ObservedAxes::Y;
  EXPECT_FALSE(offset_deviation(std::vector{x}, {}));
  EXPECT_FALSE(offset_deviation({}, {}));
  const auto deviation = offset_deviation(std::vector{x, y}, {});
  ASSERT_TRUE(deviation);
  EXPECT_THAT(deviation->deviation.in_mm(), IsNearMatrix(Vector2d(0.03, -0.02), kRounding));
  const Eigen::Matrix2d expected_mm2 = Vector2d(4 * kUm2, 9 * kUm2).asDiagonal();
  EXPECT_THAT(deviation->cov_mm2, IsNearMatrix(expected_mm2, kRounding));
}

/// Holes that scatter three times as far as the machine's file says are not believed: 400 boards of
/// 8 holes, where nothing at all is stated of the drill.
TEST(OffsetDeviation, KnowsHowSureItIsEvenIfTheFileDoesNot) {
  Random random(41);
  constexpr int kBoards = 400;
  constexpr int kHoles = 8;
  constexpr double kSigma_mm = 0.003;
  double sum = 0;
  for (int i = 0; i < kBoards; ++i) {
    std::vector<Measurement> measured;
    for (int i_hole = 0; i_hole < kHoles; ++i_hole) {
      const double x_mm = kSigma_mm * random.normal();
      measured.push_back(seen({5.0 * i_hole, 0}, {x_mm, kSigma_mm * random.normal()}, 1));
    }
    const auto deviation = offset_deviation(measured, {});
    const Vector2d error_mm = deviation->deviation.in_mm();
    sum += error_mm.dot(deviation->cov_mm2.inverse() * error_mm);
  }
  // The scale comes from 14 degrees of freedom: the sum is 2 F(2, 14), with mean 2 * 14 / 12.
  constexpr double kMean = 2 * 14.0 / 12;
  // Of 2 F(2, 14): variance 4 * 2 * 14^2 * 14 / (2 * 12^2 * 10).
  const double sigma = std::sqrt(4 * 2 * 14.0 * 14 * 14 / (2 * 12.0 * 12 * 10));
  EXPECT_TRUE(test::mean_agrees(sum / kBoards, kMean, sigma, kBoards));
}

// --- in programs ---------------------------------------------------------------------------------

/// Sees every target 40 and -20 um from its nominal place, and answers every order.
class Board final : public MeasurementSource {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    Measurement m = seen(request.nominal.in_mm(), {0.04, -0.02}, 4);
    m.request = request;
    m.status = status;
    return m;
  }
  Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order) override {
    orders.push_back(order);
    CalibrationAnswer answer;
    answer.offset =
        SpindleCameraOffset{displacement_mm<frame::Machine>(45, -3), order.correction->cov_mm2};
    return answer;
  }

  MeasurementStatus status = MeasurementStatus::Found;
  std::vector<CalibrationOrder> orders;
};

ProgramRun run(std::string_view body, Board& board) {
  WalkOptions options;
  options.moves_offset = true;
  options.uncertainty.spindle_camera_mm2 = 100 * kUm2 * Eigen::Matrix2d::Identity();
  return test::run_program(format_5000(body), options, board);
}

TEST(StoredOffset, IsWhatWasMeasuredOrCalculatedLast) {
  for (const char* body : {"X10.Y10.G32\nG39,SPOP\nX50.Y50.T1\n",
                           "X10.Y10.G32\nX90.Y10.G32\nG31\nG30\nG39,SPOP\nX50.Y50.T1\n"}) {
    Board board;
    const ProgramRun done = run(body, board);
    EXPECT_THAT(done.diagnostics, IsEmpty()) << body;
    ASSERT_EQ(board.orders.size(), 1U) << body;
    const CalibrationOrder& order = board.orders[0];
    EXPECT_EQ(order.command, "G39,SPOP");
    ASSERT_TRUE(order.correction);
    EXPECT_EQ(order.correction->order.of, OffsetOrder::Of::Station);
    EXPECT_THAT(order.correction->deviation.in_mm(), IsNearMatrix(Vector2d(0.04, -0.02), 1e-12));
    // The machine gets the order as well, and the hole behind it no correction.
    EXPECT_THAT(done.executed.lines(), Contains(EndsWith("setting G39,SPOP"))) << body;
    EXPECT_EQ(done.holes().at(0).corrected_mm(), Vector2d(50, 50)) << body;
  }
}

TEST(StoredOffset, IsTheOneOfLaterHoles) {
  Board board;
  const ProgramRun done = run("X10.Y10.G32\nG39,SPOP\nX10.Y10.G32\nG31\nX50.Y50.T1\nG30\n", board);
  ASSERT_EQ(done.holes().size(), 1U);
  // 4 of the target, 4 of the one that the offset is made of.
  EXPECT_THAT(done.holes()[0].drill.cov_mm2,
              IsNearMatrix(Eigen::Matrix2d(8 * kUm2 * Eigen::Matrix2d::Identity()), kRounding));
}

TEST(StoredOffset, OfSeveralOrdersIsTheSameDeviation) {
  Board board;
  run("X10.Y10.G32\nG39,SPOP1\nG39,SPOP2\nG39,SPOF3\nG39,SPISPI\nX50.Y50.T1\n", board);
  ASSERT_EQ(board.orders.size(), 4U);
  for (const CalibrationOrder& order : board.orders) {
    EXPECT_THAT(order.correction->deviation.in_mm(), IsNearMatrix(Vector2d(0.04, -0.02), 1e-12));
  }
  EXPECT_EQ(board.orders[2].correction->order.number, 3);
}

TEST(StoredOffset, NeedsAMeasurement) {
  for (const char* body : {"G39,SPOP\nX50.Y50.T1\n", "X10.Y10.G32\nG34\nG39,SPOP\nX50.Y50.T1\n"}) {
    Board board;
    const ProgramRun done = run(body, board);
    EXPECT_THAT(done.diagnostics, Contains(HasSubstr("error[correction-missing]"))) << body;
    EXPECT_THAT(board.orders, IsEmpty());
  }
}

TEST(StoredOffset, OfATargetThatWasNotFoundIsNone) {
  Board board;
  board.status = MeasurementStatus::NotFound;
  const ProgramRun done = run("X10.Y10.G32\nG39,SPOP\nX50.Y50.T1\n", board);
  EXPECT_THAT(done.diagnostics, Contains(HasSubstr("error[target-not-found]")));
  EXPECT_THAT(board.orders, IsEmpty());
}

/// The correction would move holes by the deviation that the offset has then, too.
TEST(StoredOffset, IsNoCorrectionOfTheBoardAsWell) {
  for (const char* body : {"X10.Y10.G32\nX90.Y10.G32\nG31\nG39,SPOP\nX50.Y50.T1\n",
                           "X10.Y10.G32\nG31\nG39,SAVE1\nG30\nX1.Y1.T1\nG39,LOAD1\nG39,SPOP\n"
                           "X50.Y50.T1\n"}) {
    Board board;
    const ProgramRun done = run(body, board);
    EXPECT_THAT(done.diagnostics, Contains(HasSubstr("error[command-misplaced]"))) << body;
    EXPECT_THAT(board.orders, IsEmpty()) << body;
  }
  for (const char* off : {"G30\n", "G30\nX1.Y1.T1\n"}) {
    Board board;
    const ProgramRun done =
        run("X10.Y10.G32\nX90.Y10.G32\nG31\n" + std::string(off) + "G39,SPOP\nX50.Y50.T1\n", board);
    EXPECT_THAT(done.diagnostics, IsEmpty()) << off;
    EXPECT_EQ(board.orders.size(), 1U) << off;
    EXPECT_EQ(done.holes().back().corrected_mm(), Vector2d(50, 50)) << off;
  }
}

TEST(StoredOffset, IsNotBroughtBackAsACorrection) {
  for (const char* back : {"G31\n", "G39,LOAD1\n"}) {
    Board board;
    const ProgramRun done = run(
        "X10.Y10.G32\nG31\nG39,SAVE1\nG30\nG39,SPOP\n" + std::string(back) + "X50.Y50.T1\n", board);
    EXPECT_THAT(done.diagnostics, Contains(HasSubstr("error[correction-missing]"))) << back;
  }
}

TEST(StoredOffset, IsNotStoredAgainBehindOtherMeasurements) {
  Board board;
  const ProgramRun done =
      run("X1.Y1.T1\nX10.Y10.G32\nG39,SPOP\nX20.Y20.G36\nG39,SPOF1\nX50.Y50.T1\n", board);
  EXPECT_THAT(done.diagnostics, Contains(HasSubstr("error[command-misplaced]")));
  EXPECT_EQ(board.orders.size(), 1U);
}

TEST(StoredOffset, ComesNotInTheMiddleOfAPattern) {
  WalkOptions options;
  options.moves_offset = true;
  options.sieb_meyer.pattern_mode = true;
  Board board;
  const ProgramRun done = test::run_program(
      format_5000("X20.Y20.G36\nX10.Y10.G32\nG39,SPOP\nX30.Y20.G36\nX50.Y50.T1\n"), options, board);
  EXPECT_THAT(done.diagnostics, Contains(HasSubstr("error[command-misplaced]")));
  EXPECT_THAT(board.orders, IsEmpty());
}

/// Two holes 40 um apart, seen to 2 um, where the drill wanders by 3 um: each is 20 um from their
/// mean, and chi square of two degrees of freedom is 2 * 400 / (4 + 9) = 61.5.
TEST(ScatterChance, IsThatOfSoundHoles) {
  const std::vector<Measurement> apart = {seen({0, 0}, {0.02, 0}, 4), seen({9, 0}, {-0.02, 0}, 4)};
  MachineUncertainty machine;
  EXPECT_EQ(scatter_chance(apart, machine), 1) << "nothing is said of the drill";
  machine.drill_wander = um(3);
  EXPECT_NEAR(scatter_chance(apart, machine), std::exp(-400.0 / 13), 1e-15);
  EXPECT_EQ(scatter_chance(std::vector{apart[0]}, machine), 1) << "one hole";
}

TEST(StoredOffset, OfHolesThatScatterTooFarIsRefused) {
  /// One of the holes lies 100 um aside.
  class Scattered final : public MeasurementSource {
   public:
    Expected<Measurement> measure(const MeasurementRequest& request) override {
      const double x_mm = request.nominal.in_mm().x() > 50 ? 0.1 : 0;
      Measurement m = seen(request.nominal.in_mm(), {x_mm, 0}, 4);
      m.request = request;
      return m;
    }
  };
  WalkOptions options;
  options.moves_offset = true;
  options.uncertainty.drill_wander = um(3);
  Scattered board;
  const ProgramRun done = test::run_program(
      format_5000("X10.Y10.G32\nX90.Y10.G32\nG39,SPOP\nX50.Y50.T1\n"), options, board);
  EXPECT_THAT(done.diagnostics, Contains(HasSubstr("error[calibration-refused]")));
}

TEST(StoredOffset, HasTwelveSpindles) {
  for (const char* order : {"G39,SPOF13", "G39,SPOF0"}) {
    Board board;
    const ProgramRun done = run("X10.Y10.G32\n" + std::string(order) + "\nX50.Y50.T1\n", board);
    EXPECT_THAT(done.texts, Contains(HasSubstr("12"))) << order;
  }
}

TEST(StoredOffset, IsPassedOnWithAWarningWhereNobodyMeasuresWithACamera) {
  FunctionSource source = test::shifted_by(0.04, 0);
  const ProgramRun done =
      test::run_program(format_5000("X10.Y10.G32\nG39,SPOP\nX50.Y50.T1\n"), {}, source);
  EXPECT_FALSE(done.has_errors);
  EXPECT_THAT(done.diagnostics, Contains(HasSubstr("warning[calibration-not-performed]")));
  EXPECT_THAT(done.executed.lines(), Contains(HasSubstr("setting G39,SPOP, not performed")));
}

}  // namespace
}  // namespace panelcal
