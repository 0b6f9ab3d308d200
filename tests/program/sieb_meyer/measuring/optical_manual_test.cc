// SPDX-License-Identifier: Apache-2.0
// SIEB & MEYER manual, chapter 9 (Optical Measurement): its examples on boards that lie crooked.
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::expect_places;
using test::FunctionSource;
using test::hole_places;
using test::IsNearMatrix;
using test::Places;
using test::ProgramRun;
using test::run_5000;
using test::shifted;
using test::steps_of;
using testing::Contains;

constexpr double kRounding_mm = 1e-6;

/// Pose of a board: turned about work zero, then shifted.
struct Lie {
  double angle_rad = 0;
  Vector2d shift_mm = Vector2d::Zero();

  Vector2d operator()(const Vector2d& p_mm) const {
    const double c = std::cos(angle_rad);
    const double s = std::sin(angle_rad);
    return Vector2d(c * p_mm.x() - s * p_mm.y(), s * p_mm.x() + c * p_mm.y()) + shift_mm;
  }
  Places operator()(const Places& places) const {
    Places out;
    for (const Vector2d& p_mm : places) out.push_back((*this)(p_mm));
    return out;
  }
};

FunctionSource board(const Lie& lie) {
  return FunctionSource(
      [lie](const MeasurementRequest& request) { return lie(request.nominal.in_mm()); });
}

Places corrected_places(const ProgramRun& run) {
  Places places;
  for (const test::Hole& hole : run.holes()) places.push_back(hole.corrected_mm());
  return places;
}

Places requested_places(const FunctionSource& source) {
  Places places;
  for (const MeasurementRequest& request : source.requests()) {
    places.push_back(request.nominal.in_mm());
  }
  return places;
}

const Lie kCrooked{0.004, {0.35, -0.2}};

// --- G30, G31, G32 -------------------------------------------------------------------------------

/// The example of G30, G31 and G32, with coordinates. Its G30 stands inside the outer bracket,
/// before the final offset.
constexpr char kTwoPoints[] =
    "X10.Y10.G32\nX210.Y160.G32\nG31\n"
    "(SECTION: T1)\nX20.Y20.T1 M31 M31\nX30.Y25.\nXYM50\nX60.YM50M30\n"
    "(SECTION: T2)\nX40.Y20.T2 M31\nXYM50\nX60.YM50M30\nG30\n"
    "(FINAL OFFSET)\nX3.45Y2.34 M50M30\n";

TEST(ManualG31, TwoPointsCorrectOffsetAndRotation) {
  FunctionSource source = board(kCrooked);
  const ProgramRun run = run_5000(kTwoPoints, {}, source);
  const Places nominal =
      shifted({{20, 20}, {30, 25}, {80, 20}, {90, 25}, {40, 20}, {100, 20}}, Vector2d(3.45, 2.34));
  expect_places(hole_places(run), nominal);
  expect_places(corrected_places(run), kCrooked(nominal), kRounding_mm);
  ASSERT_EQ(run.survey.series.size(), 1U);
  EXPECT_EQ(run.survey.series[0].model, PanelModel::Rigid);
}

TEST(ManualG32, RequestsAreInOrderWithLineAndCommand) {
  FunctionSource source = board({});
  run_5000(kTwoPoints, {}, source);
  ASSERT_EQ(source.requests().size(), 2U);
  expect_places(requested_places(source), {{10, 10}, {210, 160}});
  for (std::size_t i = 0; i < 2; ++i) {
    const MeasurementRequest& request = source.requests()[i];
    EXPECT_EQ(request.seq, static_cast<std::int64_t>(i));
    EXPECT_EQ(request.line, static_cast<int>(i) + 2);
    EXPECT_EQ(request.command, "G32");
    EXPECT_EQ(request.path, InstancePath{});
  }
}

/// "The G31 to G30 commands are used for bracketing the program section in which the correction
/// values are considered."
TEST(ManualG30, EndsTheCorrection) {
  FunctionSource source = board(kCrooked);
  const ProgramRun run =
      run_5000("X10.Y10.T1\nX10.Y10.G32\nX210.Y160.G32\nX11.Y10.\nG31\nX12.Y10.\nG30\nX13.Y10.\n",
               {},
               source);
  expect_places(corrected_places(run),
                {{10, 10}, {11, 10}, kCrooked(Vector2d(12, 10)), {13, 10}},
                kRounding_mm);
}

