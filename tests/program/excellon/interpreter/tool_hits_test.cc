// SPDX-License-Identifier: Apache-2.0
// Hit counts, links, and whose tool data rule: CNC-7 manual, Tool Commands, Keyboard and Header
// Commands vs. Body Commands, Override Current Tool Feed OR Speed.
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::ProgramRun;
using test::run_program;
using test::says;
using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

using Lines = std::vector<std::string>;

ProgramRun run_clean(std::string text, const ReadOptions& reading = {}) {
  ProgramRun run = run_program(std::move(text), {}, reading);
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  return run;
}

/// `drill` for a hole, `1 next 5` for a tool that is used up and its heir, `1` if there is none.
Lines hits(const ProgramRun& run) {
  const std::string expired = "function tool_expired ";
  Lines out;
  for (const std::string& line : run.executed.lines()) {
    std::string what = line.substr(line.find(' ') + 1);
    what = what.substr(0, what.find(" ["));
    if (what.starts_with("drill ")) out.push_back("drill");
    if (what.starts_with(expired)) out.push_back(what.substr(expired.size()));
  }
  return out;
}

/// A row of holes, one a block.
std::string holes(int count) {
  std::string out;
  for (int i = 1; i <= count; ++i) out += "X" + std::to_string(i) + ".Y1.\n";
  return out;
}

std::string header(const std::string& lines) {
  return "M48\nMETRIC,LZ\n" + lines + "%\n";
}

// --- CNC-7 manual: Set Maximum Hit Count ---------------------------------------------------------

TEST(HitCount, AToolExpiresBeforeTheHoleThatWouldBeTooMany) {
  EXPECT_EQ(hits(run_clean(header("T1C1.H2\n") + "T1\n" + holes(2) + "M30\n")),
            (Lines{"drill", "drill"}));
  EXPECT_EQ(hits(run_clean(header("T1C1.H2\n") + "T1\n" + holes(3) + "M30\n")),
            (Lines{"drill", "drill", "1", "drill"}));
}

TEST(HitCount, MayBeSetInTheBody) {
  EXPECT_EQ(hits(run_clean(header("T1C1.\n") + "T1H2\n" + holes(3) + "M30\n")),
            (Lines{"drill", "drill", "1", "drill"}));
}

TEST(HitCount, HAloneTurnsTheCounterOff) {
  EXPECT_EQ(hits(run_clean(header("T1C1.H\n") + "T1\n" + holes(4) + "M30\n")),
            (Lines{"drill", "drill", "drill", "drill"}));
}

/// The header's data hold, and the body's H does not turn them off: that is said.
TEST(HitCount, HAloneInTheBodyDoesNotTurnOffTheHeaders) {
  const ProgramRun ignored = run_clean(header("T1C1.H2\n") + "T1H\n" + holes(3) + "M30\n");
  EXPECT_EQ(hits(ignored), (Lines{"drill", "drill", "1", "drill"}));
  EXPECT_EQ(ignored.diagnostics, Lines{"p.exc:5:1: warning[tool-data-ignored]"});
  const ProgramRun obeyed = run_clean(header("T1C1.\n") + "T1H\n" + holes(3) + "M30\n");
  EXPECT_EQ(hits(obeyed), (Lines{"drill", "drill", "drill"}));
  EXPECT_EQ(obeyed.diagnostics, Lines{});
  const ProgramRun ruled = run_clean(header("T1C1.H2\nOM48,ON\n") + "T1H\n" + holes(3) + "M30\n");
  EXPECT_EQ(hits(ruled), (Lines{"drill", "drill", "drill"}));
  EXPECT_EQ(ruled.diagnostics, Lines{});
}

TEST(HitCount, CountsRepeatedHolesAndCopies) {
  EXPECT_EQ(hits(run_clean(header("T1C1.H3\n") + "T1\nX1.Y1.\nR3X1.\nM30\n")),
            (Lines{"drill", "drill", "drill", "1", "drill"}));
  EXPECT_EQ(
      hits(run_clean(header("T1C1.H3\n") + "T1\nM25\n" + holes(2) + "M01\nM02X50.\nM08\nM30\n")),
      (Lines{"drill", "drill", "drill", "1", "drill"}));
}

TEST(HitCount, EachToolHasItsOwnCounterThatGoesOn) {
  EXPECT_EQ(hits(run_clean(header("T1C1.H2\nT2C2.H2\n") +
                           "T1\nX1.Y1.\nT2\nX2.Y1.\nT1\nX3.Y1.\nX4.Y1.\nM30\n")),
            (Lines{"drill", "drill", "drill", "1", "drill"}));
}

// --- CNC-7 manual: Link Tools for Automatic Tool Changers ----------------------------------------

const std::string kThreeOfTwoHits = "T1C1.H2\nT5C1.H2\nT6C1.H2\n";

