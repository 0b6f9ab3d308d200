// SPDX-License-Identifier: Apache-2.0
#include "program/writers/excellon/writer.h"

#include <algorithm>
#include <cmath>

#include "program/model/placement.h"

#include "tests/program/operations.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using namespace test;

const std::string kMetricHeader = "M48\nFMAT,2\nMETRIC,LZ\nT1C1.0\nT2C2.5\nM95\nG90\nG05\n";

bool is_end(const What& operation) {
  const auto* stop = std::get_if<Stop>(&operation);
  return stop != nullptr && name(stop->kind).starts_with("end");
}

/// Without the M30 that ends operations without an end.
std::string program_of(const std::vector<What>& operations,
                       const ProgramInfo& info = metric_info()) {
  std::string text = written<ExcellonWriter>(operations, info, ProgramWriterOptions{});
  if (std::ranges::any_of(operations, is_end)) return text;
  constexpr std::string_view kEnd = "M30\n";
  EXPECT_TRUE(text.ends_with(kEnd)) << text;
  return text.substr(0, text.size() - std::min(kEnd.size(), text.size()));
}

/// Text behind the header of a metric program.
std::string body_of(const std::vector<What>& operations) {
  const std::string text = program_of(operations);
  EXPECT_TRUE(text.starts_with(kMetricHeader)) << text;
  return text.substr(std::min(kMetricHeader.size(), text.size()));
}

std::string body_in_version(int version, const std::vector<What>& operations) {
  ProgramInfo info = metric_info();
  info.axis_version = version;
  return program_of(operations, info).substr(kMetricHeader.size());
}

ProgramInfo inch_info() {
  ProgramInfo info;
  info.file = "p.exc";
  return info;
}

std::string why_not(const std::vector<What>& operations) {
  StringSink bytes;
  ExcellonWriter writer(bytes, {});
  writer.begin(metric_info());
  put_all(writer, operations);
  const Expected<void> done = writer.finish();
  EXPECT_EQ(bytes.text(), "");
  return done ? "" : test::brief(done.error());
}

// --- header ------------------------------------------------------------------------------------

TEST(ExcellonWriter, WritesADrillingProgram) {
  const std::string text =
      written<ExcellonWriter>({Setting{"ATC,ON", SettingKind::Header},
                               Setting{"VER,1", SettingKind::Header},
                               Stop{.kind = StopKind::HeaderEnd},
                               ToolChange{{.number = 1, .diameter = mm(1)}, {}},
                               drill(1, 1.5, -2),
                               Stop{}},
                              metric_info(),
                              ProgramWriterOptions{.comments = {"made by\nhand"}});
  EXPECT_EQ(text,
            "M48\n;made by?hand\nFMAT,2\nMETRIC,LZ\nATC,ON\nVER,1\nT1C1.0\nT2C2.5\n%\nG90\nG05\n"
            "T1\nX1.5Y-2.0\nM30\n");
}

TEST(ExcellonWriter, ClosesTheHeaderByM95UnlessTheSourceStopsThere) {
  EXPECT_EQ(program_of({}), kMetricHeader);
  EXPECT_EQ(program_of({Stop{}}), kMetricHeader + "M30\n");
  EXPECT_EQ(program_of({Stop{.kind = StopKind::EndNoRewind}}), kMetricHeader + "M00\n");
  EXPECT_EQ(body_of({drill(1, 1, 2), Stop{.kind = StopKind::HeaderEnd}}), "X1.0Y2.0\nM09\n");
}

TEST(ExcellonWriter, SaysThatTheSourceHasNoEnd) {
  EXPECT_EQ(body_of({drill(1, 1, 2), Stop{.kind = StopKind::EndAccepted}}),
            "X1.0Y2.0\n;the source has no M30: accepted by --accept-unterminated\nM30\n");
}

TEST(ExcellonWriter, WritesAHeadersZeroSetBehindTheHeader) {
  const ZeroSet zero{displacement_mm<frame::Machine>(1, 2), position_mm<frame::Machine>(1, 2)};
  const std::string expected =
      "M48\nFMAT,2\nMETRIC,LZ\nATC,ON\nT1C1.0\nT2C2.5\n%\nG90\nG05\nG93X1.0Y2.0\nX1.0Y2.0\n";
  const Setting atc{"ATC,ON", SettingKind::Header};
  const Stop stop{.kind = StopKind::HeaderEnd};
  EXPECT_EQ(program_of({zero, atc, stop, drill(1, 1, 2)}), expected);
  EXPECT_EQ(program_of({atc, stop, zero, drill(1, 1, 2)}), expected);
  EXPECT_EQ(body_of({zero, drill(1, 1, 2)}), "G93X1.0Y2.0\nX1.0Y2.0\n");
}

