// SPDX-License-Identifier: Apache-2.0
// Every word with a length is in inch in a program in inch, and no other word is: each line stands
// beside the one that does the same in millimetres.
#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "program/walk/probing.h"
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/heights.h"
#include "tests/program/sieb_meyer/manual_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::expect_places;
using test::expect_refused;
using test::Heights;
using test::hole_places;
using test::ProgramRun;
using test::SubprogramFolder;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr double kSame_mm = 1e-9;

constexpr std::string_view kMetricTable = "$\nT1D1.016\nT2D2.032\n$\n";
constexpr std::string_view kInchTable = "$\nT1D.04\nT2D.08\n$\n";

ReadOptions inch(ReadOptions reading = {}) {
  reading.forced_format = *parse_format("inch");
  reading.inch_rates = RateUnit::InchesPerMinute;
  return reading;
}

ProgramRun run(const std::string& text,
               const ReadOptions& reading,
               const std::vector<double>& heights_mm = {}) {
  DiagnosticLog log;
  ProgramRun out;
  out.program = load_program({"p.exc", text}, log, reading);
  NominalSource targets;
  Heights heights(heights_mm);
  NominalProbeSource board;
  ProbeSource& probes = heights_mm.empty() ? static_cast<ProbeSource&>(board) : heights;
  out.survey = survey(out.program, {}, targets, probes, log);
  out.has_errors = log.has_errors();
  if (!out.has_errors) execute(out.program, {}, out.survey, out.executed, log);
  out.has_errors = log.has_errors();
  out.diagnostics = test::briefs(log);
  for (const Diagnostic& diagnostic : log.kept()) out.texts.push_back(diagnostic.text());
  return out;
}

ProgramRun in_inch(std::string_view body, const ReadOptions& reading = {}) {
  return run(fmt::format("%%5000\n{}{}", body, kInchTable), inch(reading));
}
ProgramRun in_mm(std::string_view body, const ReadOptions& reading = {}) {
  return run(fmt::format("%%5000\n{}{}", body, kMetricTable), reading);
}

/// CNC commands are passed on as written; writers bring them to their own unit. Subprograms stand
/// in folders of any name.
std::vector<std::string> work_of(const ProgramRun& run) {
  std::vector<std::string> lines;
  for (const std::string& line : run.executed.lines()) {
    if (line.find(" setting M49") != std::string::npos) continue;
    const auto folder_end = line.find("S.SS5:");
    lines.push_back(folder_end == std::string::npos ? line : line.substr(folder_end));
  }
  return lines;
}

void expect_near(const std::optional<Length>& found, const std::optional<Length>& expected) {
  ASSERT_EQ(found.has_value(), expected.has_value());
  if (found) {
    EXPECT_NEAR(found->in_mm(), expected->in_mm(), kSame_mm);
  }
}

void expect_near(const std::optional<Feed>& found, const std::optional<Feed>& expected) {
  ASSERT_EQ(found.has_value(), expected.has_value());
  if (found) {
    EXPECT_NEAR(found->in_mm_s(), expected->in_mm_s(), kSame_mm);
  }
}

void expect_same_tool(const Tool& tool, const Tool& other) {
  expect_near(tool.diameter, other.diameter);
  expect_near(tool.depth_offset, other.depth_offset);
  expect_near(tool.infeed, other.infeed);
  expect_near(tool.retract, other.retract);
  EXPECT_EQ(tool.speed, other.speed);
  EXPECT_EQ(tool.max_hits, other.max_hits);
  EXPECT_EQ(tool.dwell, other.dwell);
  EXPECT_EQ(tool.magazines, other.magazines);
}

void expect_same_cut(const DepthOfCut& found, const DepthOfCut& expected) {
  EXPECT_EQ(found.control, expected.control);
  expect_near(found.z, expected.z);
  expect_near(found.depth, expected.depth);
  expect_near(found.lower_limit, expected.lower_limit);
  expect_near(found.upper_limit, expected.upper_limit);
}

