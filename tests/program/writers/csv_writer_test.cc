// SPDX-License-Identifier: Apache-2.0
#include "program/writers/csv_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "calib/base/statistics/random.h"

#include "tests/program/operations.h"

namespace panelcal {
namespace {

using namespace test;
using Row = std::map<std::string, std::string>;

/// Fields of one record (RFC 4180); removes it from `text`.
std::vector<std::string> take_record(std::string& text) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  std::size_t i = 0;
  for (; i < text.size() && (is_quoted || text[i] != '\n'); ++i) {
    if (text[i] == '"') {
      if (is_quoted && i + 1 < text.size() && text[i + 1] == '"') {
        fields.back() += text[i++];
      } else {
        is_quoted = !is_quoted;
      }
    } else if (text[i] == ',' && !is_quoted) {
      fields.emplace_back();
    } else {
      fields.back() += text[i];
    }
  }
  text.erase(0, i + 1);
  return fields;
}

/// The fields that are not empty, by column name.
Row row_of(const What& what) {
  std::string text = written<CsvWriter>({what}, metric_info());
  const std::vector<std::string> names = take_record(text);
  const std::vector<std::string> fields = take_record(text);
  EXPECT_EQ(text, "");
  EXPECT_EQ(fields.size(), names.size());
  Row row;
  for (std::size_t i = 0; i < std::min(names.size(), fields.size()); ++i) {
    if (!fields[i].empty()) row[names[i]] = fields[i];
  }
  return row;
}

TEST(CsvWriter, KeepsTheOrderOfItsColumns) {
  EXPECT_EQ(
      written<CsvWriter>({}, metric_info()),
      "op,line,path,tool,nominal_x,nominal_y,actual_x,actual_y,sigma_x,sigma_y,diameter,feed,"
      "speed,text,kind,center_x,center_y,retract,max_hits,depth_offset,compensation_index,side,"
      "value,nominal_end_x,nominal_end_y,actual_end_x,actual_end_y,sigma_end_x,sigma_end_y,"
      "initial_depth,increment,time,next_tool,long,zero_set_x,zero_set_y,work_zero_x,work_zero_y,"
      "file,z,depth,surface,risk,risk_end,surface_sigma,surface_source,risk_shallow,risk_deep,"
      "reference,control,lower_limit,upper_limit,unit\n");
}

TEST(CsvWriter, WritesAHoleAsOneRow) {
  StringSink bytes;
  CsvWriter writer(bytes);
  const std::array<int, 2> path = {0, 2};
  writer.put({14, path, drill(1, 5, 7), {}, nullptr});
  ASSERT_TRUE(writer.finish());
  EXPECT_EQ(
      bytes.text(),
      "drill,14,0.2,1,4.75,6.5,105,207,0.002,0.003,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,\n");
}

TEST(CsvWriter, WritesHowDeepAHoleIs) {
  StringSink bytes;
  CsvWriter writer(bytes);
  Drill hole = drill(1, 5, 7);
  hole.cut = {.z = {}, .depth = mm(0.4), .surface = mm(3.25), .control = DepthControl::Slm};
  hole.cut.lower_limit = mm(1.5);
  hole.cut.upper_limit = mm(20);
  writer.put({14, {}, hole, {}, nullptr});
  ASSERT_TRUE(writer.finish());
  EXPECT_TRUE(bytes.text().starts_with("drill,14,,1,4.75,6.5,105,207,0.002,0.003,,"));
  EXPECT_TRUE(bytes.text().ends_with(",,0.4,3.25,,,,,,,plane,slm,1.5,20\n")) << bytes.text();
}

TEST(CsvWriter, WritesTheRiskOfAHole) {
  Drill hole = drill(1, 5, 7);
  hole.risk = 1.23456e-7;
  const Row quick = row_of(hole);
  EXPECT_EQ(quick.at("risk"), "1.235e-07");
  hole.cut = {.z = mm(1.5), .depth = std::nullopt, .surface = std::nullopt};
  Row with_depth = row_of(hole);
  EXPECT_EQ(with_depth.at("z"), "1.5");
  with_depth.erase("z");
  EXPECT_EQ(with_depth, quick);
}

/// Texts are the program's own, in its unit.
TEST(CsvWriter, StatesTheUnitOfTextsInInch) {
  const auto unit_of = [](const What& what) {
    const Row row = row_of(what);
    return row.contains("unit") ? row.at("unit") : "";
  };
  constexpr LengthUnit kInch = LengthUnit::Inch;
  for (const char* text : {"DN,.05",
                           "PCKPARAM,1,.1",
                           "CP,1,.05",
                           "ZC,X1.0Y2.0",
                           "Z-.1",
                           "G39X1.Y2.",
                           "$uvis,searcharea,.1",
                           "M49,NIB.01"}) {
    EXPECT_EQ(unit_of(Setting{text, SettingKind::Body, kInch}), "inch") << text;
    EXPECT_EQ(unit_of(Setting{text}), "") << text;
  }
  for (const char* text : {"VER,1", "FMAT,2", "G05", "1/2", "$uvis,lamp,0.5", "R,H", "M49,CAMA"}) {
    EXPECT_EQ(unit_of(Setting{text, SettingKind::Body, kInch}), "") << text;
  }
}

/// The row of a hole, one field after the other.
std::string row_by_fields(int line, const Drill& hole) {
  std::string row = "drill," + std::to_string(line) + ",," + std::to_string(hole.tool);
  const Eigen::Vector2d sigma_mm = hole.cov_mm2.diagonal().cwiseSqrt();
  for (const Eigen::Vector2d& point : {hole.nominal.in_mm(), hole.actual.in_mm(), sigma_mm}) {
    for (const double value : point) {
      row += ',';
      append_fixed(row, value, kMmDecimals);
    }
  }
  row += std::string(33, ',');
  if (hole.risk) append_risk(row, *hole.risk);
  return row + ",,,,,,,,,,\n";
}

/// A coordinate on the grid of most programs, a corrected one, or one of any size.
double draw_mm(Random& random) {
  const double value_mm = random.uniform(-900, 900);
  const double kind = random.uniform();
  if (kind < 0.4) return std::round(value_mm * 1e3) / 1e3;
  if (kind < 0.8) return value_mm;
  return value_mm * std::pow(10.0, random.uniform(-9, 16));
}

TEST(CsvWriter, WritesEveryHoleAsFieldByField) {
  constexpr std::uint64_t kSeed = 20261126;
  Random random(kSeed);
  const auto draw_point_mm = [&random] {
    const double x_mm = draw_mm(random);
    return Eigen::Vector2d(x_mm, draw_mm(random));
  };
  StringSink bytes;
  CsvWriter writer(bytes);
  std::string expected;
  Drill hole = drill(1, 5, 7);
  for (int line = 1; line <= 50'000; ++line) {
    hole.tool = 1 + static_cast<int>(random.uniform(0, 1100));
    hole.nominal = position_mm<frame::Nominal>(draw_point_mm());
    // What is kept from one hole to the next, and what is copied within one, must change in
    // between.
    const bool is_corrected = random.uniform() < 0.5;
    hole.actual =
        position_mm<frame::Machine>(is_corrected ? draw_point_mm() : hole.nominal.in_mm());
    const double change = random.uniform();
    if (change < 0.2) hole.cov_mm2(0, 0) = random.uniform(0, 1e-5);
    if (change > 0.9) hole.cov_mm2(1, 1) = std::pow(draw_mm(random), 2);
    if (change > 0.97) hole.cov_mm2.setZero();
    hole.risk.reset();
    if (random.uniform() < 0.3) hole.risk = std::pow(10.0, random.uniform(-12, 0));
    writer.put({line, {}, hole, {}, nullptr});
    expected += row_by_fields(line, hole);
  }
  ASSERT_TRUE(writer.finish());
  const std::string& text = bytes.text();
  const auto differs = std::ranges::mismatch(text, expected).in2 - expected.begin();
  EXPECT_TRUE(text == expected)
      << "seed " << kSeed << ", "
      << expected.substr(static_cast<std::size_t>(std::max<std::ptrdiff_t>(differs - 100, 0)), 300);
}

TEST(CsvWriter, HasEverythingOfATool) {
  EXPECT_EQ(row_of(ToolChange{{.number = 3,
                               .diameter = mm(0.8),
                               .infeed = mm_per_s(60),
                               .retract = mm_per_s(200),
                               .speed = rpm(68000),
                               .max_hits = 1500,
                               .depth_offset = mm(-0.1)},
                              2}),
            (Row{{"op", "tool"},
                 {"line", "10"},
                 {"tool", "3"},
                 {"diameter", "0.8"},
                 {"feed", "60"},
                 {"retract", "200"},
                 {"speed", "68000"},
                 {"max_hits", "1500"},
                 {"depth_offset", "-0.1"},
                 {"compensation_index", "2"}}));
}

TEST(CsvWriter, HasEverythingOfRouts) {
  EXPECT_EQ(row_of(rout_arc(RoutKind::Clockwise, 2, 5, 7, 4, 6)),
            (Row{{"op", "rout"},
                 {"line", "10"},
                 {"tool", "2"},
                 {"nominal_x", "4.75"},
                 {"nominal_y", "6.5"},
                 {"actual_x", "105"},
                 {"actual_y", "207"},
                 {"sigma_x", "0.002"},
                 {"sigma_y", "0.003"},
                 {"feed", "20"},
                 {"kind", "cw"},
                 {"center_x", "104"},
                 {"center_y", "206"}}));
  EXPECT_FALSE(row_of(rout_line(2, 5, 7)).contains("center_x"));
  EXPECT_EQ(row_of(rapid_move(5, 7))["op"], "position");
  EXPECT_EQ(row_of(rapid_move(5, 7))["sigma_y"], "0.003");
  EXPECT_EQ(row_of(Plunge{2, PlungeKind::Contouring, mm(0.2)}),
            (Row{{"op", "plunge"},
                 {"line", "10"},
                 {"tool", "2"},
                 {"kind", "contouring"},
                 {"depth_offset", "0.2"}}));
  EXPECT_EQ(row_of(Retract{true}), (Row{{"op", "retract"}, {"line", "10"}, {"kind", "clamping"}}));
  EXPECT_EQ(row_of(Compensation{CompensationSide::Left, mm(2.4)}),
            (Row{{"op", "compensation"}, {"line", "10"}, {"side", "left"}, {"value", "2.4"}}));
}

TEST(CsvWriter, HasEverythingOfSlots) {
  const Row expected = {{"op", "step_slot"},
                        {"line", "10"},
                        {"tool", "1"},
                        {"nominal_x", "4.75"},
                        {"nominal_y", "6.5"},
                        {"actual_x", "105"},
                        {"actual_y", "207"},
                        {"sigma_x", "0.002"},
                        {"sigma_y", "0.003"},
                        {"nominal_end_x", "8.75"},
                        {"nominal_end_y", "6.5"},
                        {"actual_end_x", "109"},
                        {"actual_end_y", "207"},
                        {"sigma_end_x", "0.002"},
                        {"sigma_end_y", "0.003"},
                        {"feed", "40"},
                        {"initial_depth", "5"},
                        {"increment", "-2.5"}};
  EXPECT_EQ(row_of(StepSlot{1, place(5, 7), place(9, 7), mm(5), mm(-2.5), mm_per_s(40)}), expected);
  Row drilled = expected;
  drilled["op"] = "slot";
  drilled.erase("feed");
  drilled.erase("initial_depth");
  drilled.erase("increment");
  EXPECT_EQ(row_of(Slot{1, place(5, 7), place(9, 7)}), drilled);
}

TEST(CsvWriter, HasRatesAndAutocalibrations) {
  EXPECT_EQ(
      row_of(ToolRate{2, mm_per_s(60), mm_per_s(300)}),
      (Row{{"op", "rate"}, {"line", "10"}, {"tool", "2"}, {"feed", "60"}, {"retract", "300"}}));
  EXPECT_EQ(row_of(Autocalibration{position_mm<frame::Nominal>(1, 2),
                                   displacement_mm<frame::Machine>(1, 2),
                                   position_mm<frame::Machine>(101, 202)}),
            (Row{{"op", "autocalibration"},
                 {"line", "10"},
                 {"nominal_x", "1"},
                 {"nominal_y", "2"},
                 {"actual_x", "101"},
                 {"actual_y", "202"}}));
}

TEST(CsvWriter, MakesATextOfWhatASpreadsheetWouldRun) {
  for (const std::string text : {"=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1"}) {
    EXPECT_EQ(row_of(function(FunctionKind::BinaryMap, text)).at("text"), "'" + text);
  }
  EXPECT_EQ(row_of(function(FunctionKind::BinaryMap, "1=1")).at("text"), "1=1");
}

TEST(CsvWriter, HasEverythingOfTheRest) {
  EXPECT_EQ(row_of(Stop{StopKind::Inspection,
                        displacement_mm<frame::Machine>(1, 2),
                        position_mm<frame::Machine>(11, 12)}),
            (Row{{"op", "stop"},
                 {"line", "10"},
                 {"kind", "inspection"},
                 {"actual_x", "11"},
                 {"actual_y", "12"}}));
  EXPECT_EQ(row_of(Dwell{seconds(2.5)}), (Row{{"op", "dwell"}, {"line", "10"}, {"time", "2.5"}}));
  EXPECT_EQ(
      row_of(function(FunctionKind::BinaryMap, "M19,123456")),
      (Row{{"op", "function"}, {"line", "10"}, {"kind", "binary_map"}, {"text", "M19,123456"}}));
  Function expired = function(FunctionKind::ToolExpired, {});
  expired.tool = 1;
  expired.next_tool = 5;
  EXPECT_EQ(row_of(expired),
            (Row{{"op", "function"},
                 {"line", "10"},
                 {"kind", "tool_expired"},
                 {"tool", "1"},
                 {"next_tool", "5"}}));
  EXPECT_EQ(
      row_of(ZeroSet{displacement_mm<frame::Machine>(1, 2), position_mm<frame::Machine>(3, 4)}),
      (Row{{"op", "zero_set"},
           {"line", "10"},
           {"zero_set_x", "1"},
           {"zero_set_y", "2"},
           {"work_zero_x", "3"},
           {"work_zero_y", "4"}}));
}

TEST(CsvWriter, QuotesTextsThatNeedIt) {
  EXPECT_THAT(written<CsvWriter>({Message{"SAY \"GO\", THEN\nWAIT", true}}, metric_info()),
              ::testing::HasSubstr("\nmessage,10,,,,,,,,,,,,\"SAY \"\"GO\"\", THEN\nWAIT\",,"));
  EXPECT_EQ(row_of(Message{"FIRST\nSECOND", true}),
            (Row{{"op", "message"}, {"line", "10"}, {"text", "FIRST\nSECOND"}, {"long", "true"}}));
  EXPECT_EQ(row_of(Message{"PLAIN"}), (Row{{"op", "message"}, {"line", "10"}, {"text", "PLAIN"}}));
}

TEST(CsvWriter, NamesTheStoredPattern) {
  StringSink bytes;
  CsvWriter writer(bytes);
  writer.put({3, {}, Dwell{seconds(1)}, "a,b.pat", nullptr});
  ASSERT_TRUE(writer.finish());
  EXPECT_TRUE(bytes.text().ends_with(",\"a,b.pat\",,,,,,,,,,,,,\n")) << bytes.text();
}

}  // namespace
}  // namespace panelcal
