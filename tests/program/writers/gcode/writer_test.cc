// SPDX-License-Identifier: Apache-2.0
#include "program/writers/gcode/writer.h"

#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/writers/gcode/writer_run.h"

namespace panelcal {
namespace {

using namespace test;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// --- drilling ----------------------------------------------------------------------------------

TEST(GcodeWriter, DrillsBetweenATurningAndAStandingSpindle) {
  const Written written =
      write_out({take(1), drill(1, 10, 20), drill(1, -1.5, 0), Stop{StopKind::EndRewind, {}, {}}});
  EXPECT_EQ(written.text,
            "T1 M6 ; 1 mm\n"
            "S30000 M3\n"
            "G0 Z5\n"
            "G81 X10 Y20 Z-1.8 R5 F1200\n"
            "X-1.5 Y0\n"
            "G80\n"
            "M5\n"
            "M2\n");
  EXPECT_THAT(written.losses, IsEmpty());
}

TEST(GcodeWriter, EndsWhatHasNoEnd) {
  EXPECT_EQ(write_out({take(1), drill(1, 0, 0)}, on_the_board(), sieb_meyer_info()).text,
            "T1 M6 ; 1 mm\nS30000 M3\nG0 Z5\nG81 X0 Y0 Z-1.8 R5 F1200\nG80\nM5\nM2\n");
  EXPECT_EQ(write_out({}).text, "M2\n");
}

TEST(GcodeWriter, SaysThatTheSourceHasNoEnd) {
  EXPECT_EQ(write_out({Stop{StopKind::EndAccepted, {}, {}}}).text,
            "; the source has no M30: accepted by --accept-unterminated\nM2\n");
}

TEST(GcodeWriter, ApproachesRapidlyAndWaitsForTheSpindle) {
  GcodeSetting setting = on_the_board();
  setting.approach_z = mm(0.5);
  setting.spin_up = seconds(2.5);
  setting.has_length_offset = true;
  EXPECT_EQ(write_out({take(1), drill(1, 1, 2)}, setting).text,
            "T1 M6 ; 1 mm\nG43\nS30000 M3\nG4 P2.5\nG0 Z5\nG81 X1 Y2 Z-1.8 R0.5 F1200\nG80\nM5\n"
            "M2\n");
}

TEST(GcodeWriter, TheProgramsRatesWin) {
  const Tool tool{
      .number = 1, .infeed = mm_per_s(50), .retract = {}, .speed = rpm(65'000), .max_hits = {}};
  EXPECT_THAT(write_out({take(tool), drill(1, 1, 2)}).text,
              HasSubstr("S65000 M3\nG0 Z5\nG81 X1 Y2 Z-1.8 R5 F3000\n"));
  EXPECT_THAT(write_out({take(1), ToolRate{1, mm_per_s(10), {}}, drill(1, 1, 2)}).text,
              HasSubstr("F600\n"));
}

TEST(GcodeWriter, AKnownRetractRateNeedsMovesOfItsOwn) {
  GcodeSetting setting = on_the_board();
  setting.approach_z = mm(1);
  setting.usual.retract = mm_per_s(100);
  EXPECT_EQ(write_out({take(1), drill(1, 1, 2), drill(1, 3, 2)}, setting).text,
            "T1 M6 ; 1 mm\nS30000 M3\nG0 Z5\n"
            "G0 X1 Y2\nG0 Z1\nG1 Z-1.8 F1200\nG1 Z5 F6000\n"
            "G0 X3 Y2\nG0 Z1\nG1 Z-1.8 F1200\nG1 Z5 F6000\n"
            "M5\nM2\n");
}

TEST(GcodeWriter, PecksWithStatedStrokes) {
  GcodeSetting setting = on_the_board();
  setting.usual.peck = mm(0.4);
  const Written written = write_out({take(1),
                                     function(FunctionKind::PeckOn, "M62"),
                                     drill(1, 1, 2),
                                     function(FunctionKind::PeckOff, "M63"),
                                     drill(1, 3, 2),
                                     function(FunctionKind::PulseOn, "G89"),
                                     drill(1, 4, 2)},
                                    setting);
  EXPECT_THAT(written.text,
              HasSubstr("G83 X1 Y2 Z-1.8 R5 Q0.4 F1200\nG81 X3 Y2 Z-1.8 R5\nG73 X4 Y2 Z-1.8 R5 "
                        "Q0.4\nG80\n"));
  EXPECT_THAT(written.losses, IsEmpty());
  const Written without =
      write_out({take(1), function(FunctionKind::PeckOn, "G81I1.J0.5"), drill(1, 1, 2)});
  EXPECT_THAT(without.text, HasSubstr("G81 X1 Y2 Z-1.8 R5 F1200\n"));
  EXPECT_THAT(
      without.losses,
      ElementsAre(HasSubstr("\"G81I1.J0.5\""), AllOf(HasSubstr("T1"), HasSubstr("peck_mm"))));
}

TEST(GcodeWriter, NamesPecksThatAreLostWithARetractRateToo) {
  const Tool tool{.number = 1, .retract = mm_per_s(50)};
  const Written written =
      write_out({take(tool), function(FunctionKind::PeckOn, "M62"), drill(1, 1, 2)});
  EXPECT_THAT(written.losses, testing::Contains(AllOf(HasSubstr("T1"), HasSubstr("peck_mm"))));
}

// --- depths ------------------------------------------------------------------------------------

TEST(GcodeWriter, OneZDoesForAxesOverOneSurface) {
  DepthOfCut cut = below(0.4, 1.6);
  cut.other_surfaces = {mm(1.9)};
  EXPECT_THAT(write_out({take(1), drill_at(1, 2, cut)}, on_the_table(), sieb_meyer_info()).failure,
              HasSubstr("300 um"));
}

TEST(GcodeWriter, NoDepthEndsInTheTable) {
  EXPECT_THAT(
      write_out({take(1), drill_at(1, 2, below(5, 1.65))}, on_the_table(), sieb_meyer_info())
          .failure,
      HasSubstr("error[translation-refused]"));
}

TEST(GcodeWriter, OffsetsOfToolsComeToPlanes) {
  // CNC-7 manual, Depth Offset: below the mean depth if negative.
  const Tool deeper{.number = 1, .depth_offset = mm(-0.025)};
  EXPECT_THAT(write_out({take(deeper), drill(1, 1, 2)}).text, HasSubstr("Z-1.825 R5"));
  // SIEB & MEYER: addend to the absolute working plane, not to depths below the surface.
  const Tool higher{.number = 1, .depth_offset = mm(0.01)};
  const Written written =
      write_out({take(higher), drill_at(1, 2, z(0.3)), drill_at(1, 3, below(0.5, 1.6))},
                on_the_table(),
                sieb_meyer_info());
  EXPECT_THAT(written.text, HasSubstr("G81 X1 Y2 Z0.31 R5 F1200\nG81 X1 Y3 Z1.1 R5\n"));
}

TEST(GcodeWriter, PlanesAndSurfacesCountFromTheTable) {
  GcodeSetting setting = on_the_table();
  setting.table_z = mm(-1.6);
  const Written written =
      write_out({take(1), drill_at(1, 2, z(0.3)), drill_at(1, 3, below(0.5, 1.65))}, setting);
  EXPECT_THAT(written.text, HasSubstr("G81 X1 Y2 Z-1.3 R5 F1200\nG81 X1 Y3 Z-0.45 R5\n"));
  EXPECT_THAT(write_out({take(1), drill_at(1, 2, z(0.3))}).failure,
              HasSubstr("p.exc:11: error[translation-refused]"));
}

TEST(GcodeWriter, AnUnmeasuredSurfaceHasToBeStated) {
  EXPECT_THAT(write_out({take(1), drill_at(1, 2, below(0.5))}, on_the_table()).failure,
              AllOf(HasSubstr("error[translation-refused]"), HasSubstr("board_z_mm")));
  GcodeSetting setting = on_the_table();
  setting.board_z = mm(1.5);
  EXPECT_THAT(write_out({take(1), drill_at(1, 2, below(0.5))}, setting).text,
              HasSubstr("G81 X1 Y2 Z1 R5"));
}

TEST(GcodeWriter, RapidMovesStayAboveTheBoard) {
  GcodeSetting setting = on_the_table();
  setting.approach_z = mm(2);
  EXPECT_THAT(write_out({take(1), drill_at(1, 2, below(0.5, 2))}, setting).failure,
              AllOf(HasSubstr("Z2.0000"), HasSubstr("T1"), HasSubstr("approach_z_mm")));
  EXPECT_EQ(write_out({take(1), drill_at(1, 2, below(0.5, 1.999))}, setting).failure, "");
  EXPECT_THAT(write_out({take(1), drill_at(1, 2, z(2))}, setting).failure,
              AllOf(HasSubstr("T1"), HasSubstr("Z2.0000")));
}

TEST(GcodeWriter, RowsOfToolsGoBeforeWhatIsUsual) {
  GcodeSetting setting = on_the_board();
  GcodeTool row;
  row.drill = mm(2.5);
  row.work.drill_z = mm(-2.2);
  setting.tools.push_back(row);
  EXPECT_THAT(write_out({take(1), drill(1, 1, 2), take(2), drill(2, 3, 4)}, setting).text,
              testing::AllOf(HasSubstr("G81 X1 Y2 Z-1.8"), HasSubstr("G81 X3 Y4 Z-2.2")));
}

TEST(GcodeWriter, WhatNobodyStatesIsRefusedOnce) {
  GcodeSetting setting;
  setting.safe_z = mm(5);
  const Written written = write_out({take(1), drill(1, 1, 2), drill(1, 3, 4)}, setting);
  EXPECT_THAT(written.failure, HasSubstr("p.exc:11: error[translation-refused]"));
  EXPECT_THAT(
      written.losses,
      ElementsAre(
          AllOf(HasSubstr("T1"), HasSubstr("drill_z_mm")), HasSubstr("T1"), HasSubstr("T1")));
  setting = on_the_board();
  Rout rout = rout_line(2, 3, 0);
  rout.feed_is_default = true;
  const std::vector<What> contour = {take(2), rapid_move(1, 0), plunge(), rout, Retract{}};
  EXPECT_THAT(write_out(contour, setting, sieb_meyer_info()).failure, HasSubstr("T2"));
  EXPECT_EQ(write_out(contour, setting).failure, "");  // the CNC-7 has a default
  setting.usual.feed = mm_per_s(5);
  EXPECT_THAT(write_out(contour, setting).text, HasSubstr("G1 X3 Y0 F300\n"));
}

// --- places ------------------------------------------------------------------------------------

TEST(GcodeWriter, AMovedWorkZeroIsInTheCoordinates) {
  Drill moved = drill(1, 1, 2);
  moved.actual = position_mm<frame::Machine>(111, 222);
  const ZeroSet zero{displacement_mm<frame::Machine>(10, 20),
                     position_mm<frame::Machine>(110, 220)};
  EXPECT_THAT(write_out({take(1), zero, moved}).text, HasSubstr("G81 X11 Y22 Z"));
}

TEST(GcodeWriter, WorkZeroCountsFromAbsoluteZero) {
  const auto text_of = [](const ProgramWriterOptions& options, const Eigen::Vector2d& zero_mm) {
    const auto moved = [&](PlacedPoint& point) {
      point.actual = position_mm<frame::Machine>(zero_mm + point.commanded.in_mm());
    };
    Drill hole = drill(1, 10, 20);
    RapidMove start = rapid_move(30, 0);
    Rout arc = rout_arc(RoutKind::Clockwise, 1, 50, 0, 40, 0);
    moved(hole);
    moved(start);
    moved(arc);
    arc.center = position_mm<frame::Machine>(zero_mm + Eigen::Vector2d(40, 0));
    StringSink bytes;
    GcodeWriter writer(bytes, options, on_the_board());
    writer.begin(metric_info());
    put_all(writer, {take(1), hole, start, Plunge{}, arc});
    EXPECT_TRUE(writer.finish());
    return bytes.text();
  };
  const auto work_zero = position_mm<frame::Machine>(100, 50);
  const std::string text =
      text_of({.absolute_zero = position_mm<frame::Machine>(-1000, 20), .work_zero = work_zero},
              {-900, 70});
  EXPECT_THAT(text, HasSubstr("G81 X10 Y20 Z"));
  EXPECT_THAT(text, HasSubstr("G2 X50 Y0 I10 J0"));
  EXPECT_EQ(text, text_of({.work_zero = work_zero}, {100, 50}));
}

TEST(GcodeWriter, CoordinatesArePlainNumbers) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {nan, std::numeric_limits<double>::infinity(), 1e12}) {
    const Written written = write_out({take(1), drill(1, bad, 0)});
    EXPECT_THAT(written.failure, HasSubstr("error[internal]"));
    EXPECT_EQ(written.text, "");
    EXPECT_THAT(write_out({take(1), drill_at(0, 0, z(bad))}, on_the_table()).failure,
                Not(IsEmpty()));
  }
  EXPECT_THAT(write_out({take(1), drill(1, -1e-9, 1.23456789)}).text,
              HasSubstr("G81 X0 Y1.234568 "));
}

// --- stops and texts ---------------------------------------------------------------------------

TEST(GcodeWriter, NobodyReachesUnderATurningSpindle) {
  GcodeSetting setting = on_the_board();
  setting.change_z = mm(40);
  Stop stop{StopKind::Inspection, {}, position_mm<frame::Machine>(100, 500)};
  EXPECT_EQ(write_out({take(1),
                       drill(1, 1, 2),
                       stop,
                       drill(1, 3, 2),
                       Stop{StopKind::Optional, {}, {}},
                       take(2),
                       drill(2, 5, 2)},
                      setting)
                .text,
            "T1 M6 ; 1 mm\nS30000 M3\nG0 Z5\nG81 X1 Y2 Z-1.8 R5 F1200\nG80\n"
            "G0 Z40\nM5\nG0 X0 Y300\nM0\n"
            "S30000 M3\nG0 Z5\nG81 X3 Y2 Z-1.8 R5\nG80\n"
            "G0 Z40\nM5\nM1\n"
            "T2 M6 ; 2.5 mm\nS30000 M3\nG0 Z5\nG81 X5 Y2 Z-1.8 R5\nG80\n"
            "G0 Z40\nM5\nM2\n");
}

TEST(GcodeWriter, MessagesCannotEndTheirComment) {
  EXPECT_EQ(write_out({Message{"GO) M3 (\xe4\r"}}).text,
            "(MSG, GO] M3 [?"
            "?)\nM0\nM2\n");
  EXPECT_EQ(write_out({Message{"one\ntwo", true}}).text, "(MSG, one)\n(MSG, two)\nM0\nM2\n");
  const std::string endless(500, 'x');
  const std::string text = write_out({Message{endless}}).text;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    EXPECT_LT(end - at, 250u);
    at = end + 1;
  }
  EXPECT_THAT(write_out({Message{"&P!WAIT"}}, on_the_board(), sieb_meyer_info()).text,
              HasSubstr("(MSG, WAIT)\n"));
}

TEST(GcodeWriter, CommentsSayWhatMadeIt) {
  StringSink bytes;
  GcodeWriter writer(
      bytes, {.comments = {"made by (us)\n", std::string(300, 'c')}}, on_the_board());
  writer.begin(metric_info());
  ASSERT_TRUE(writer.finish());
  EXPECT_EQ(bytes.text(),
            "; made by (us)?\n; " + std::string(200, 'c') + "\n; " + std::string(100, 'c') + "\n" +
                kModes + "M2\n");
}

TEST(GcodeWriter, AUsedUpToolIsChanged) {
  Function next = function(FunctionKind::ToolExpired, "");
  next.tool = 1;
  next.next_tool = 2;
  EXPECT_THAT(write_out({take(1), drill(1, 1, 2), next, drill(1, 3, 2)}).text,
              HasSubstr("G80\nM5\nT2 M6 ; 2.5 mm\nS30000 M3\nG0 Z5\nG81 X3 Y2"));
  next.next_tool.reset();
  EXPECT_THAT(
      write_out({take(1), drill(1, 1, 2), next, drill(1, 3, 2)}).text,
      HasSubstr("G80\nM5\n(MSG, T1 is used up: a fresh one)\nM0\nS30000 M3\nG0 Z5\nG81 X3"));
}

TEST(GcodeWriter, PutsTheToolAwayAndWaits) {
  EXPECT_EQ(write_out({take(1), drill(1, 1, 2), Dwell{seconds(1.5)}, take(Tool{})}).text,
            "T1 M6 ; 1 mm\nS30000 M3\nG0 Z5\nG81 X1 Y2 Z-1.8 R5 F1200\nG80\nG4 P1.5\nM5\nT0 M6\n"
            "M2\n");
}

// --- what has no form --------------------------------------------------------------------------

TEST(GcodeWriter, NamesWhatItLeavesOut) {
  const Written written = write_out({Setting{"ATC,ON", SettingKind::Header},
                                     Setting{"METRIC,LZ", SettingKind::Header},
                                     function(FunctionKind::ToolTipCheck, "M18"),
                                     function(FunctionKind::ScalingOn, ""),
                                     Autocalibration{}});
  EXPECT_EQ(written.failure, "");
  EXPECT_THAT(written.losses,
              ElementsAre(AllOf(HasSubstr("warning[translation-loss]"), HasSubstr("\"ATC,ON\"")),
                          HasSubstr("\"M18\""),
                          HasSubstr("calibration")));
  EXPECT_THAT(write_out({Setting{"M49,PRGM,C"}, Setting{"M49,FV3"}, Setting{"H5.000"}},
                        on_the_board(),
                        sieb_meyer_info())
                  .losses,
              ElementsAre(HasSubstr("\"M49,PRGM,C\""), HasSubstr("\"H5.000\"")));
}

TEST(GcodeWriter, RefusesWhatWouldCutElsewhere) {
  const auto refusal = [](const std::vector<What>& operations) {
    return write_out(operations).failure;
  };
  const std::string refused = "error[translation-refused]";
  EXPECT_THAT(refusal({Compensation{CompensationSide::Left, mm(1)}}), HasSubstr(refused));
  EXPECT_EQ(refusal({Compensation{}}), "");
  EXPECT_THAT(refusal({take(2), rapid_move(0, 0), Plunge{2, PlungeKind::Contouring, {}, {}}}),
              AllOf(HasSubstr(refused), HasSubstr("M14")));
  EXPECT_THAT(refusal({Slot{}}), HasSubstr("--slots expand"));
  EXPECT_THAT(refusal({StepSlot{}}), HasSubstr("--slots expand"));
  EXPECT_THAT(refusal({Setting{"DN,1.5", SettingKind::Header}}),
              AllOf(HasSubstr(refused), HasSubstr("\"DN,1.5\"")));
  EXPECT_THAT(refusal({function(FunctionKind::ScalingOn, "M60")}),
              AllOf(HasSubstr(refused), HasSubstr("M60")));
  EXPECT_THAT(refusal({PatternBegin{}}), HasSubstr("error[internal]"));
  EXPECT_THAT(refusal({take(2), rapid_move(0, 0), rout_line(2, 1, 0)}),
              HasSubstr("error[internal]"));
  EXPECT_THAT(refusal({take(2), rapid_move(0, 0), plunge(), Message{"LOOK"}, rout_line(2, 1, 0)}),
              HasSubstr(refused));
  EXPECT_THAT(refusal({take(2), plunge()}), HasSubstr("error[internal]"));
}

}  // namespace
}  // namespace panelcal