void expect_same(const ProgramRun& found, const ProgramRun& expected) {
  ASSERT_FALSE(expected.has_errors) << testing::PrintToString(expected.texts);
  ASSERT_FALSE(found.has_errors) << testing::PrintToString(found.texts);
  EXPECT_EQ(work_of(found), work_of(expected));
  ASSERT_EQ(found.holes().size(), expected.holes().size());
  for (std::size_t i = 0; i < found.holes().size(); ++i) {
    expect_same_cut(found.holes()[i].drill.cut, expected.holes()[i].drill.cut);
  }
  ASSERT_EQ(found.executed.routs().size(), expected.executed.routs().size());
  for (std::size_t i = 0; i < found.executed.routs().size(); ++i) {
    const Rout& rout = found.executed.routs()[i];
    EXPECT_NEAR(rout.feed.in_mm_s(), expected.executed.routs()[i].feed.in_mm_s(), kSame_mm);
    expect_same_cut(rout.cut, expected.executed.routs()[i].cut);
  }
  ASSERT_EQ(found.executed.tools().size(), expected.executed.tools().size());
  for (std::size_t i = 0; i < found.executed.tools().size(); ++i) {
    expect_same_tool(found.executed.tools()[i], expected.executed.tools()[i]);
  }
}

/// Bodies with the tools T1 of 0.04 inch and T2 of 0.08 inch.
void expect_same(std::string_view inch_body, std::string_view metric_body) {
  SCOPED_TRACE(inch_body);
  const ProgramRun found = in_inch(inch_body);
  expect_same(found, in_mm(metric_body));
}

// --- places --------------------------------------------------------------------------------------

TEST(SiebMeyerInch, Coordinates) {
  expect_same("X1.Y2.T1\nX-.5Y\nX3.\n", "X25.4Y50.8T1\nX-12.7Y\nX76.2\n");
  expect_same("X10000Y20000T1\nX-5000Y\n", "X25400Y50800T1\nX-12700Y\n");
  expect_same("X1.Y2.T1G91\nX.1\nY1000\nX.1Y.1G90\n",
              "X25.4Y50.8T1G91\nX2.54\nY2540\nX2.54Y2.54G90\n");
}

/// Lines of X and Y alone go another way than all others; many of one layout a third one.
TEST(SiebMeyerInch, PlainLinesAreReadAsAllOthers) {
  std::string plain = "X1000Y1000T1\n";
  std::string with_comment = plain;
  for (int i = 0; i < 40; ++i) {
    const std::string line = fmt::format("X{}Y{}", 10001 + 37 * i, 20003 + 41 * i);
    plain += line + "\n";
    with_comment += line + "(A)\n";
  }
  const ProgramRun found = in_inch(plain);
  ASSERT_FALSE(found.has_errors);
  EXPECT_EQ(hole_places(found), hole_places(in_inch(with_comment)));
  EXPECT_NEAR(found.holes().at(40).nominal_mm().x(), (1.0001 + 39 * .0037) * 25.4, kSame_mm);
}

TEST(SiebMeyerInch, OffsetsOfSections) {
  expect_same("X1.Y1.T1M31\nXYM50\nX2.Y.5M60\nX10000M70M30\n",
              "X25.4Y25.4T1M31\nXYM50\nX50.8Y12.7M60\nX25400M70M30\n");
  expect_same("X1.Y1.T1M31\nXYM50V2\nX4.YM50W3M30\n",
              "X25.4Y25.4T1M31\nXYM50V2\nX101.6YM50W3M30\n");
}

TEST(SiebMeyerInch, Subprograms) {
  SubprogramFolder folder;
  folder.with("S.SS5", "@HOLES\nX1.Y1.\nX10000Y\n@PANEL\nXYM50\nX2.YM50\n");
  SubprogramFolder metric;
  metric.with("S.SS5", "@HOLES\nX25.4Y25.4\nX25400Y\n@PANEL\nXYM50\nX50.8YM50\n");
  expect_same(
      in_inch("X5.Y5.T1\nX2.Y1.M99,HOLES\nX1.Y1.M31\nX.5Y.5M30M99,PANEL\n", folder.reading()),
      in_mm("X127.Y127.T1\nX50.8Y25.4M99,HOLES\nX25.4Y25.4M31\nX12.7Y12.7M30M99,PANEL\n",
            metric.reading()));
}

TEST(SiebMeyerInch, PatternsAndTheirStandardGrid) {
  // "Grid = 2.54 mm = 0.1 inch", and a corner that is off it.
  expect_same("X1.Y1.T1V1\nX1.3Y.71\n", "X25.4Y25.4T1V1\nX33.02Y18.034\n");
  expect_same(
      "X1.Y1.T1V2\nX2.Y1.W5\nX1.Y1.V3\nX1.4Y1.3\nX1.Y1.V4\nX1.5Y1.W8\n",
      "X25.4Y25.4T1V2\nX50.8Y25.4W5\nX25.4Y25.4V3\nX35.56Y33.02\nX25.4Y25.4V4\nX38.1Y25.4W8\n");
}

