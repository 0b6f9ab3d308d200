// SPDX-License-Identifier: Apache-2.0
#include "program/writers/jsonl_writer.h"

#include <array>

#include "tests/program/operations.h"

namespace panelcal {
namespace {

using namespace test;

std::string line_of(const What& what) {
  return written<JsonlWriter>({what}, metric_info());
}

TEST(JsonlWriter, WritesToolsAndHoles) {
  EXPECT_EQ(line_of(ToolChange{{.number = 3,
                                .diameter = mm(0.8),
                                .infeed = mm_per_s(60),
                                .retract = mm_per_s(200),
                                .speed = rpm(68000),
                                .max_hits = 1500,
                                .depth_offset = mm(-0.1)},
                               2}),
            R"({"op":"tool","line":10,"tool":3,"diameter":0.8,"feed":60,"retract":200,)"
            R"("speed":68000,"max_hits":1500,"depth_offset":-0.1,"compensation_index":2})"
            "\n");
  EXPECT_EQ(line_of(ToolChange{}), "{\"op\":\"tool\",\"line\":10,\"tool\":0}\n");
  EXPECT_EQ(line_of(drill(1, 5, 7)),
            R"({"op":"drill","line":10,"tool":1,"nominal":[4.75,6.5],"actual":[105,207],)"
            R"("sigma":[0.002,0.003]})"
            "\n");
}

TEST(JsonlWriter, WritesRouts) {
  EXPECT_EQ(line_of(rapid_move(5, 7)),
            R"({"op":"position","line":10,"nominal":[4.75,6.5],"actual":[105,207],)"
            R"("sigma":[0.002,0.003]})"
            "\n");
  EXPECT_EQ(line_of(rout_line(2, 5, 7)),
            R"({"op":"rout","line":10,"tool":2,"kind":"line","nominal":[4.75,6.5],)"
            R"("actual":[105,207],"feed":20,"sigma":[0.002,0.003]})"
            "\n");
  EXPECT_EQ(line_of(rout_arc(RoutKind::Clockwise, 2, 5, 7, 4, 6)),
            R"({"op":"rout","line":10,"tool":2,"kind":"cw","nominal":[4.75,6.5],)"
            R"("actual":[105,207],"center":[104,206],"feed":20,"sigma":[0.002,0.003]})"
            "\n");
  EXPECT_THAT(line_of(rout_arc(RoutKind::Counterclockwise, 2, 5, 7, 4, 6)),
              ::testing::HasSubstr(R"("kind":"ccw")"));
}

TEST(JsonlWriter, WritesPlungesAndCompensation) {
  EXPECT_EQ(line_of(Plunge{2}), "{\"op\":\"plunge\",\"line\":10,\"tool\":2,\"kind\":\"plain\"}\n");
  EXPECT_EQ(line_of(Plunge{2, PlungeKind::Contouring, mm(0.2)}),
            R"({"op":"plunge","line":10,"tool":2,"kind":"contouring","depth_offset":0.2})"
            "\n");
  EXPECT_EQ(line_of(Retract{true}), "{\"op\":\"retract\",\"line\":10,\"kind\":\"clamping\"}\n");
  EXPECT_EQ(line_of(Retract{}), "{\"op\":\"retract\",\"line\":10,\"kind\":\"free\"}\n");
  EXPECT_EQ(line_of(Compensation{}), "{\"op\":\"compensation\",\"line\":10,\"side\":\"off\"}\n");
  EXPECT_EQ(line_of(Compensation{CompensationSide::Left, mm(2.4)}),
            R"({"op":"compensation","line":10,"side":"left","value":2.4})"
            "\n");
  EXPECT_EQ(line_of(Compensation{CompensationSide::Right, {}}),
            "{\"op\":\"compensation\",\"line\":10,\"side\":\"right\"}\n");
}

TEST(JsonlWriter, WritesSlots) {
  EXPECT_EQ(line_of(Slot{1, place(5, 7), place(9, 7)}),
            R"({"op":"slot","line":10,"tool":1,"nominal":[4.75,6.5],"actual":[105,207],)"
            R"("sigma":[0.002,0.003],"nominal_end":[8.75,6.5],"actual_end":[109,207],)"
            R"("sigma_end":[0.002,0.003]})"
            "\n");
  EXPECT_EQ(line_of(StepSlot{1, place(5, 7), place(9, 7), mm(5), mm(-2.5), mm_per_s(40)}),
            R"({"op":"step_slot","line":10,"tool":1,"nominal":[4.75,6.5],"actual":[105,207],)"
            R"("sigma":[0.002,0.003],"nominal_end":[8.75,6.5],"actual_end":[109,207],)"
            R"("sigma_end":[0.002,0.003],"initial_depth":5,"increment":-2.5,"feed":40})"
            "\n");
}

TEST(JsonlWriter, WritesTheRiskWhereThereIsOne) {
  Drill hole = drill(1, 5, 7);
  hole.risk = 0.25;
  EXPECT_THAT(line_of(hole), ::testing::HasSubstr(R"("sigma":[0.002,0.003],"risk":0.25})"));
  Slot slot{1, place(0, 0), place(1, 0), {}};
  slot.start.risk = 1e-12;
  slot.end.risk = 0;
  EXPECT_THAT(line_of(slot), ::testing::HasSubstr(R"(,"risk":1e-12,)"));
  EXPECT_THAT(line_of(slot), ::testing::HasSubstr(R"(,"risk_end":0)"));
  // A move with the tool up breaks nothing.
  RapidMove move = rapid_move(5, 7);
  move.risk = 0.25;
  EXPECT_THAT(line_of(move), ::testing::Not(::testing::HasSubstr("risk")));
}

TEST(JsonlWriter, WritesRatesAndAutocalibrations) {
  EXPECT_EQ(line_of(ToolRate{2, mm_per_s(60), {}}),
            "{\"op\":\"rate\",\"line\":10,\"tool\":2,\"feed\":60}\n");
  EXPECT_EQ(line_of(ToolRate{2, {}, mm_per_s(300)}),
            "{\"op\":\"rate\",\"line\":10,\"tool\":2,\"retract\":300}\n");
  EXPECT_EQ(line_of(Autocalibration{position_mm<frame::Nominal>(1, 2),
                                    displacement_mm<frame::Machine>(1, 2),
                                    position_mm<frame::Machine>(101, 202)}),
            R"({"op":"autocalibration","line":10,"nominal":[1,2],"actual":[101,202]})"
            "\n");
}

TEST(JsonlWriter, WritesStopsAndTexts) {
  EXPECT_EQ(line_of(Stop{}), "{\"op\":\"stop\",\"line\":10,\"kind\":\"end_rewind\"}\n");
  EXPECT_EQ(line_of(Stop{StopKind::Inspection,
                         displacement_mm<frame::Machine>(1, 2),
                         position_mm<frame::Machine>(11, 12)}),
            R"({"op":"stop","line":10,"kind":"inspection","actual":[11,12]})"
            "\n");
  EXPECT_THAT(line_of(Stop{.kind = StopKind::Optional}), ::testing::HasSubstr("\"optional\""));
  EXPECT_THAT(line_of(Stop{.kind = StopKind::EndNoRewind}), ::testing::HasSubstr("\"end\""));
  EXPECT_THAT(line_of(Stop{.kind = StopKind::EndAccepted}),
              ::testing::HasSubstr("\"end_accepted\""));
  EXPECT_THAT(line_of(Stop{.kind = StopKind::HeaderEnd}), ::testing::HasSubstr("\"header_end\""));
  EXPECT_EQ(line_of(Message{"TURN \"IT\""}),
            R"({"op":"message","line":10,"text":"TURN \"IT\""})"
            "\n");
  EXPECT_EQ(line_of(Message{"FIRST\nSECOND", true}),
            R"({"op":"message","line":10,"text":"FIRST\u000aSECOND","long":true})"
            "\n");
  EXPECT_EQ(line_of(Dwell{seconds(2.5)}), "{\"op\":\"dwell\",\"line\":10,\"time\":2.5}\n");
  EXPECT_EQ(line_of(Setting{"VER,1", SettingKind::Header}),
            "{\"op\":\"setting\",\"line\":10,\"text\":\"VER,1\"}\n");
  EXPECT_EQ(line_of(Setting{"DN,.05", SettingKind::Body, LengthUnit::Inch}),
            "{\"op\":\"setting\",\"line\":10,\"text\":\"DN,.05\",\"unit\":\"inch\"}\n");
  EXPECT_EQ(
      line_of(ZeroSet{displacement_mm<frame::Machine>(1, 2), position_mm<frame::Machine>(3, 4)}),
      R"({"op":"zero_set","line":10,"zero_set":[1,2],"work_zero":[3,4]})"
      "\n");
}

TEST(JsonlWriter, WritesFunctions) {
  EXPECT_EQ(line_of(function(FunctionKind::SpindleGroup, "M96,2")),
            R"({"op":"function","line":10,"kind":"spindle_group","text":"M96,2"})"
            "\n");
  Function expired = function(FunctionKind::ToolExpired, {});
  expired.tool = 1;
  EXPECT_EQ(line_of(expired),
            R"({"op":"function","line":10,"kind":"tool_expired","tool":1})"
            "\n");
  expired.next_tool = 5;
  EXPECT_EQ(line_of(expired),
            R"({"op":"function","line":10,"kind":"tool_expired","tool":1,"next_tool":5})"
            "\n");
}

TEST(JsonlWriter, NamesTheStoredPatternAndTheInstance) {
  StringSink bytes;
  JsonlWriter writer(bytes);
  const std::array<int, 2> path = {0, 2};
  writer.put({3, path, Retract{}, "logo.pat", nullptr});
  ASSERT_TRUE(writer.finish());
  EXPECT_EQ(bytes.text(),
            R"({"op":"retract","line":3,"file":"logo.pat","kind":"free","path":[0,2]})"
            "\n");
}

}  // namespace
}  // namespace panelcal