TEST(ExcellonWriter, StatesItsOwnFormatAndModes) {
  std::vector<What> settings;
  for (const char* text :
       {"FMAT,1", "METRIC,TZ", "INCH", "ICI,ON", "OM48", "OM48,ON", "BLKD,OFF"}) {
    settings.emplace_back(Setting{text, SettingKind::Header});
  }
  for (const char* text : {"G05", "G90", "G91", "M71", "M72"}) settings.emplace_back(Setting{text});
  settings.emplace_back(Setting{"$uvis,lamp,1", SettingKind::Vision});
  EXPECT_EQ(program_of(settings), kMetricHeader);
  EXPECT_EQ(body_of({Dwell{seconds(1)}, Setting{"1/5/6"}, Setting{"/"}}), "G04X001\n1/5/6\n/\n");
  EXPECT_THAT(program_of({Setting{"CP,1,.094", SettingKind::Header}}),
              ::testing::HasSubstr("LZ\nCP,1,.094\nT1"));
}

TEST(ExcellonWriter, SettingsKeepTheSourcesDigits) {
  ProgramInfo info = metric_info();
  info.format.zeros = Zeros::TrailingKept;
  EXPECT_THAT(program_of({}, info), ::testing::HasSubstr("\nMETRIC,TZ\n"));
  info.format.integer_digits = 4;
  info.format.decimal_digits = 2;
  EXPECT_THAT(program_of({}, info), ::testing::HasSubstr("\nMETRIC,TZ,0000.00\n"));
}

/// DN,0002 is 2 mm in 0000.000 and 0.2 mm in the output's 000.000, digits counted from the left.
TEST(ExcellonWriter, WritesBareLengthsInDigitsThatItDoesNotStateWithPoints) {
  const auto written = [](Zeros zeros, int n_whole, int n_decimals, const char* setting) {
    ProgramInfo info = metric_info();
    info.format.zeros = zeros;
    info.format.integer_digits = n_whole;
    info.format.decimal_digits = n_decimals;
    StringSink bytes;
    ExcellonWriter writer(bytes, {});
    writer.begin(info);
    put_all(writer, {Setting{setting, SettingKind::Header}});
    const Expected<void> done = writer.finish();
    EXPECT_TRUE(done) << setting << ": " << test::brief(done.error());
    return bytes.text();
  };
  using testing::HasSubstr;
  EXPECT_THAT(written(Zeros::LeadingKept, 4, 3, "DN,0002"), HasSubstr("\nDN,2.0\n"));
  EXPECT_THAT(written(Zeros::LeadingKept, 4, 3, "Z-0002"), HasSubstr("\nZ-2.0\n"));
  EXPECT_THAT(written(Zeros::TrailingKept, 3, 4, "DN,0002"), HasSubstr("\nDN,0.0002\n"));
  EXPECT_THAT(written(Zeros::LeadingKept, 4, 3, "DN,2."), HasSubstr("\nDN,2.\n"));
  EXPECT_THAT(written(Zeros::LeadingKept, 4, 3, "ATC,ON"), HasSubstr("\nATC,ON\n"));
  EXPECT_THAT(written(Zeros::LeadingKept, 3, 3, "DN,002"), HasSubstr("\nDN,002\n"));
  EXPECT_THAT(written(Zeros::TrailingKept, 4, 3, "DN,2000"), HasSubstr("\nDN,2000\n"));
  // The output states 0000.00.
  EXPECT_THAT(written(Zeros::LeadingKept, 4, 2, "DN,0002"), HasSubstr("\nDN,0002\n"));
}

// --- tools -------------------------------------------------------------------------------------

TEST(ExcellonWriter, RepeatsToolDataThatTheHeaderLacks) {
  EXPECT_EQ(body_of({ToolChange{{.number = 1, .diameter = mm(1)}, {}},
                     ToolChange{{.number = 1, .diameter = mm(1)}, 5},
                     ToolChange{{.number = 3,
                                 .diameter = mm(0.8),
                                 .infeed = mm_per_s(7),
                                 .retract = mm_per_s(200),
                                 .speed = rpm(60500),
                                 .max_hits = 20,
                                 .depth_offset = mm(-0.1)},
                                {}},
                     ToolChange{}}),
            "T1\nT0105\nT3C0.8F007S60.5B0200H20Z-0.1\nT0\n");
}

