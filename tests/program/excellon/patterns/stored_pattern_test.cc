// SPDX-License-Identifier: Apache-2.0
// M99: CNC-7 manual, User Defined Stored Patterns, Using a User Defined Stored Pattern, Rules for
// Naming Your Programs.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/files/digest.h"
#include <gtest/gtest.h>
#include <stdlib.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::inch_leading_zeros;
using test::IsNearMatrix;
using test::ProgramRun;
using test::run_program;
using test::says;
using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

using Places = std::vector<Vector2d>;

constexpr double kRounding_inch = 1e-9;

/// A folder of stored patterns that goes away with the test.
class PatternFolder {
 public:
  PatternFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "panelcal-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~PatternFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  PatternFolder(const PatternFolder&) = delete;
  PatternFolder& operator=(const PatternFolder&) = delete;

  PatternFolder& with(const std::string& name, const std::string& text) {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return *this;
  }
  const std::filesystem::path& path() const { return path_; }
  ReadOptions reading() const {
    ReadOptions options;
    options.pattern_folders = {path_};
    return options;
  }

 private:
  std::filesystem::path path_;
};

/// The manual's pattern of ten pins in two rows: 0.1 inch apart, 0.3 between the rows.
constexpr char kTenPins[] = "XY\nX001\nX002\nX003\nX004\nY003\nX003\nX002\nX001\nX\n";
/// The same, incremental with trailing zeros.
constexpr char kTenPinsIncremental[] =
    "XY\nX1000\nX1000\nX1000\nX1000\nY3000\nX-1000\nX-1000\nX-1000\nX-1000\n";

Places ten_pins(const Vector2d& first) {
  Places places;
  for (int i = 0; i <= 4; ++i) places.emplace_back(first + Vector2d(0.1 * i, 0));
  for (int i = 4; i >= 0; --i) places.emplace_back(first + Vector2d(0.1 * i, 0.3));
  return places;
}

Places joined(Places first, const Places& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

/// `body` behind T1 in line 6.
ProgramRun run_with(const PatternFolder& folder, const std::string& body) {
  return run_program(inch_leading_zeros("T1\n" + body + "M30\n"), {}, folder.reading());
}

void expect_places(const ProgramRun& run, const Places& expected) {
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  const Places found = test::nominal_inch(run);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_THAT(found[i], IsNearMatrix(expected[i], kRounding_inch)) << "hole " << i;
  }
}

// --- what M99 does -------------------------------------------------------------------------------

TEST(StoredPattern, ManualTenPinsInAbsoluteMode) {
  PatternFolder folder;
  folder.with("TENPIN", kTenPins);
  expect_places(run_with(folder, "M99,TENPIN\nX01Y02\n"), ten_pins({1, 2}));
}

/// Where M99 leaves the machine the manual does not say: at its coordinate, at the pattern's end,
/// or where it stood before both.
TEST(StoredPattern, ACoordinateBehindItStatesBothAxes) {
  PatternFolder folder;
  folder.with("TENPIN", kTenPins);
  const std::vector<std::string> refused{"p.exc:9:1: error[axis-ambiguous]"};
  EXPECT_EQ(run_with(folder, "M99,TENPIN\nX01Y02\nX07\n").diagnostics, refused);
  EXPECT_EQ(run_with(folder, "M99,TENPIN\nX01Y02\nY07\n").diagnostics, refused);
  expect_places(run_with(folder, "M99,TENPIN\nX01Y02\nX07Y08\nX09\n"),
                joined(ten_pins({1, 2}), {{7, 8}, {9, 8}}));
}

TEST(StoredPattern, ManualTenPinsInIncrementalModeWithTrailingZeros) {
  PatternFolder folder;
  folder.with("TENPIN", kTenPinsIncremental);
  const ProgramRun run = run_program(
      "M48\nINCH,TZ\nICI,ON\nT1C.04\n%\nT1\nM99,TENPIN\nX10000Y20000\nM30\n", {}, folder.reading());
  expect_places(run, ten_pins({1, 2}));
}

TEST(StoredPattern, TheTemporaryZeroIsDroppedAfterwards) {
  PatternFolder folder;
  folder.with("TENPIN", kTenPins);
  expect_places(run_with(folder, "X05Y05\nM99,TENPIN\nX01Y02\nX06Y06\n"),
                joined(joined({{5, 5}}, ten_pins({1, 2})), {{6, 6}}));
}