/// One point gives two numbers: an offset.
TEST(ManualG31, OnePointCorrectsTheOffset) {
  FunctionSource source = test::shifted_by(0.3, -0.1);
  const ProgramRun run = run_5000("X10.Y10.G32\nG31\nX50.Y60.T1\nX10.Y60.\nG30\n", {}, source);
  expect_places(corrected_places(run), {{50.3, 59.9}, {10.3, 59.9}}, kRounding_mm);
}

/// "Software version 12.02.001 and higher: The coordinates for camera measuring commands can be
/// programmed as absolute and incremental values."
TEST(ManualG32, MayBeIncremental) {
  FunctionSource source = board({});
  run_5000("X10.Y10.G32\nX200.Y150.G91G32\nG31\nG30\n", {}, source);
  expect_places(requested_places(source), {{10, 10}, {210, 160}});
}

/// "The correction values are cleared with the G34 command or via two consecutive G30 blocks": what
/// was cleared is not there for the next G31 to use, nor for G39 to save.
TEST(ManualG34, MeasurementsBeforeItDoNotCount) {
  FunctionSource source([](const MeasurementRequest& request) -> Vector2d {
    return request.nominal.in_mm() + Vector2d(request.seq == 0 ? 5 : 0.2, 0);
  });
  const ProgramRun run =
      run_5000("X10.Y10.G32\nG34\nX10.Y10.G32\nG31\nX50.Y60.T1\nG30\n", {}, source);
  expect_places(corrected_places(run), {{50.2, 60}}, kRounding_mm);
}

TEST(ManualG34, EndsTheCorrection) {
  FunctionSource source = test::shifted_by(0.3, 0);
  const ProgramRun run = run_5000("X10.Y10.G32\nG31\nX50.Y60.T1\nG34\nX50.Y70.\n", {}, source);
  expect_places(corrected_places(run), {{50.3, 60}, {50, 70}}, kRounding_mm);
}

// --- measurement modes 2, 3 and 5 ----------------------------------------------------------------

class ManualLayers : public testing::TestWithParam<int> {};

/// "If several layers are measured one after the other, the measuring process in the measurement
/// modes 2 and 3 must be finished with the G33 command after the last layer." A point is the mean
/// of its layers.
TEST_P(ManualLayers, APointIsTheMeanOfItsLayers) {
  WalkOptions options;
  options.sieb_meyer.measurement_mode = GetParam();
  // Three layers of the first point, two of the second: 0.1, 0.2, 0.6 and 0.2, 0.4 to the right.
  FunctionSource source([](const MeasurementRequest& request) -> Vector2d {
    constexpr double kShift_mm[] = {0.1, 0.2, 0.6, 0.2, 0.4};
    return request.nominal.in_mm() + Vector2d(kShift_mm[request.seq], 0);
  });
  const ProgramRun run = run_5000(
      "X10.Y10.G32\nX10.Y10.G32\nX10.Y10.G33\nX210.Y10.G32\nX210.Y10.G33\nG31\nX50.Y60.T1\n"
      "X110.Y10.\nG30\n",
      options,
      source);
  ASSERT_EQ(source.requests().size(), 5U);
  EXPECT_EQ(source.requests()[2].command, "G33");
  expect_places(corrected_places(run), {{50.3, 60}, {110.3, 10}}, kRounding_mm);
}

INSTANTIATE_TEST_SUITE_P(Modes, ManualLayers, testing::Values(2, 3));