// --- radii and parameters of contours ------------------------------------------------------------

TEST(SiebMeyerInch, RadiiCentresAndRoundings) {
  expect_same("X1.Y1.T0T2\nX2.Y1.G2R.6F10.\nX2.Y2.G3R-7500\nX3.Y3.G1D.25\nX4.Y3.\nX4.Y3.T0\n",
              "X25.4Y25.4T0T2\nX50.8Y25.4G2R15.24F.254\nX50.8Y50.8G3R-19050\nX76.2Y76.2G1D6.35\n"
              "X101.6Y76.2\nX101.6Y76.2T0\n");
  expect_same("X1.Y1.T0T2\nX2.Y2.G2I-1.J0F10.\nX3.Y1.I0J10000\nX3.Y1.T0\n",
              "X25.4Y25.4T0T2\nX50.8Y50.8G2I-25.4J0F.254\nX76.2Y25.4I0J25400\nX76.2Y25.4T0\n");
}

TEST(SiebMeyerInch, Figures) {
  expect_same(
      "X1.Y1.T0T2F10.\nX2.Y2.G45R.5\nX4.Y2.G48R5000\nX6.Y2.G49I1.J.5\nX8.Y2.G50R.6G43\nT0\n",
      "X25.4Y25.4T0T2F.254\nX50.8Y50.8G45R12.7\nX101.6Y50.8G48R12700\n"
      "X152.4Y50.8G49I25.4J12.7\nX203.2Y50.8G50R15.24G43\nT0\n");
}

TEST(SiebMeyerInch, Nibbling) {
  expect_same("X1.Y1.T1G84R.1\nX2.Y2.G85\nX2.2Y2.\nM49,NIB.001\nX3.Y2.G85\nX3.2Y2.\n",
              "X25.4Y25.4T1G84R2.54\nX50.8Y50.8G85\nX55.88Y50.8\nM49,NIB.0254\nX76.2Y50.8G85\n"
              "X81.28Y50.8\n");
}

/// The pitch follows the tool's diameter.
TEST(SiebMeyerInch, Texts) {
  expect_same("X1.Y1.T1M97,A1\nX1.Y2.M98,B\n", "X25.4Y25.4T1M97,A1\nX25.4Y50.8M98,B\n");
}

TEST(SiebMeyerInch, Feeds) {
  expect_same("X1.Y1.T0T2\nX2.Y1.G1F50.\nX2.Y2.F2.5\nX2.Y2.T0\n",
              "X25.4Y25.4T0T2\nX50.8Y25.4G1F1.27\nX50.8Y50.8F.0635\nX50.8Y50.8T0\n");
}

// --- depths --------------------------------------------------------------------------------------

TEST(SiebMeyerInch, PlanesAndDepths) {
  expect_same("H.5Z.1\nX1.Y1.T1\nX2.Y1.G83K.02\nX3.Y1.K200Z.05\nX4.Y1.G82Z1000\n",
              "H12.7Z2.54\nX25.4Y25.4T1\nX50.8Y25.4G83K.508\nX76.2Y25.4K508Z1.27\n"
              "X101.6Y25.4G82Z2540\n");
  expect_same("X1.Y1.T0T2Z.1\nX2.Y1.G1F10.\nX3.Y1.G6Z.2\nX3.Y1.T0\n",
              "X25.4Y25.4T0T2Z2.54\nX50.8Y25.4G1F.254\nX76.2Y25.4G6Z5.08\nX76.2Y25.4T0\n");
}

/// P, W and E are no lengths; outputs have the others in millimetres.
TEST(SiebMeyerInch, PeckAndPulseNumbers) {
  expect_same("X1.Y1.T1Z.1\nX2.Y1.G81I.2P50J.05W800\nX3.Y1.G80\nX4.Y1.G89I.2J500E30R.01\n",
              "X25.4Y25.4T1Z2.54\nX50.8Y25.4G81I5.08P50J1.27W800\nX76.2Y25.4G80\n"
              "X101.6Y25.4G89I5.08J1270E30R.254\n");
}

TEST(SiebMeyerInch, DepthsBelowASurface) {
  expect_same("G71K.02\nX1.Y1.G73L1\nX2.Y1.T1\nG71K-.01\nL1\nX3.Y1.\nG70\n",
              "G71K.508\nX25.4Y25.4G73L1\nX50.8Y25.4T1\nG71K-.254\nL1\nX76.2Y25.4\nG70\n");
}