/// Three boards of 50 mm were measured; a call at a board uses the correction of that one alone.
TEST(StoredPattern, AStoredCorrectionIsUsedOnItsOwnBoard) {
  PatternFolder folder;
  folder.with("BOARD", "M52\nX7.Y7.\n");
  const auto diagnostics_of = [&](const std::string& calls) {
    const std::string record = "G34,1\nT1\nM50,1\nM25\nG45X5.Y5.\nM01\nR2M02X50.\nM08\nG47\n";
    return run_program(test::metric(record + "M51,1\n" + calls + "M30\n"), {}, folder.reading())
        .diagnostics;
  };
  const std::string first = "M99,BOARD\nX0.Y0.\n";
  const std::string second = "M99,BOARD\nX50.Y0.\n";
  const std::string third = "M99,BOARD\nX100.Y0.\n";
  EXPECT_EQ(diagnostics_of(first + second + third), std::vector<std::string>());
  EXPECT_THAT(diagnostics_of(second + first + third),
              testing::ElementsAre(EndsWith("BOARD:1:1: error[stored-elsewhere]")));
}

TEST(StoredPattern, EachM99HasItsOwnZero) {
  PatternFolder folder;
  folder.with("TENPIN", kTenPins);
  expect_places(run_with(folder, "M99,TENPIN\nX01Y02\nM99,TENPIN\nX03Y04\n"),
                joined(ten_pins({1, 2}), ten_pins({3, 4})));
}

TEST(StoredPattern, IsRepeatedByP) {
  PatternFolder folder;
  folder.with("TENPIN", kTenPins);
  expect_places(run_with(folder, "M99,TENPIN\nX01Y02\nP2X01Y005\n"),
                joined(joined(ten_pins({1, 2}), ten_pins({2, 2.5})), ten_pins({3, 3})));
}

TEST(StoredPattern, MayRepeatHolesAndStepAndRepeat) {
  PatternFolder folder;
  folder.with("ROW", "XY\nR2X001\n");
  folder.with("STEPS", "M25\nXY\nM01\nM02X001\nM02Y001\nM08\n");
  expect_places(run_with(folder, "M99,ROW\nX01Y02\n"), {{1, 2}, {1.1, 2}, {1.2, 2}});
  expect_places(run_with(folder, "M99,STEPS\nX01Y02\n"), {{1, 2}, {1.1, 2}, {1.1, 2.1}});
}

TEST(StoredPattern, IsCopiedAndMirroredInsideStepAndRepeat) {
  PatternFolder folder;
  folder.with("TENPIN", kTenPins);
  Places mirrored;
  for (const Vector2d& p : ten_pins({1, 2})) mirrored.emplace_back(9 - p.x(), p.y());
  expect_places(run_with(folder, "M25\nM99,TENPIN\nX01Y02\nM01\nM02X09M80\nM08\n"),
                joined(ten_pins({1, 2}), mirrored));
}

TEST(StoredPattern, AddsNoIndexToThePath) {
  PatternFolder folder;
  folder.with("ONE", "XY\n");
  folder.with("STEPS", "M25\nXY\nM01\nM02X001\nM08\n");
  const ProgramRun plain = run_with(folder, "M99,ONE\nX01Y02\nP1X01\n");
  ASSERT_EQ(plain.holes().size(), 2U);
  EXPECT_EQ(plain.holes()[1].path, InstancePath{});
  const ProgramRun copied = run_with(folder, "M25\nM99,ONE\nX01Y02\nM01\nM02X01\nM08\n");
  ASSERT_EQ(copied.holes().size(), 2U);
  EXPECT_EQ(copied.holes()[1].path, InstancePath{1});
}

TEST(StoredPattern, CarriesOutAllInstructionsInOrder) {
  PatternFolder folder;
  folder.with("DRILLROUT", "X001Y\nG00XY\nM15\nG01X001Y001\nM17\nG05\nM47,DONE\n");
  const ProgramRun run = run_with(folder, "M99,DRILLROUT\nX01Y02\n");
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  EXPECT_THAT(run.executed.lines(),
              AllOf(Contains(EndsWith("DRILLROUT:1 drill 1 (27.94, 50.8)")),
                    Contains(EndsWith("DRILLROUT:2 position (25.4, 50.8)")),
                    Contains(EndsWith("DRILLROUT:4 rout 1 line (27.94, 53.34)")),
                    Contains(EndsWith("DRILLROUT:7 message DONE"))));
}