/// G33's example: two slots in Y whose X-values count, and two in X whose Y-values count.
TEST(ManualG33, FourSlotsCorrectOffsetAndRotation) {
  WalkOptions options;
  options.sieb_meyer.measurement_mode = 5;
  // Along a slot the camera sees anything; that must not matter.
  FunctionSource source([](const MeasurementRequest& request) {
    const Vector2d along = request.command == "G33" ? Vector2d(0, 0.7) : Vector2d(-0.9, 0);
    return Vector2d(kCrooked(request.nominal.in_mm()) + along);
  });
  const ProgramRun run = run_5000(
      "X10.Y20.G33\nX30.Y10.G32\nX210.Y140.G33\nX190.Y160.G32\nG31\n"
      "(SECTION: T1)\nX20.Y20.T1 M31 M31\nXYM50\nX60.YM50M30\n"
      "(SECTION: T2)\nX40.Y120.T2 M31\nXYM50\nX60.YM50M30\nG30\n"
      "(FINAL OFFSET)\nX3.45Y2.34 M50M30\n",
      options,
      source);
  const Places nominal = shifted({{20, 20}, {80, 20}, {40, 120}, {100, 120}}, Vector2d(3.45, 2.34));
  expect_places(corrected_places(run), kCrooked(nominal), kRounding_mm);
  ASSERT_EQ(source.requests().size(), 4U);
  EXPECT_EQ(source.requests()[0].command, "G33");
  EXPECT_EQ(source.requests()[0].axes, ObservedAxes::X);
  EXPECT_EQ(source.requests()[1].command, "G32");
  EXPECT_EQ(source.requests()[1].axes, ObservedAxes::Y);
}

/// A shift alone shows exactly which coordinate of a slot counts.
TEST(ManualG33, SlotsCountAcrossOnly) {
  WalkOptions options;
  options.sieb_meyer.measurement_mode = 5;
  FunctionSource source([](const MeasurementRequest& request) -> Vector2d {
    return request.nominal.in_mm() +
           (request.command == "G33" ? Vector2d(0.25, 3) : Vector2d(-4, 0.5));
  });
  const ProgramRun run =
      run_5000("X10.Y20.G33\nX30.Y10.G32\nX210.Y140.G33\nX190.Y160.G32\nG31\nX20.Y20.T1\nG30\n",
               options,
               source);
  expect_places(corrected_places(run), {{20.25, 20.5}}, kRounding_mm);
}

/// Slots in Y at the same y, and slots in X at the same x, look the same however the board is
/// turned.
TEST(ManualG33, SlotsThatDoNotShowTheRotationAreRefused) {
  WalkOptions options;
  options.sieb_meyer.measurement_mode = 5;
  const ProgramRun run = test::run_program(
      test::format_5000("X10.Y80.G33\nX110.Y10.G32\nX210.Y80.G33\nX110.Y160.G32\nG31\nX20.Y20.T1\n"
                        "G30\n"),
      options);
  EXPECT_TRUE(run.has_errors);
  EXPECT_THAT(run.diagnostics, Contains(testing::HasSubstr("series-degenerate")));
}

/// In mode 1, G33 "has the same effect as G32".
TEST(ManualG33, InModeOneIsG32) {
  FunctionSource source = board(kCrooked);
  const ProgramRun run = run_5000("X10.Y10.G32\nX210.Y160.G33\nG31\nX50.Y60.T1\nG30\n", {}, source);
  expect_places(corrected_places(run), {kCrooked(Vector2d(50, 60))}, kRounding_mm);
}

// --- G36 -----------------------------------------------------------------------------------------

/// NOCAMA: "First, a measuring cycle is carried out at every G36 position. Then, a drill stroke is
/// executed"; "all other positions are drilled without correction".
TEST(ManualG36, SinglePointCorrection) {
  FunctionSource source([](const MeasurementRequest& request) -> Vector2d {
    return request.nominal.in_mm() + 0.1 * Vector2d(static_cast<double>(request.seq + 1), -1);
  });
  const ProgramRun run =
      run_5000("X10.Y10.T1M31 G36\nX20.Y10. G36\nX30.Y10.\nXYM50\nX100.YM50M30\nG30\n", {}, source);
  expect_places(corrected_places(run),
                {{10.1, 9.9}, {20.2, 9.9}, {30, 10}, {110.3, 9.9}, {120.4, 9.9}, {130, 10}},
                kRounding_mm);
  expect_places(hole_places(run), {{10, 10}, {20, 10}, {30, 10}, {110, 10}, {120, 10}, {130, 10}});
  expect_places(requested_places(source), {{10, 10}, {20, 10}, {110, 10}, {120, 10}});
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(source.requests()[i].command, "G36");
    EXPECT_EQ(source.requests()[i].path, InstancePath{i < 2 ? 0 : 1});
  }
}