// --- CNC commands --------------------------------------------------------------------------------

TEST(SiebMeyerInch, ProgramZeroAndTheCentreOfScaling) {
  expect_same("M49,FAX5.Y-2.\nX1.Y1.T1\nM49,NOFA\nX2.Y2.\n",
              "M49,FAX127.Y-50.8\nX25.4Y25.4T1\nM49,NOFA\nX50.8Y50.8\n");
  // SA counts micrometres per metre, RA degrees.
  expect_same("M49,SAX1000.Y500.\nM49,SAZX2.Y4.\nX1.Y1.T1M93\nM49,RA30\nX2.Y2.\n",
              "M49,SAX1000.Y500.\nM49,SAZX50.8Y101.6\nX25.4Y25.4T1M93\nM49,RA30\nX50.8Y50.8\n");
}

TEST(SiebMeyerInch, ProbingDepthReferenceAndTolerance) {
  const std::string grid = "XYG79\nX1.YG79\nXY1.G79\nX1.Y1.G79\nX.5Y.5T1Z.02\n";
  const auto probe = [&](const std::string& commands, const std::vector<double>& heights_mm) {
    return run("%%5000\n" + commands + grid + std::string(kInchTable), inch(), heights_mm);
  };
  const std::string reference = "M49,BOTR.06\nM49,BOTK.02\n";
  const ProgramRun good = probe(reference, {1.6, 1.6, 1.6, 1.6});
  ASSERT_FALSE(good.has_errors) << testing::PrintToString(good.texts);
  EXPECT_NEAR(good.survey.probes.at(0).request.reference.in_mm(), 1.524, kSame_mm);
  ASSERT_TRUE(good.survey.probes.at(0).request.depth);
  EXPECT_NEAR(good.survey.probes.at(0).request.depth->in_mm(), .508, kSame_mm);
  EXPECT_NEAR(good.survey.probes.at(1).request.nominal.in_mm().x(), 25.4, kSame_mm);
  ASSERT_TRUE(good.holes().at(0).drill.cut.z);
  EXPECT_NEAR(good.holes().at(0).drill.cut.z->in_mm(), .508 + (1.6 - 1.524), kSame_mm);
  for (const char* const command : {"M49,BOTT.002\n", "M49,TOPT,R.002\n", "M49,MAPT.002\n"}) {
    EXPECT_FALSE(probe(reference + command, {1.53, 1.57, 1.5, 1.52}).has_errors) << command;
    expect_refused(probe(reference + command, {1.53, 1.58, 1.5, 1.52}),
                   6,
                   {std::string_view(command).substr(4, 4)});
  }
}

// --- areas ---------------------------------------------------------------------------------------

TEST(SiebMeyerInch, Areas) {
  const ProgramRun found = in_inch("M49,PRGM,C\nX1.Y1.M58D.2\nX1.05Y1.T1\nX1.2Y1.\nX5.Y6.M56\n");
  expect_same(found,
              in_mm("M49,PRGM,C\nX25.4Y25.4M58D5.08\nX26.67Y25.4T1\nX30.48Y25.4\n"
                    "X127.Y152.4M56\n"));
  EXPECT_EQ(found.holes().size(), 1U);
  EXPECT_THAT(found.executed.lines(), Contains(HasSubstr("X127.000Y152.400M56")));
}

// --- the tool table ------------------------------------------------------------------------------

TEST(SiebMeyerInch, TheToolTable) {
  const auto with_table = [](std::string_view table, const ReadOptions& reading) {
    return run(fmt::format("%%5000\nX1.Y1.T1\nX1.Y1.T2\n$\n{}$\n", table), reading);
  };
  const ProgramRun found =
      with_table("T1D.04S50F80.R400.N3000A300Z-.002\nM1M2\nT2D.04S50.F80.R400.N30A.3Z20\n", inch());
  const ProgramRun expected = with_table(
      "T1D1.016S50F2.032R10.16N3000A300Z-.0508\nM1M2\nT2D1.016S50F2.032R10.16N30A.3Z.0508\n", {});
  ASSERT_FALSE(found.has_errors) << testing::PrintToString(found.texts);
  ASSERT_EQ(found.executed.tools().size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    expect_same_tool(found.executed.tools()[i], expected.executed.tools().at(i));
  }
}