TEST(ExcellonWriter, RefusesDataThatTheHeaderWouldOverrule) {
  EXPECT_EQ(why_not({ToolChange{{.number = 1, .diameter = mm(1.1)}, {}}}),
            "p.exc:10: error[not-supported]");
}

// --- drilling ----------------------------------------------------------------------------------

/// "Inch coordinates are in six digits (00.0000)."
TEST(ExcellonWriter, InchCoordinatesHaveFourDecimals) {
  EXPECT_THAT(program_of({drill(1, 123.4567891, 25.4 / 3)}, inch_info()),
              ::testing::EndsWith("\nX4.8605Y0.3333\n"));
  EXPECT_THAT(program_of({drill(1, 25.4, -2.54)}, inch_info()),
              ::testing::EndsWith("\nX1.0Y-0.1\n"));
}

TEST(ExcellonWriter, CoordinatesAreGoodToANanometreWhereThatIsAskedFor) {
  for (const ProgramInfo& info : {inch_info(), metric_info()}) {
    const double unit_mm = info.format.one_unit().in_mm();
    for (const double x_mm : {123.4567891, 0.0000004, 25.4 / 3}) {
      const std::string text = written<ExcellonWriter>(
          {drill(1, x_mm, 0)}, info, ProgramWriterOptions{.resolution = um(0.001)});
      const double read_mm = unit_mm * std::stod(text.substr(text.rfind('X') + 1));
      EXPECT_NEAR(read_mm, x_mm, 1e-6);
    }
  }
}

/// A header of 10 um digits means that the control reads no more.
TEST(ExcellonWriter, WritesTheDigitsThatTheSourceDeclares) {
  ProgramInfo info = metric_info();
  info.format.integer_digits = 4;
  info.format.decimal_digits = 2;
  EXPECT_THAT(program_of({drill(1, 1234.5678, 1.994)}, info),
              ::testing::EndsWith("\nX1234.57Y1.99\n"));
  info.has_decimal_coordinates = true;
  EXPECT_THAT(program_of({drill(1, 234.5678, 1.9944)}, info),
              ::testing::AllOf(::testing::HasSubstr("\nMETRIC,LZ\n"),
                               ::testing::EndsWith("\nX234.568Y1.994\n")));
}

TEST(ExcellonWriter, AnArcThatBulgesLessThanTheLastDigitIsALine) {
  EXPECT_EQ(body_of({rapid_move(0, 0),
                     rout_arc(RoutKind::Clockwise, 2, 0.05, 0, 0.025, -1),
                     rout_arc(RoutKind::Clockwise, 2, 0.25, 0, 0.15, -1)}),
            "G00X0.0Y0.0\nF020\nG01X0.05Y0.0\nG02X0.25Y0.0I-0.1J1.0\n");
}

TEST(ExcellonWriter, WritesSlotsWhole) {
  EXPECT_EQ(body_of({Slot{1, place(1, 2), place(3, 2)},
                     StepSlot{2, place(5, 6), place(5, 7), mm(0.2), mm(-0.1)},
                     StepSlot{2, place(6, 6), place(6, 7), mm(0.2), mm(-0.1)},
                     Slot{1, place(1, 2), place(3, 2)}}),
            "X1.0Y2.0G85X3.0Y2.0\nX5.0Y6.0G87X5.0Y7.0Z-0.1U0.2\n"
            "X6.0Y6.0G87X6.0Y7.0Z-0.1U0.2\nG05\nX1.0Y2.0G85X3.0Y2.0\n");
}

TEST(ExcellonWriter, LeavesRoutModeBeforeAToolsRate) {
  EXPECT_EQ(body_of({rapid_move(1, 2), ToolRate{1, mm_per_s(60), {}}, drill(1, 3, 4)}),
            "G00X1.0Y2.0\nG05\nF060\nX3.0Y4.0\n");
}

TEST(ExcellonWriter, WritesAnAutocalibrationInItsOwnDigits) {
  EXPECT_EQ(body_of({Autocalibration{
                position_mm<frame::Nominal>(1, 2), displacement_mm<frame::Machine>(1, 2), {}}}),
            "G39X1.0Y2.0\n");
}

TEST(ExcellonWriter, EndsAHitLimitThatItWrote) {
  EXPECT_EQ(body_of({ToolChange{{.number = 4, .max_hits = 20}, {}}, ToolChange{{.number = 4}, {}}}),
            "T4H20\nT4H\n");
}

TEST(ExcellonWriter, TurnsTheMachinesScalingOffWhereItIsDoneAlready) {
  ProgramInfo info = metric_info();
  info.is_scaled = true;
  EXPECT_THAT(program_of({drill(1, 3, 4)}, info), ::testing::HasSubstr("\nG05\nM61\n"));
}