/// CAMA: "The correction values are calculated with the sum of the measured values (G32 correction
/// plus G36 correction)"; "only one offset value is determined for these two measuring points".
TEST(ManualG36, BoardAndPatternCorrection) {
  WalkOptions options;
  options.sieb_meyer.pattern_mode = true;
  const std::vector<Vector2d> pattern_shifts = {{0.1, 0.2}, {-0.3, 0.05}};
  // The marks of a pattern are 0.02 mm off to either side; their mean is the pattern's.
  FunctionSource source([&](const MeasurementRequest& request) -> Vector2d {
    const Vector2d on_board = kCrooked(request.nominal.in_mm());
    if (request.command != "G36") return on_board;
    const double side_mm = request.seq % 2 == 0 ? 0.02 : -0.02;
    return on_board + pattern_shifts[static_cast<std::size_t>(request.path[0])] +
           Vector2d(side_mm, 0);
  });
  const ProgramRun run = run_5000(
      "X10.Y10.G32\nX210.Y160.G32\nG31\nM31\nX20.Y20.G36\nX60.Y60.G36\nX30.Y40.T1\nX50.Y25.\n"
      "XYM50\nX100.YM50M30\nG30\nX30.Y40.\n",
      options,
      source);
  Places expected;
  for (const Vector2d& p_mm : Places{{30, 40}, {50, 25}}) {
    expected.emplace_back(kCrooked(p_mm) + pattern_shifts[0]);
  }
  for (const Vector2d& p_mm : Places{{130, 40}, {150, 25}}) {
    expected.emplace_back(kCrooked(p_mm) + pattern_shifts[1]);
  }
  expected.emplace_back(30, 40);  // behind G30
  expect_places(corrected_places(run), expected, kRounding_mm);
  expect_places(requested_places(source),
                {{10, 10}, {210, 160}, {20, 20}, {60, 60}, {120, 20}, {160, 60}});
  // Pattern marks are looked for where the board's correction puts them.
  for (const MeasurementRequest& request : source.requests()) {
    if (request.command != "G36") continue;
    EXPECT_THAT(request.expected.in_mm(),
                IsNearMatrix(kCrooked(request.nominal.in_mm()), kRounding_mm));
  }
}

/// A pattern's offset ends with the pattern: what follows has the board's correction alone.
TEST(ManualG36, PatternOffsetEndsWithItsPattern) {
  WalkOptions options;
  options.sieb_meyer.pattern_mode = true;
  FunctionSource source([](const MeasurementRequest& request) -> Vector2d {
    return request.nominal.in_mm() + Vector2d(request.command == "G36" ? 0.5 : 0.1, 0);
  });
  const ProgramRun run = run_5000(
      "X10.Y10.G32\nG31\nM31\nX20.Y20.G36\nX30.Y40.T1\nXYM50\nX100.YM50M30\nX30.Y50.\nG30\n",
      options,
      source);
  expect_places(corrected_places(run), {{30.5, 40}, {130.5, 40}, {30.1, 50}}, kRounding_mm);
}

// --- G39 -----------------------------------------------------------------------------------------

/// Sixteen patterns in four rows, each lying in its own way.
Lie pattern_lie(int pattern) {
  return {0.001 * (pattern - 7), {0.02 * pattern, -0.03 * pattern}};
}

Places pattern_zeros() {
  Places zeros;
  for (int i = 0; i < 16; ++i) zeros.emplace_back(100 * (i % 4), 120 * (i / 4));
  return zeros;
}

std::string sixteen_offsets() {
  std::string lines;
  for (const Vector2d& zero : pattern_zeros()) {
    lines += "X" + std::to_string(static_cast<int>(zero.x())) + ".Y" +
             std::to_string(static_cast<int>(zero.y())) + ".M50\n";
  }
  lines.insert(lines.size() - 1, "M30");
  return lines;
}