TEST(ToolLinks, ManualExampleGoesOnFromLeftToRight) {
  const Lines expected = {
      "drill", "drill", "1 next 5", "drill", "drill", "5 next 6", "drill", "drill"};
  EXPECT_EQ(hits(run_clean(header(kThreeOfTwoHits + "1/5/6\n") + "T1\n" + holes(6) + "M30\n")),
            expected);
  EXPECT_EQ(hits(run_clean(header(kThreeOfTwoHits) + "1/5/6\nT1\n" + holes(6) + "M30\n")),
            expected);
}

TEST(ToolLinks, TheOrderIsThatOfTheLink) {
  EXPECT_EQ(hits(run_clean(header(kThreeOfTwoHits + "6/1/5\n") + "T6\n" + holes(5) + "M30\n")),
            (Lines{"drill", "drill", "6 next 1", "drill", "drill", "1 next 5", "drill"}));
}

TEST(ToolLinks, AToolOutsideTheLinkStops) {
  EXPECT_EQ(hits(run_clean(header(kThreeOfTwoHits + "5/6\n") + "T1\n" + holes(3) + "M30\n")),
            (Lines{"drill", "drill", "1", "drill"}));
}

TEST(ToolLinks, AToolNamedTwiceHasOneSuccessor) {
  EXPECT_EQ(
      hits(run_clean(header("T1C1.H1\nT2C1.H1\nT3C1.H1\n1/2/3/2\n") + "T1\n" + holes(3) + "M30\n")),
      (Lines{"drill", "1 next 2", "drill", "2 next 3", "drill"}));
  EXPECT_EQ(
      hits(run_clean(header("T1C1.H1\nT2C1.H1\nT3C1.H1\n1/2/3/2\n") + "T1\n" + holes(4) + "M30\n"))
          .size(),
      7U);
}

TEST(ToolLinks, ASlashAloneClearsThem) {
  const Lines stops = {"drill", "drill", "1", "drill"};
  EXPECT_EQ(hits(run_clean(header(kThreeOfTwoHits + "1/5/6\n") + "/\nT1\n" + holes(3) + "M30\n")),
            stops);
  EXPECT_EQ(hits(run_clean(header(kThreeOfTwoHits + "1/5/6\n/\n") + "T1\n" + holes(3) + "M30\n")),
            stops);
}

// --- CNC-7 manual: Tool Selection with Compensation Index ----------------------------------------

TEST(ToolIndex, ManualExample) {
  EXPECT_THAT(run_clean(header("T3C1.\n") + "T0302\nX1.Y1.\nM30\n").executed.lines(),
              Contains("5 tool 3 index 2"));
}

TEST(ToolIndex, ZerosMeanTheToolsNumber) {
  EXPECT_THAT(run_clean(header("T3C1.\n") + "T0300\nX1.Y1.\nM30\n").executed.lines(),
              Contains("5 tool 3 index 3"));
}

// --- whose data rule -----------------------------------------------------------------------------