TEST(ExcellonWriter, SwitchesToRoutModeForTheFeedOfAStepSlot) {
  StepSlot slot{2, place(5, 6), place(5, 7), mm(0.2), mm(-0.1), mm_per_s(40)};
  slot.feed_is_default = false;
  EXPECT_EQ(body_of({slot, slot}),
            "G00\nF040\nX5.0Y6.0G87X5.0Y7.0Z-0.1U0.2\nX5.0Y6.0G87X5.0Y7.0Z-0.1U0.2\n");
}

TEST(ExcellonWriter, RefusesAPassOfAStepSlot) {
  EXPECT_EQ(why_not({rapid_move(1, 1), Plunge{2, PlungeKind::Plain, mm(0.1)}}),
            "p.exc:11: error[internal]");
}

// --- routing -----------------------------------------------------------------------------------

TEST(ExcellonWriter, WritesRouts) {
  EXPECT_EQ(body_of({rapid_move(1, 2),
                     Compensation{CompensationSide::Left, mm(2.5)},
                     Plunge{2},
                     rout_line(2, 4, 2),
                     rout_arc(RoutKind::Counterclockwise, 2, 5, 3, 4, 3),
                     rout_arc(RoutKind::Clockwise, 2, 6, 4, 6, 3),
                     Retract{true},
                     rapid_move(8, 8),
                     Compensation{CompensationSide::Right, {}},
                     Plunge{2, PlungeKind::Contouring, {}},
                     rout_line(2, 9, 9),
                     Retract{},
                     Compensation{},
                     drill(1, 0, 0),
                     drill(1, 1, 0)}),
            "G00X1.0Y2.0\nG41\nM15\nF020\nG01X4.0Y2.0\nG03X5.0Y3.0I0.0J-1.0\n"
            "G02X6.0Y4.0I-1.0J0.0\nM16\nG00X8.0Y8.0\nG42\nM14\nG01X9.0Y9.0\nM17\nG40\nG05\n"
            "X0.0Y0.0\nX1.0Y0.0\n");
}

TEST(ExcellonWriter, StatesTheTableFeedWhereItChanges) {
  const auto rout = [](Feed feed) { return rout_line(2, 1, 1, feed); };
  Rout standard = rout(inch_per_min(100));
  standard.feed_is_default = true;
  EXPECT_EQ(body_of({rapid_move(1, 1), Plunge{2}, standard, standard}),
            "G00X1.0Y1.0\nM15\nG01X1.0Y1.0\nG01X1.0Y1.0\n");
  EXPECT_EQ(body_of({rapid_move(1, 1),
                     standard,
                     rout(mm_per_s(7)),
                     rout(mm_per_s(7)),
                     rout(mm_per_s(8)),
                     standard,
                     ToolChange{{.number = 1}, {}},
                     standard}),
            "G00X1.0Y1.0\nG01X1.0Y1.0\nF007\nG01X1.0Y1.0\nG01X1.0Y1.0\nF008\nG01X1.0Y1.0\n"
            "F042\nG01X1.0Y1.0\nT1\nF042\nG01X1.0Y1.0\n");
  EXPECT_EQ(body_of({rapid_move(1, 1),
                     rout(mm_per_s(7)),
                     drill(1, 1, 1),
                     rapid_move(1, 1),
                     rout(mm_per_s(7))}),
            "G00X1.0Y1.0\nF007\nG01X1.0Y1.0\nG05\nX1.0Y1.0\nG00X1.0Y1.0\nF007\nG01X1.0Y1.0\n");
  EXPECT_THAT(program_of({rapid_move(0, 0), rout_line(2, 0, 0, inch_per_min(70))}, inch_info()),
              ::testing::HasSubstr("\nF070\n"));
}

// --- axis versions -----------------------------------------------------------------------------

const std::vector<What> kEveryPoint = {
    ZeroSet{displacement_mm<frame::Machine>(1, 2), position_mm<frame::Machine>(1, 2)},
    drill(1, 3, 4),
    Slot{1, place(1, 2), place(3, 4)},
    rapid_move(3, 4),
    Compensation{CompensationSide::Left, {}},
    rout_arc(RoutKind::Clockwise, 2, 5, 6, 3, 6),
    rout_arc(RoutKind::Counterclockwise, 2, 7, 8, 5, 8),
    Compensation{CompensationSide::Right, {}},
    StepSlot{2, place(1, 2), place(3, 4), mm(0.2), mm(-0.1), mm_per_s(20), false},
    Stop{StopKind::Optional, displacement_mm<frame::Machine>(9, 8), {}}};