TEST(StoredPattern, ToolChangesInsideStayInForce) {
  PatternFolder folder;
  folder.with("OTHER", "XY\nT2\nX001Y\n");
  const ProgramRun run = run_with(folder, "M99,OTHER\nX01Y02\nX05Y05\n");
  ASSERT_EQ(run.holes().size(), 3U);
  EXPECT_EQ(run.holes()[0].drill.tool, 1);
  EXPECT_EQ(run.holes()[1].drill.tool, 2);
  EXPECT_EQ(run.holes()[2].drill.tool, 2);
}

TEST(StoredPattern, ATargetInsideIsRelativeToTheTemporaryZero) {
  PatternFolder folder;
  folder.with("TARGET", "G35X001Y\n");
  test::FunctionSource panel = test::shifted_by(0.1, 0.2);
  const ProgramRun run = run_program(
      inch_leading_zeros("T1\nG34,1\nM99,TARGET\nX01Y02\nM30\n"), {}, panel, folder.reading());
  ASSERT_EQ(panel.requests().size(), 1U) << testing::PrintToString(run.diagnostics);
  EXPECT_THAT(Vector2d(panel.requests()[0].nominal.in_mm() / kMmPerInch),
              IsNearMatrix(Vector2d(1.1, 2), kRounding_inch));
  EXPECT_THAT(panel.requests()[0].file, EndsWith("TARGET"));
  EXPECT_EQ(panel.requests()[0].line, 1);
}

/// Tells what it is asked, and answers as a perfect panel does.
class AskedSource final : public MeasurementSource {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    requests.push_back(request);
    return panel_.measure(request);
  }
  Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order) override {
    orders.push_back(order);
    return panel_.calibrate(order);
  }

  std::vector<MeasurementRequest> requests;
  std::vector<CalibrationOrder> orders;

 private:
  NominalSource panel_;
};

TEST(StoredPattern, WhatItAsksForNamesItsContent) {
  const std::string text = "G39\n$uvis,calib\nG38X001Y\n";
  PatternFolder folder;
  folder.with("TARGET", text);
  WalkOptions options;
  options.has_coupon = true;
  AskedSource panel;
  const ProgramRun run =
      run_program(inch_leading_zeros("T1\nG34,1\nM99,TARGET\nX01Y02\nG38X05Y\nM30\n"),
                  options,
                  panel,
                  folder.reading());
  ASSERT_EQ(panel.requests.size(), 2U) << testing::PrintToString(run.diagnostics);
  EXPECT_EQ(panel.requests[0].file_sha256, sha256(text));
  EXPECT_EQ(panel.requests[1].file_sha256, "");  // of the program itself
  ASSERT_EQ(panel.orders.size(), 2U);
  for (const CalibrationOrder& order : panel.orders) {
    EXPECT_EQ(order.file_sha256, sha256(text)) << order.command;
  }
}

// --- where it is looked for ----------------------------------------------------------------------

TEST(StoredPattern, FoldersAreSearchedInOrder) {
  PatternFolder first;
  PatternFolder second;
  first.with("BOTH", "XY\n");
  second.with("BOTH", "X001Y\n").with("ONLY2", "X002Y\n");
  ReadOptions reading;
  reading.pattern_folders = {first.path(), second.path()};
  expect_places(
      run_program(
          inch_leading_zeros("T1\nM99,BOTH\nX01Y02\nM99,ONLY2\nX01Y02\nM30\n"), {}, reading),
      {{1, 2}, {1.2, 2}});
}

TEST(StoredPattern, AMissingOneIsAnErrorAndTheRunEnds) {
  const PatternFolder folder;
  const ProgramRun run = run_with(folder, "M99,NOSUCH\nX01Y02\nX05Y05\n");
  EXPECT_TRUE(run.has_errors);
  EXPECT_THAT(run.diagnostics, Contains(says(7, "error[pattern-missing]")));
  EXPECT_THAT(run.texts, Contains(HasSubstr("NOSUCH")));
  EXPECT_TRUE(run_program(inch_leading_zeros("T1\nM99,NOSUCH\nX01Y02\nM30\n")).has_errors);
}