TEST(SiebMeyerInch, TheTableOfFormat1000) {
  std::string values = "$40$55$8$40$30$300$";
  while (std::count(values.begin(), values.end(), '$') < 91) values += '$';
  ReadOptions reading;
  reading.last_format = *parse_format("inch,tz,2.3");
  reading.inch_rates = RateUnit::MetersPerMinute;
  const ProgramRun found = run("%%\nX1000Y2000T1\n" + values + "\n", reading);
  ASSERT_FALSE(found.has_errors) << testing::PrintToString(found.texts);
  expect_places(hole_places(found), {{25.4, 50.8}});
  const Tool& tool = found.executed.tools().at(0);
  expect_near(tool.diameter, mm(1.016));
  expect_near(tool.infeed, mm_per_s(800. / 60));
  EXPECT_EQ(tool.max_hits, 3000);
}

// --- zeros and digits ----------------------------------------------------------------------------

TEST(SiebMeyerInch, LeadingZerosHoldForCoordinatesAndOffsets) {
  ReadOptions reading;
  reading.forced_format = *parse_format("inch,lz,2.4");
  const ProgramRun found =
      run("%%5000\nX01Y02T1M31\nX0105Y025\nX1.5Y\nXYM50\nX10YM50M30\n" + std::string(kInchTable),
          reading);
  ASSERT_FALSE(found.has_errors) << testing::PrintToString(found.texts);
  expect_places(hole_places(found),
                {{25.4, 50.8},
                 {1.05 * 25.4, 2.5 * 25.4},
                 {38.1, 0},
                 {11 * 25.4, 50.8},
                 {11.05 * 25.4, 2.5 * 25.4},
                 {11.5 * 25.4, 0}});
  const ProgramRun refused = run("%%5000\nX0123456Y0T1\n" + std::string(kInchTable), reading);
  EXPECT_THAT(refused.diagnostics, Contains("p.exc:2:1: error[number-malformed]"));
}

/// The same program under the control's setting: a special format.
TEST(SiebMeyerInch, ASpecialFormatIsReadAsTheControlIsSet) {
  ReadOptions reading;
  reading.last_format = *parse_format("inch,tz,2.4");
  const ProgramRun found = run("%%5001\nX1.Y20000T1\n" + std::string(kInchTable), reading);
  EXPECT_THAT(found.texts, IsEmpty());
  expect_places(hole_places(found), {{25.4, 50.8}});
  EXPECT_EQ(found.program.number_summary(),
            "format 5000 in inch, 0.0001 inch without a decimal point");
}

/// %%5000 states millimetres, whatever the control is set to.
TEST(SiebMeyerInch, AProgramInMillimetresStaysOneOnAControlInInch) {
  ReadOptions reading;
  reading.last_format = *parse_format("inch,lz,2.4");
  const ProgramRun found = run("%%5000\nX1.Y2000T1\n" + std::string(kMetricTable), reading);
  expect_places(hole_places(found), {{1, 2}});
  EXPECT_THAT(found.diagnostics, testing::ElementsAre("p.exc:1:1: warning[format-overridden]"));
}

// --- what nothing states -------------------------------------------------------------------------

TEST(SiebMeyerInch, RefusesRatesWhoseUnitNothingStates) {
  ReadOptions reading = inch();
  reading.inch_rates.reset();
  const std::string program =
      "%%5000\nX1.Y1.T0T1\nX2.Y1.G1F50.\nX2.Y2.\nX2.Y2.T0\n$\nT1D.04F80.R400.\n$\n";
  const ProgramRun found = run(program, reading);
  EXPECT_THAT(found.diagnostics,
              testing::IsSupersetOf(
                  {"p.exc:7:7: error[format-ambiguous]", "p.exc:3:9: error[format-ambiguous]"}));
  EXPECT_THAT(found.texts, Contains(HasSubstr("rates = \"inch/min\" or \"m/min\"")));
  reading.inch_rates = RateUnit::MetersPerMinute;
  const ProgramRun in_metres = run(program, reading);
  ASSERT_FALSE(in_metres.has_errors) << testing::PrintToString(in_metres.texts);
  EXPECT_NEAR(in_metres.executed.routs().at(0).feed.in_mm_s(), 50e3 / 60, kSame_mm);
  // A program in millimetres does not ask.
  EXPECT_THAT(in_mm("X1.Y1.T0T1\nX2.Y1.G1F.5\nX2.Y1.T0\n").texts, IsEmpty());
}