TEST(ExcellonWriter, WritesTurnedAxes) {
  // Version 3: x points up, y points left.
  EXPECT_EQ(body_in_version(3, kEveryPoint),
            "G93X2.0Y-1.0\nX4.0Y-3.0\nX2.0Y-1.0G85X4.0Y-3.0\nG00X4.0Y-3.0\nG41\nF020\n"
            "G02X6.0Y-5.0I-2.0J0.0\nG03X8.0Y-7.0I-2.0J0.0\nG42\n"
            "X2.0Y-1.0G87X4.0Y-3.0Z-0.1U0.2\nM06X8.0Y-9.0\n");
}

TEST(ExcellonWriter, MirroredAxesExchangeSenses) {
  // Version 4: x points left, y points up.
  EXPECT_EQ(body_in_version(4, kEveryPoint),
            "G93X-1.0Y2.0\nX-3.0Y4.0\nX-1.0Y2.0G85X-3.0Y4.0\nG00X-3.0Y4.0\nG42\nF020\n"
            "G03X-5.0Y6.0I0.0J-2.0\nG02X-7.0Y8.0I0.0J-2.0\nG41\n"
            "X-1.0Y2.0G87X-3.0Y4.0Z-0.1U0.2\nM06X-9.0Y8.0\n");
}

TEST(ExcellonWriter, EveryVersionLeadsBackToTheSamePlace) {
  for (int version = 1; version <= 8; ++version) {
    const std::string text = body_in_version(version, {drill(1, 3, 4)});
    const Eigen::Vector2d written(std::stod(text.substr(1)),
                                  std::stod(text.substr(text.find('Y') + 1)));
    EXPECT_EQ(Eigen::Vector2d(axis_orientation(version) * written), Eigen::Vector2d(3, 4)) << text;
  }
}

// --- stops and texts ---------------------------------------------------------------------------

TEST(ExcellonWriter, WritesStops) {
  EXPECT_EQ(body_of({Stop{.kind = StopKind::Inspection},
                     Stop{StopKind::Inspection, displacement_mm<frame::Machine>(1, 2), {}},
                     Stop{.kind = StopKind::Optional},
                     Stop{StopKind::EndNoRewind, displacement_mm<frame::Machine>(0, 3), {}}}),
            "M09\nM09X1.0Y2.0\nM06\nM00X0.0Y3.0\n");
}

TEST(ExcellonWriter, WritesMessagesOfOneAndManyLines) {
  EXPECT_EQ(body_of({Message{"HELLO, WORLD"}, Message{"FIRST\nSECOND\nLAST", true}}),
            "M47,HELLO, WORLD\nM45,FIRST\\\nSECOND\\\nLAST\n");
}

TEST(ExcellonWriter, DwellsAMillisecondAnIncrement) {
  EXPECT_EQ(body_of({Dwell{seconds(10)}, Dwell{seconds(1.234)}}), "G04X01\nG04X001234\n");
  ProgramInfo trailing = metric_info();
  trailing.format.zeros = Zeros::TrailingKept;
  EXPECT_THAT(program_of({Dwell{seconds(10)}, Dwell{seconds(2.5)}}, trailing),
              ::testing::EndsWith("\nG04X10000\nG04X2500\n"));
  ProgramInfo five_digits = metric_info();
  five_digits.format.decimal_digits = 2;
  EXPECT_THAT(program_of({Dwell{seconds(2.5)}}, five_digits), ::testing::EndsWith("\nG04X025\n"));
  EXPECT_THAT(program_of({Dwell{seconds(10)}, Dwell{seconds(1.234)}}, inch_info()),
              ::testing::EndsWith("\nG04X01\nG04X001234\n"));
}

TEST(ExcellonWriter, PassesFunctionsOnAsWritten) {
  Function expired = function(FunctionKind::ToolExpired, {});
  expired.tool = 1;
  expired.next_tool = 2;
  EXPECT_EQ(body_of({function(FunctionKind::ToolTipCheck, "M18"),
                     function(FunctionKind::SpindleGroup, "M96,2"),
                     function(FunctionKind::ScalingOn, "M60"),
                     function(FunctionKind::ScalingOff, "M61"),
                     function(FunctionKind::PeckOff, {}),
                     expired,
                     function(FunctionKind::PeckOn, "M62")}),
            "M18\nM96,2\nM60\nM61\nM62\n");
}

}  // namespace
}  // namespace panelcal