TEST(StoredPattern, AMissingOneThatIsNeverRunIsNone) {
  const PatternFolder folder;
  const ProgramRun run =
      run_program("M48\nINCH,LZ\nBLKD,ON\nT1C.04\n%\nT1\n/M99,NOSUCH\n/X01Y02\nX05Y05\nM30\n",
                  {},
                  folder.reading());
  EXPECT_THAT(run.diagnostics, Each(Not(HasSubstr("pattern-missing"))));
  expect_places(run, {{5, 5}});
}

TEST(StoredPattern, NamesThatLeaveTheFolderAreRefused) {
  PatternFolder outer;
  outer.with("SECRET", "XY\n");
  std::filesystem::create_directory(outer.path() / "inner");
  ReadOptions reading;
  reading.pattern_folders = {outer.path() / "inner"};
  for (const std::string& name : {std::string("../SECRET"),
                                  (outer.path() / "SECRET").string(),
                                  std::string("A/B"),
                                  std::string("A\\B")}) {
    const ProgramRun run =
        run_program(inch_leading_zeros("T1\nM99," + name + "\nX01Y02\nM30\n"), {}, reading);
    EXPECT_THAT(run.diagnostics, Contains(says(7, "error[argument-invalid]"))) << name;
    EXPECT_TRUE(run.holes().empty()) << name;
  }
}

// --- what a pattern must not hold ----------------------------------------------------------------

TEST(StoredPattern, MustNotCallAnother) {
  PatternFolder folder;
  folder.with("OUTER", "XY\nM99,INNER\nX001Y\n").with("INNER", "XY\n");
  const ProgramRun run = run_with(folder, "M99,OUTER\nX01Y02\n");
  EXPECT_THAT(run.diagnostics,
              Contains(AllOf(HasSubstr("OUTER:2:"), HasSubstr("error[pattern-nested]"))));
}

TEST(StoredPattern, MustNotCallItself) {
  PatternFolder folder;
  folder.with("SELF", "XY\nM99,SELF\nX001Y\n");
  EXPECT_THAT(run_with(folder, "M99,SELF\nX01Y02\n").diagnostics,
              Contains(AllOf(HasSubstr("SELF:2:"), HasSubstr("error[pattern-nested]"))));
}

TEST(StoredPattern, MustNotEndTheProgram) {
  PatternFolder folder;
  folder.with("ENDS", "XY\nM30\n");
  EXPECT_THAT(run_with(folder, "M99,ENDS\nX01Y02\nX05Y05\n").diagnostics,
              Contains(AllOf(HasSubstr("ENDS:2:"), HasSubstr("error[command-misplaced]"))));
}

TEST(StoredPattern, ThatIsCutOffInItsLastLineIsRefusedAtEveryByte) {
  constexpr std::string_view kPins = "XY\nX001Y02\nX0015\n";
  for (std::size_t n = 0; n < kPins.size(); ++n) {
    PatternFolder folder;
    folder.with("PINS", std::string(kPins.substr(0, n)));
    const ProgramRun run = run_with(folder, "M99,PINS\nX01Y02\nX05Y05\n");
    const bool is_complete = n > 0 && kPins[n - 1] == '\n';
    EXPECT_EQ(run.has_errors, !is_complete) << n;
    if (is_complete) continue;
    EXPECT_THAT(run.diagnostics,
                Contains(AllOf(HasSubstr("PINS:"), HasSubstr("error[end-missing]"))))
        << n;
  }
}

TEST(StoredPattern, ProblemsInsideNameTheFileAndItsLine) {
  PatternFolder folder;
  folder.with("BROKEN", "XY\nG06\n");
  EXPECT_THAT(run_with(folder, "M99,BROKEN\nX01Y02\n").diagnostics,
              Contains(AllOf(HasSubstr("BROKEN:2:"), HasSubstr("error[command-unknown]"))));
}

TEST(StoredPattern, WithoutItsCoordinateIsUnfinished) {
  PatternFolder folder;
  folder.with("ONE", "XY\n");
  for (const char* body : {"M99,ONE\n", "M99,ONE\nT2\nX01Y02\n"}) {
    EXPECT_THAT(run_with(folder, body).diagnostics, Contains(HasSubstr("error[cycle-unfinished]")))
        << body;
  }
}

}  // namespace
}  // namespace panelcal