TEST(ToolData, TheHeadersRuleOverTheBodys) {
  const ProgramRun run = run_clean(header("T1C1.F100S50\n") + "T1C3.F050S60\nX1.Y1.\nM30\n");
  ASSERT_EQ(run.executed.tools().size(), 1U);
  EXPECT_EQ(run.executed.tools()[0].diameter, mm(1));
  EXPECT_EQ(run.executed.tools()[0].infeed, mm_per_s(100));
  EXPECT_EQ(run.executed.tools()[0].speed, rpm(50'000));
  EXPECT_THAT(run.diagnostics, Contains(says(5, "warning[tool-data-ignored]")));
}

TEST(ToolData, TheSameDataTwiceDoNoHarm) {
  EXPECT_THAT(run_clean(header("T1C1.F100S50\n") + "T1C1.F100S50\nX1.Y1.\nM30\n").diagnostics,
              Each(Not(HasSubstr("tool-data-ignored"))));
}

TEST(ToolData, WithOm48TheBodysRule) {
  const ProgramRun run =
      run_clean(header("OM48,ON\nT1C1.F100S50\n") + "T1C3.F050S60\nX1.Y1.\nM30\n");
  ASSERT_EQ(run.executed.tools().size(), 1U);
  EXPECT_EQ(run.executed.tools()[0].diameter, mm(3));
  EXPECT_EQ(run.executed.tools()[0].infeed, mm_per_s(50));
  EXPECT_EQ(run.executed.tools()[0].speed, rpm(60'000));
  EXPECT_THAT(run.diagnostics, Each(Not(HasSubstr("tool-data-ignored"))));
}

TEST(ToolData, BehindG07FeedAndSpeedOfTheBodyRule) {
  const ProgramRun run =
      run_clean(header("T1C1.F100S50\n") + "T1F050S60\nX1.Y1.\nG07\nT1F050S60\nX2.Y1.\nM30\n");
  ASSERT_EQ(run.executed.tools().size(), 2U);
  EXPECT_EQ(run.executed.tools()[0].infeed, mm_per_s(100));
  EXPECT_EQ(run.executed.tools()[0].speed, rpm(50'000));
  EXPECT_EQ(run.executed.tools()[1].infeed, mm_per_s(50));
  EXPECT_EQ(run.executed.tools()[1].speed, rpm(60'000));
  EXPECT_EQ(run.executed.tools()[1].diameter, mm(1));
}

// --- CNC-7 manual: Z-Axis Infeed, Retract Rate, in blocks of their own ---------------------------

/// True if the machine is ever told this of the tool.
template <class Value>
bool is_told(const ProgramRun& run, std::optional<Value> Tool::*what, Value value) {
  return std::ranges::any_of(run.executed.tools(),
                             [&](const Tool& tool) { return tool.*what == value; });
}

TEST(Rates, InABlockOfTheirOwnBelongToTheToolInUse) {
  const ProgramRun run =
      run_clean(header("T1C1.\nT2C2.\n") + "T1\nF05\nB02\nX1.Y1.\nT2\nX2.Y1.\nT1\nX3.Y1.\nM30\n");
  EXPECT_TRUE(is_told(run, &Tool::infeed, mm_per_s(50)));
  EXPECT_TRUE(is_told(run, &Tool::retract, mm_per_s(200)));
  for (const Tool& tool : run.executed.tools()) {
    if (tool.number != 1) {
      EXPECT_EQ(tool.infeed, std::nullopt);
      EXPECT_EQ(tool.retract, std::nullopt);
    }
  }
}

TEST(Rates, InABlockOfTheirOwnHaveTheRangesOfDrilling) {
  for (const char* rate : {"F6", "F009", "B0009"}) {
    EXPECT_THAT(
        run_clean("M48\nINCH,LZ\nT1C.04\n%\nT1\n" + std::string(rate) + "\nXY\nM30\n").diagnostics,
        Contains(says(6, "warning[rate-out-of-range]")))
        << rate;
  }
  for (const char* rate : {"F2", "F5", "B1", "B0010"}) {
    EXPECT_THAT(
        run_clean("M48\nINCH,LZ\nT1C.04\n%\nT1\n" + std::string(rate) + "\nXY\nM30\n").diagnostics,
        Each(Not(HasSubstr("rate-out-of-range"))))
        << rate;
  }
}

// --- CNC-7 manual: Hierarchy of Tool Commands ----------------------------------------------------

/// A diameter page of one row.
ReadOptions page(Length diameter) {
  ReadOptions reading;
  Tool row;
  row.diameter = diameter;
  row.infeed = inch_per_min(120);
  row.speed = rpm(60'000);
  reading.diameter_page = {row};
  return reading;
}

Tool read_in_header(const std::string& block, const ReadOptions& reading) {
  const ProgramRun run = run_clean("M48\nINCH,LZ\n" + block + "\n%\nT01\nXY\nM30\n", reading);
  EXPECT_EQ(run.executed.tools().size(), 1U);
  return run.executed.tools().at(0);
}

double infeed_inch_per_min(const Tool& tool) {
  return tool.infeed ? *tool.infeed / inch_per_min(1) : 0;
}

TEST(ToolHierarchy, ManualFirstExampleUsesTheFeedAndSpeedOfThePage) {
  const Tool tool = read_in_header("T01F190S73C.038", page(inch(0.038)));
  EXPECT_NEAR(infeed_inch_per_min(tool), 120, 1e-9);
  EXPECT_EQ(tool.speed, rpm(60'000));
}

TEST(ToolHierarchy, ManualSecondExampleIgnoresThePage) {
  const Tool tool = read_in_header("T01C.038F190S73", page(inch(0.038)));
  EXPECT_NEAR(infeed_inch_per_min(tool), 190, 1e-9);
  EXPECT_EQ(tool.speed, rpm(73'000));
}

TEST(ToolHierarchy, ADiameterAloneLoadsThePage) {
  const Tool tool = read_in_header("T01C.038", page(inch(0.038)));
  EXPECT_NEAR(infeed_inch_per_min(tool), 120, 1e-9);
  EXPECT_EQ(tool.speed, rpm(60'000));
}

TEST(ToolHierarchy, APageWithoutTheDiameterLoadsNothing) {
  const Tool tool = read_in_header("T01F190S73C.038", page(inch(0.04)));
  EXPECT_NEAR(infeed_inch_per_min(tool), 190, 1e-9);
  EXPECT_EQ(tool.speed, rpm(73'000));
}

TEST(ToolHierarchy, WithoutAPageTheDoubtfulOrderIsWarnedOf) {
  const ProgramRun doubtful = run_clean("M48\nINCH,LZ\nT01F190S73C.038\n%\nT01\nXY\nM30\n");
  EXPECT_THAT(doubtful.diagnostics, Contains(says(3, "warning[tool-order]")));
  const ProgramRun clear = run_clean("M48\nINCH,LZ\nT01C.038F190S73\n%\nT01\nXY\nM30\n");
  EXPECT_THAT(clear.diagnostics, Each(Not(HasSubstr("tool-order"))));
  for (const ProgramRun* run : {&doubtful, &clear}) {
    ASSERT_EQ(run->executed.tools().size(), 1U);
    EXPECT_NEAR(infeed_inch_per_min(run->executed.tools()[0]), 190, 1e-9);
    EXPECT_EQ(run->executed.tools()[0].speed, rpm(73'000));
  }
}

}  // namespace
}  // namespace panelcal