/// D1 is 0.01 mm beside X1 = 0.001 mm, Z1 as well in format 3000: other steps than coordinates.
TEST(SiebMeyerInch, RefusesStepsThatNothingStates) {
  const ProgramRun table = run("%%5000\nX1.Y1.T1\n$\nT1D80\n$\n", inch());
  EXPECT_THAT(table.diagnostics, Contains("p.exc:4:3: error[format-ambiguous]"));
  const ProgramRun plane = run("%%3000\nX1.Y1.T1Z10\n$\nT1\n$\n", inch());
  EXPECT_THAT(plane.diagnostics, Contains("p.exc:2:9: error[format-ambiguous]"));
  expect_same(run("%%3000\nX1.Y1.T1Z.1\n$\nT1\n$\n", inch()),
              run("%%3000\nX25.4Y25.4T1Z2.54\n$\nT1\n$\n", {}));
}

TEST(SiebMeyerInch, RefusesLeadingZerosOfRadiiAndPlanes) {
  ReadOptions reading;
  reading.forced_format = *parse_format("inch,lz,2.4");
  const auto lines = [&](const std::string& radius, const std::string& plane) {
    return run("%%5000\nX01Y01T0T2" + plane + "\nX02Y01G2" + radius + "\nX02Y01T0\n" +
                   std::string(kInchTable),
               reading);
  };
  EXPECT_THAT(lines("R01", "Z.1").diagnostics, Contains("p.exc:3:9: error[format-ambiguous]"));
  EXPECT_THAT(lines("R1.", "Z01").diagnostics, Contains("p.exc:2:11: error[format-ambiguous]"));
  for (const ProgramRun& found : {lines("R1.", "Z.1"), lines("R010000", "Z001000")}) {
    ASSERT_FALSE(found.has_errors) << testing::PrintToString(found.texts);
    ASSERT_TRUE(found.executed.routs().at(0).cut.z);
    EXPECT_NEAR(found.executed.routs().at(0).cut.z->in_mm(), 2.54, kSame_mm);
  }
}

/// The manual's examples have points; no table has a step of M49's lengths.
TEST(SiebMeyerInch, RefusesLengthsOfCncCommandsWithoutAPoint) {
  for (const char* const command : {"M49,MAPT400",
                                    "M49,TOPT,R20",
                                    "M49,BOTK200",
                                    "M49,BOTR1",
                                    "M49,NIB1",
                                    "M49,FAX10000Y20000",
                                    "M49,FAX1.Y2",
                                    "M49,SAZX1Y0"}) {
    const std::string body = std::string(command) + "\nX1.Y1.T1\n";
    EXPECT_THAT(in_inch(body).diagnostics, Contains("p.exc:2:5: error[format-ambiguous]"))
        << command;
    // In table B's numbers they are in mm, whatever the control is set to.
    ReadOptions reading;
    reading.last_format = *parse_format("inch,tz,2.4");
    EXPECT_FALSE(in_mm(body, reading).has_errors) << command;
    reading.forced_format = *parse_format("metric,lz,4.2");
    EXPECT_THAT(in_mm(body, reading).diagnostics, Contains("p.exc:2:5: error[format-ambiguous]"))
        << command;
  }
  for (const char* const command : {"M49,FAX0Y0", "M49,BOTR0", "M49,SAX100Y50", "M49,RA30"}) {
    EXPECT_FALSE(in_inch(std::string(command) + "\nX1.Y1.T1M93\n").has_errors) << command;
  }
}

// --- FP ------------------------------------------------------------------------------------------

/// The format behind %% is in force already; another one is not described.
TEST(SiebMeyerInch, FpIsObeyedWhereItIsTheProgramsOwnFormat) {
  for (const char* const command : {"M49,FP5000\n", "M49,FP,5000\n"}) {
    const ProgramRun own = in_mm(command + std::string("X1.Y1.T1\n"));
    EXPECT_THAT(own.texts, IsEmpty());
    EXPECT_THAT(own.executed.lines(), Not(Contains(HasSubstr("FP"))));
  }
  for (const char* const command : {"M49,FP3000\n", "M49,FP5001\n", "M49,FP\n"}) {
    const ProgramRun other = in_mm(command + std::string("X1.Y1.T1\n"));
    EXPECT_THAT(other.diagnostics, Contains("p.exc:2:5: error[not-supported]")) << command;
  }
  ReadOptions reading;
  reading.last_format = *parse_format("inch,tz,2.4");
  EXPECT_FALSE(run("%%5001\nM49,FP5001\nX1.Y1.T1\n" + std::string(kInchTable), reading).has_errors);
}

}  // namespace
}  // namespace panelcal
