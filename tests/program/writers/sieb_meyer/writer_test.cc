// SPDX-License-Identifier: Apache-2.0
#include "program/writers/sieb_meyer/writer.h"

#include <string>
#include <vector>

#include "tests/program/writers/sieb_meyer/written.h"
#include "tests/support/matchers.h"

namespace panelcal::test::to_sieb_meyer {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const std::string kTable = "$\nT1D1.\nT2D2.5\n$\n";

// --- file (appendix A.7) -----------------------------------------------------------------------

TEST(SiebMeyerWriter, WritesADrillingProgram) {
  const Written written = from_excellon({take(1, 1), drill(1, 10, 20), drill(1, -1.5, 0)},
                                        {.comments = {"made by 100%\nhand"}});
  EXPECT_EQ(written.text, "made by 100??hand\n" + kBegin + "X10.Y20.T1\nX-1.5Y0.\n" + kTable);
  EXPECT_THAT(written.losses, IsEmpty());
}

TEST(SiebMeyerWriter, NoLineHasMoreThan64Characters) {
  const Rout arc =
      rout_arc(RoutKind::Clockwise, 1, -123.456789, -234.567891, -345.678912, -456.789123);
  Rout line = rout_line(1, -123.456789, -111.222333, mm_per_s(33.333333));
  const std::string text =
      from_excellon({Message{std::string_view("0123456789012345678901234567890123456789012345678901"
                                              "234567890123456789")},
                     take(1, 1),
                     rapid_move(-999.888777, -999.888777),
                     Compensation{CompensationSide::Left, mm(1)},
                     plunge(1),
                     arc,
                     line,
                     Retract{}},
                    {.comments = {std::string(200, 'c')}})
          .text;
  std::size_t longest = 0;
  for (std::size_t at = 0; at < text.size();) {
    const auto end = text.find('\n', at);
    longest = std::max(longest, end - at);
    at = end + 1;
  }
  EXPECT_EQ(longest, 64U);  // the comment's
}

TEST(SiebMeyerWriter, WritesToolDataInTheTablesUnits) {
  const Tool tool{.number = 7,
                  .diameter = mm(0.8),
                  .infeed = mm_per_s(20),    // 1.2 m/min
                  .retract = mm_per_s(165),  // 9.9 m/min
                  .speed = rpm(55000),
                  .max_hits = 3000,
                  .depth_offset = mm(-0.01)};
  EXPECT_THAT(from_excellon({ToolChange{tool, {}}}).text,
              HasSubstr("\nT7\n$\nT1D1.\nT2D2.5\nT7D0.8S55.F1.2R9.9N3000Z-0.01\n$\n"));
}

TEST(SiebMeyerWriter, OneSetOfToolDataForTheWholeProgram) {
  ToolChange other = take(1, 1);
  other.tool.speed = rpm(30000);
  ToolChange third = other;
  third.tool.speed = rpm(40000);
  EXPECT_THAT(from_excellon({other, take(2, 2.5), third}).losses,
              ElementsAre(Reports("p:12: warning[translation-loss]")));
  EXPECT_THAT(from_excellon({take(1, 1), take(1, 1.1)}).failure,
              Reports("p:11: error[translation-refused]"));
  EXPECT_THAT(from_excellon({take(100, 1)}).failure,
              Reports("p:10: error[translation-refused]", "100"));
}

TEST(SiebMeyerWriter, StatesTheAxisVersion) {
  ProgramInfo info = info_of(Dialect::Excellon);
  info.axis_version = 3;  // x points up, y points left
  EXPECT_THAT(
      write_out({drill(1, 3, 4)}, info).text,
      HasSubstr("%%5000\nM49,FV3\nM49,NONIBO\nM49,NIB0.013\nM49,NORA\nM49,NOSA\nX4.Y-3.\n"));
  EXPECT_EQ(from_excellon({Setting{"VER,1", SettingKind::Header}}).body, "");
}

// --- routing (3.1, 3.2) ------------------------------------------------------------------------

TEST(SiebMeyerWriter, WritesAContourBetweenT0Lines) {
  const Written written = from_excellon({take(2, 2.5),
                                         rapid_move(10, 50),
                                         plunge(2),
                                         rout_line(2, 50, 20),
                                         rout_line(2, 90, 60),
                                         Retract{},
                                         rapid_move(90, 60),
                                         rapid_move(0, 0),
                                         drill(2, 1, 2)});
  EXPECT_EQ(written.body,
            "X10.Y50.T2T0\nX50.Y20.G1F1.2\nX90.Y60.G1\nX90.Y60.T0\nX0.Y0.T0\nX1.Y2.\n");
}

/// The manual's example of I and J, with a centre that is equally far from both ends.
TEST(SiebMeyerWriter, ArcOffsetsLeadFromTheCenterToTheStart) {
  EXPECT_EQ(from_excellon({rapid_move(20, 80),
                           plunge(2),
                           rout_arc(RoutKind::Clockwise, 2, 75, 25, 50, 55),
                           rout_arc(RoutKind::Counterclockwise, 2, 20, 80, 50, 55),
                           Retract{}})
                .body,
            "X20.Y80.T0\nX75.Y25.G2I-30.J25.F1.2\nX20.Y80.G3I25.J-30.\nX20.Y80.T0\n");
}

TEST(SiebMeyerWriter, MirroredAxesExchangeSenses) {
  ProgramInfo info = info_of(Dialect::Excellon);
  info.axis_version = 4;  // x points left, y points up
  EXPECT_THAT(write_out({take(2, 2.5),
                         rapid_move(3, 4),
                         Compensation{CompensationSide::Left, mm(2.5)},
                         plunge(2),
                         rout_arc(RoutKind::Clockwise, 2, 5, 6, 3, 6),
                         Retract{}},
                        info)
                  .text,
              HasSubstr("M49,NOSA\nX-3.Y4.T2T0\nX-5.Y6.G3I0.J-2.F1.2G42\nX-5.Y6.T0\n$\n"));
}

TEST(SiebMeyerWriter, CompensationIsSaidInEveryContour) {
  const std::vector<What> contour = {rapid_move(0, 0), plunge(2), rout_line(2, 1, 0), Retract{}};
  std::vector<What> operations = {take(2, 2.5), Compensation{CompensationSide::Right, mm(2.5)}};
  operations.insert(operations.end(), contour.begin(), contour.end());
  operations.insert(operations.end(), contour.begin(), contour.end());
  operations.emplace_back(Compensation{});
  operations.insert(operations.end(), contour.begin(), contour.end());
  EXPECT_EQ(from_excellon(operations).body,
            "X0.Y0.T2T0\nX1.Y0.G1F1.2G42\nX1.Y0.T0\nX0.Y0.T0\nX1.Y0.G1G42\nX1.Y0.T0\n"
            "X0.Y0.T0\nX1.Y0.G1\nX1.Y0.T0\n");
}

TEST(SiebMeyerWriter, CompensatesForTheToolsDiameterOnly) {
  EXPECT_THAT(from_excellon({take(2, 2.5), Compensation{CompensationSide::Left, mm(2.4)}}).failure,
              AllOf(HasSubstr("error[translation-refused]"), HasSubstr("2.4 mm")));
  EXPECT_THAT(from_excellon({take(2, 2.5), Compensation{CompensationSide::Left, {}}}).losses,
              ElementsAre(HasSubstr("warning[translation-loss]")));
}

/// The same coordinates twice running would stop the control; a T0 line does not count.
TEST(SiebMeyerWriter, LeavesOutLinesWithoutLengthButNotTheOnlyOne) {
  EXPECT_EQ(from_excellon({rapid_move(1, 1),
                           plunge(2),
                           rout_line(2, 2, 1),
                           rout_line(2, 2, 1),
                           Retract{},
                           rapid_move(5, 5),
                           plunge(2),
                           Retract{}})
                .body,
            "X1.Y1.T0\nX2.Y1.G1F1.2\nX2.Y1.T0\nX5.Y5.T0\nX5.Y5.G1\nX5.Y5.T0\n");
}

TEST(SiebMeyerWriter, SaysExcellonsDefaultFeed) {
  Rout rout = rout_line(2, 1, 1, inch_per_min(100));  // 2.54 m/min
  rout.feed_is_default = true;
  const std::vector<What> contour = {rapid_move(0, 0), plunge(2), rout, Retract{}};
  EXPECT_THAT(from_excellon(contour).body, HasSubstr("X1.Y1.G1F2.54\n"));
  EXPECT_THAT(from_sieb_meyer(contour).body, HasSubstr("X1.Y1.G1\n"));
}

TEST(SiebMeyerWriter, RefusesDepthsThatOnlyExcellonHas) {
  EXPECT_THAT(from_excellon({rapid_move(1, 1), Plunge{2, PlungeKind::Contouring, {}, {}}}).failure,
              Reports("p:11: error[translation-refused]", "M14"));
  EXPECT_THAT(from_excellon({rapid_move(1, 1), Plunge{2, PlungeKind::Plain, mm(0.1), {}}}).failure,
              HasSubstr("p:11: error[translation-refused]"));
  const StepSlot steps{2, place(5, 6), place(5, 7), mm(0.2), mm(-0.1)};
  EXPECT_THAT(from_excellon({steps}).failure, HasSubstr("G87"));
  const Written forced = from_excellon({steps, drill(1, 1, 2)}, kept());
  EXPECT_EQ(forced.body, "X1.Y2.\n");
  EXPECT_EQ(forced.losses.size(), 1U);
}

// --- depths (8.2, 3.3, 11) ---------------------------------------------------------------------

TEST(SiebMeyerWriter, SaysWorkingPlanesWhereTheyChange) {
  DepthOfCut deep = below(2);
  deep.lower_limit = mm(1.5);
  EXPECT_EQ(from_sieb_meyer({drill_at(1, 0, z(1)),
                             drill_at(2, 0, z(1)),
                             drill_at(3, 0, z(1.5)),
                             drill_at(4, 0, deep),
                             drill_at(5, 0, deep),
                             drill_at(6, 0, z(1.5))})
                .body,
            "X1.Y0.Z1.\nX2.Y0.\nX3.Y0.Z1.5\nX4.Y0.G83K2.\nX5.Y0.\nX6.Y0.G82\n");
}

/// The ramp of the manual's section on G6: from 2 mm to 3.5 mm.
TEST(SiebMeyerWriter, WritesARamp) {
  Rout ramp = rout_line(2, 70, 40, mm_per_s(20));
  ramp.cut = z(3.5);
  EXPECT_EQ(
      from_sieb_meyer({take(2, 2.5), rapid_move(20, 40), plunge(2, z(2)), ramp, Retract{}}).body,
      "X20.Y40.T2T0Z2.\nX70.Y40.G1F1.2G6Z3.5\nX70.Y40.T0\n");
}

TEST(SiebMeyerWriter, ADepthBelowAMeasuredSurfaceIsAPlane) {
  EXPECT_EQ(from_sieb_meyer({drill_at(1, 2, below(0.4, mm(3.05)))}).body, "X1.Y2.Z2.65\n");
}

TEST(SiebMeyerWriter, OnePlaneDoesForAxesOverOneSurface) {
  DepthOfCut cut = below(0.4, mm(3.05));
  cut.other_surfaces = {mm(3.055)};
  EXPECT_EQ(from_sieb_meyer({drill_at(1, 2, cut)}).body, "X1.Y2.Z2.65\n");
  cut.other_surfaces = {mm(3.055), mm(3.2)};
  EXPECT_THAT(from_sieb_meyer({drill_at(1, 2, cut)}).failure, HasSubstr("150 um"));
  // A plane that follows a grid counts from each axis' own reference.
  DepthOfCut moved = {.z = mm(1), .depth = {}, .surface = mm(3.05)};
  moved.other_surfaces = {mm(3.2)};
  moved.reference = PlaneReference{position_mm<frame::Nominal>(0, 0), mm(3.0), {mm(3.15)}};
  EXPECT_EQ(from_sieb_meyer({drill_at(1, 2, moved)}).body, "X1.Y2.Z1.\n");
  moved.reference->other_heights = {mm(3.0)};
  EXPECT_THAT(from_sieb_meyer({drill_at(1, 2, moved)}).failure, HasSubstr("150 um"));
}

/// An offset of the $ table comes to planes: the control would add it to this one too.
TEST(SiebMeyerWriter, RefusesADepthAsAPlaneOfAToolWithAnOffset) {
  ToolChange change = take(1, 1);
  change.tool.depth_offset = mm(0.3);
  const DepthOfCut cut = below(0.4, mm(3.05));
  EXPECT_THAT(from_sieb_meyer({change, drill_at(1, 2, cut)}).failure, HasSubstr("0.3 mm"));
}

/// docs/decisions/self_contained_output.md
TEST(SiebMeyerWriter, RefusesMoreThanSixDigitsUnlessTheControlReadsMore) {
  EXPECT_THAT(from_sieb_meyer({drill(1, 100, 2000.125)}).failure,
              Reports("p:10: error[number-too-long]",
                      "\"2000.125\" has 7 digits",
                      "at most 6 digits",
                      "--resolution 0.1"));
  EXPECT_EQ(from_sieb_meyer({drill(1, 100, 2000.12)}).body, "X100.Y2000.12\n");
  EXPECT_EQ(from_sieb_meyer({drill(1, 100, 2000.125)}, {.resolution = um(0.1)}).body,
            "X100.Y2000.125\n");
  const Written longer = from_sieb_meyer({drill(1, 12345678.9125, 0)}, {.resolution = um(0.1)});
  EXPECT_THAT(longer.failure, AllOf(HasSubstr("before the point"), Not(HasSubstr("--resolution"))));
}

/// "If no code letter is saved for a parameter, the corresponding value in the tool table remains
/// unchanged": the control would add the offset of an earlier job.
TEST(SiebMeyerWriter, ZeroesTheOffsetOfAToolThatWorksBelowAMap) {
  const DepthOfCut cut = below(0.4, mm(3.05));
  const Written written = from_sieb_meyer({take(1, 1), drill_at(1, 2, cut)});
  EXPECT_THAT(written.text, testing::EndsWith("$\nT1D1.Z\nT2D2.5\n$\n"));
  EXPECT_THAT(written.losses, IsEmpty());
  for (const DepthOfCut& own : {z(1), DepthOfCut()}) {
    const Written both = from_sieb_meyer({take(1, 1), drill_at(1, 0, own), drill_at(1, 2, cut)});
    EXPECT_THAT(both.losses, ElementsAre(Reports("p:12: warning[translation-loss]", "tool 1")));
  }
  const Written behind = from_sieb_meyer({take(1, 1), drill_at(1, 2, cut), drill_at(1, 0, z(1))});
  EXPECT_THAT(behind.losses, ElementsAre(Reports("p:12: warning[translation-loss]", "tool 1")));
  ToolChange stated = take(1, 1);
  stated.tool.zeroed = "Z";
  const Written zero = from_sieb_meyer({stated, drill_at(1, 0, z(1)), drill_at(1, 2, cut)});
  EXPECT_THAT(zero.text, testing::EndsWith("$\nT1D1.Z\nT2D2.5\n$\n"));
  EXPECT_THAT(zero.losses, IsEmpty());
}

/// "If no Z-value is programmed, the manually entered Z-value is used as working plane": until one
/// is.
TEST(SiebMeyerWriter, GoesBackToThePlaneThatWasSetByHand) {
  EXPECT_EQ(
      from_sieb_meyer({drill_at(1, 0, below(2)), drill_at(2, 0, {}), drill_at(3, 0, {})}).body,
      "X1.Y0.G83K2.\nX2.Y0.G82\nX3.Y0.\n");
  EXPECT_THAT(from_sieb_meyer({drill_at(1, 0, z(1)), drill_at(2, 0, {})}).failure,
              HasSubstr("error[translation-refused]"));
  EXPECT_THAT(from_sieb_meyer({drill_at(1, 0, {.z = {}, .depth = {}, .surface = mm(1.8)})}).failure,
              HasSubstr("error[translation-refused]"));
}

TEST(SiebMeyerWriter, WritesSlotsWhole) {
  EXPECT_EQ(from_sieb_meyer({take(1, 1), Slot{1, place(10, 10), place(20, 10), z(1)}}).body,
            "X10.Y10.T1G85Z1.\nX20.Y10.\n");
}

// --- stops, texts, settings --------------------------------------------------------------------

TEST(SiebMeyerWriter, WritesStops) {
  const Written written =
      from_excellon({Stop{.kind = StopKind::HeaderEnd},
                     Stop{.kind = StopKind::Optional},
                     Stop{.kind = StopKind::Inspection},
                     Stop{StopKind::Optional, displacement_mm<frame::Machine>(1, 2), {}},
                     Stop{.kind = StopKind::EndRewind}});
  EXPECT_EQ(written.body, "M20\nM47,INSPECTION STOP\nM20\n");
  EXPECT_THAT(written.losses, ElementsAre(Reports("p:13: warning[translation-loss]")));
}

/// Lines of a subprogram count from its own begin.
TEST(SiebMeyerWriter, AnOutputOfASubprogramHoldsForItsOwnLine) {
  const Function output{.kind = FunctionKind::MachineFunction,
                        .text = "M21",
                        .tool = 0,
                        .next_tool = std::nullopt,
                        .is_at_place = true};
  StringSink bytes;
  SiebMeyerWriter writer(bytes, {});
  writer.begin(info_of(Dialect::SiebMeyer));
  writer.put({4, {}, output, "sub", nullptr});
  writer.put({4, {}, drill(1, 3, 3), "sub", nullptr});
  writer.put({4, {}, drill(1, 9, 9), {}, nullptr});
  ASSERT_TRUE(writer.finish());
  EXPECT_THAT(bytes.text(), HasSubstr("X3.Y3.M21\nX9.Y9.\n"));
}

TEST(SiebMeyerWriter, SaysThatTheSourceHasNoEnd) {
  const Written written = from_excellon({Stop{.kind = StopKind::EndAccepted}});
  EXPECT_EQ(written.body, "(the source has no M30: accepted by --accept-unterminated)\n");
  EXPECT_THAT(written.losses, testing::IsEmpty());
}

TEST(SiebMeyerWriter, MessagesThatWouldBeOrdersAreMarked) {
  EXPECT_EQ(from_excellon({Message{"TURN BOARD"},
                           Message{"!NOW"},
                           Message{"&PARK"},
                           Message{"FIRST\nSECOND", true}})
                .body,
            "M47,TURN BOARD\nM47,- !NOW\nM47,- &PARK\nM47,FIRST\nM47,SECOND\n");
  EXPECT_EQ(from_sieb_meyer({Message{"&P!TURN BOARD"}}).body, "M47,&P!TURN BOARD\n");
}

TEST(SiebMeyerWriter, ProgramZeroIsAPlaceOnTheMachine) {
  ProgramWriterOptions options;
  options.absolute_zero = position_mm<frame::Machine>(100, 0);
  const ZeroSet zero{displacement_mm<frame::Machine>(1, 2), position_mm<frame::Machine>(123.4, 5)};
  EXPECT_EQ(from_excellon({zero}, options).body, "M49,FAX23.4Y5.\n");
}

TEST(SiebMeyerWriter, NamesWhatExcellonHasAlone) {
  const Written written = from_excellon({Setting{"METRIC,TZ", SettingKind::Header},
                                         Setting{"ATC,ON", SettingKind::Header},
                                         Setting{"1/2"},
                                         Setting{"G05"},
                                         function(FunctionKind::PeckOn, "M62"),
                                         Dwell{seconds(2)},
                                         ToolChange{}});
  EXPECT_EQ(written.body, "");
  EXPECT_THAT(written.losses,
              ElementsAre(Reports("p:11: warning[translation-loss]", "\"ATC,ON\""),
                          Reports("p:12: warning[translation-loss]"),
                          Reports("p:14: warning[translation-loss]", "\"M62\""),
                          Reports("p:15: warning[translation-loss]", "2 s"),
                          Reports("p:16: warning[translation-loss]", "T0")));
  EXPECT_THAT(from_excellon({Setting{"DN,1.5", SettingKind::Header}}).failure,
              HasSubstr("translation-refused"));
  EXPECT_THAT(from_excellon({function(FunctionKind::ScalingOn, "M60")}).failure,
              HasSubstr("translation-refused"));
}

TEST(SiebMeyerWriter, PassesItsOwnOrdersOn) {
  const Written written = from_sieb_meyer({function(FunctionKind::MachineFunction, "M34"),
                                           function(FunctionKind::PeckOn, "G81I5.P80J1.4W1000"),
                                           Setting{"M49,BROK2"},
                                           Setting{"M49,CAMA"},
                                           rapid_move(1, 1),
                                           plunge(1),
                                           function(FunctionKind::FinishRouting, "G11"),
                                           rout_line(1, 2, 1),
                                           Retract{}});
  EXPECT_EQ(written.body,
            "M34\nG81I5.P80J1.4W1000\nM49,BROK2\nX1.Y1.T0\nX2.Y1.G1F1.2G11\nX2.Y1.T0\n");
  EXPECT_THAT(written.losses, IsEmpty());
}

}  // namespace
}  // namespace panelcal::test::to_sieb_meyer