TEST(ManualG39, SixteenPatternsAreMeasuredSavedAndLoaded) {
  FunctionSource source([](const MeasurementRequest& request) {
    return pattern_lie(request.path[0])(request.nominal.in_mm());
  });
  const ProgramRun run =
      run_5000("M31\nG34\nX10.Y10.G32\nX80.Y90.G32\nG31\nG39,SAVE\nG30\n" + sixteen_offsets() +
                   "M31\nG39,LOAD\nX20.Y30.T1\nX70.Y40.\n" + sixteen_offsets() + "G30\nX20.Y30.\n",
               {},
               source);
  Places expected;
  const Places zeros = pattern_zeros();
  for (int i = 0; i < 16; ++i) {
    const Vector2d& zero = zeros[static_cast<std::size_t>(i)];
    expected.push_back(pattern_lie(i)(Vector2d(zero + Vector2d(20, 30))));
    expected.push_back(pattern_lie(i)(Vector2d(zero + Vector2d(70, 40))));
  }
  expected.emplace_back(20, 30);
  expect_places(corrected_places(run), expected, kRounding_mm);
  ASSERT_EQ(source.requests().size(), 32U);
  for (std::size_t i = 0; i < 32; ++i) {
    const MeasurementRequest& request = source.requests()[i];
    const int pattern = static_cast<int>(i / 2);
    EXPECT_EQ(request.seq, static_cast<std::int64_t>(i));
    EXPECT_EQ(request.path, InstancePath{pattern});
    const Vector2d mark = i % 2 == 0 ? Vector2d(10, 10) : Vector2d(80, 90);
    EXPECT_THAT(request.nominal.in_mm(), IsNearMatrix(Vector2d(zeros[i / 2] + mark), kRounding_mm));
  }
}

/// A panel of four, of which one is not drilled: copies keep their corrections as long as they keep
/// their numbers. Where a copy in front is left out, "the current STEP value" of those behind it
/// is another one's.
TEST(ManualG39, FewerCopiesTakeTheSetsOfTheirPlaces) {
  FunctionSource source([](const MeasurementRequest& request) -> Vector2d {
    return request.nominal.in_mm() + Vector2d(0.1 * (request.path[0] + 1), 0);
  });
  const std::string body =
      "X10.Y10.G32\nG31\nG39,SAVE\nG30\nXYM50\nX100.YM50\nX200.YM50\nX300.YM50M30\n"
      "M31\nG39,LOAD\nX20.Y30.T1\n";
  const ProgramRun run =
      run_5000("M31\n" + body + "XYM50\nX100.YM50\nX200.YM50M30\nG30\n", {}, source);
  expect_places(corrected_places(run), {{20.1, 30}, {120.2, 30}, {220.3, 30}}, kRounding_mm);
  for (const char* offsets : {"X100.YM50\nX200.YM50M30\n", "XYM50\nX200.YM50M30\n", "XYM80M30\n"}) {
    const ProgramRun moved = test::run_program(test::format_5000("M31\n" + body + offsets));
    EXPECT_THAT(moved.diagnostics,
                Contains(testing::HasSubstr("p.exc:12:1: error[stored-elsewhere]")))
        << offsets;
  }
}

/// "G39,SAVEn: Save correction values (storage location = n)"; LOADn in another order.
TEST(ManualG39, StorageLocationsMayBeNamed) {
  FunctionSource source([](const MeasurementRequest& request) -> Vector2d {
    return request.nominal.in_mm() + Vector2d(request.seq == 0 ? 0.1 : 0.2, 0);
  });
  const ProgramRun run = run_5000(
      "X10.Y10.G32\nG31\nG39,SAVE7\nG34\nX10.Y10.G32\nG31\nG39,SAVE1000\nG34\n"
      "G39,LOAD7\nX50.Y50.T1\nG30\nG39,LOAD1000\nX60.Y50.\nG30\nX70.Y50.\n",
      {},
      source);
  expect_places(corrected_places(run), {{50.1, 50}, {60.2, 50}, {70, 50}}, kRounding_mm);
}

/// "G39,CLEARn: Clear correction values"; what was cleared cannot be loaded.
TEST(ManualG39, ClearedValuesAreGone) {
  for (const char* clear : {"G39,CLEAR7", "G39,DELALL"}) {
    const ProgramRun run = test::run_program(test::format_5000(
        "X10.Y10.G32\nG31\nG39,SAVE7\nG34\n" + std::string(clear) + "\nG39,LOAD7\nX50.Y50.T1\n"));
    test::expect_refused(run, 7, {"LOAD7", "saved"});
  }
}

// --- G35, M75 ------------------------------------------------------------------------------------

TEST(ManualG35, BytesAndStringsForTheCameraArePassedOn) {
  const ProgramRun run = run_5000("G35,12\nM75,LAMP 5\nX1.Y2.T1\n");
  EXPECT_THAT(steps_of(run), Contains("setting G35,12"));
  EXPECT_THAT(steps_of(run), Contains("setting M75,LAMP 5"));
}

}  // namespace
}  // namespace panelcal
