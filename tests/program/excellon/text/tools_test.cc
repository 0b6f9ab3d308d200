// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/tools.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal::excellon {
namespace {

const NumberFormat kInch = {};
const NumberFormat kMetric = {
    .unit = LengthUnit::Millimeter, .integer_digits = 3, .decimal_digits = 3};

struct ReadTool {
  std::optional<ToolBlock> block;
  std::vector<std::string> diagnostics;

  const Tool& tool() const { return block.value().tool; }
};

ReadTool read(std::string_view text,
              const NumberFormat& format = kInch,
              const std::map<int, Tool>* defined = nullptr) {
  Block block;
  EXPECT_FALSE(lex({text, 1}, block)) << text;
  DiagnosticLog log;
  const std::vector<Tool> no_page;
  ReadTool out{read_tool_block(block, {format, defined, no_page}, Reporter("p.exc", log)), {}};
  out.diagnostics = test::briefs(log);
  return out;
}

double infeed_inch_per_min(std::string_view text) {
  return *read(text).tool().infeed / inch_per_min(1);
}

using Texts = std::vector<std::string>;

TEST(Tools, ManualToolSelection) {
  EXPECT_EQ(read("T1").tool().number, 1);
  EXPECT_EQ(read("T01").tool().number, 1);
  EXPECT_EQ(read("T10").tool().number, 10);
}

TEST(Tools, ManualCompensationIndex) {
  const std::map<int, Tool> none;
  const ReadTool out = read("T0302", kInch, &none);
  EXPECT_EQ(out.tool().number, 3);
  EXPECT_EQ(out.block->compensation_index, 2);
  EXPECT_EQ(read("T0300", kInch, &none).block->compensation_index, 3);
  EXPECT_EQ(read("T03", kInch, &none).block->compensation_index, std::nullopt);
}

TEST(Tools, ANumberThatTheHeaderDefinesIsNoCompensationIndex) {
  const std::map<int, Tool> defined = {{150, {.number = 150}}};
  EXPECT_EQ(read("T150", kInch, &defined).tool().number, 150);
  EXPECT_EQ(read("T150", kInch, &defined).block->compensation_index, std::nullopt);
  EXPECT_EQ(read("T151", kInch, &defined).tool().number, 1);
  EXPECT_EQ(read("T151", kInch, &defined).block->compensation_index, 51);
}

/// "The last two are for the index number", which the data of a header are not for; a file that
/// counts its tools in four digits means another tool.
TEST(Tools, AHeaderRefusesNumbersThatMayHaveACompensationIndex) {
  for (const char* number : {"T0100C.03", "T0302", "T0999"}) {
    const ReadTool out = read(number);
    EXPECT_FALSE(out.block) << number;
    EXPECT_EQ(out.diagnostics, Texts{"p.exc:1:1: error[argument-invalid]"}) << number;
  }
  EXPECT_EQ(read("T0099").tool().number, 99);
  EXPECT_EQ(read("T100").tool().number, 100);
  EXPECT_EQ(read("T1000").tool().number, 1000);
}

TEST(Tools, ManualInfeed) {
  EXPECT_DOUBLE_EQ(infeed_inch_per_min("T01F2"), 200);
  EXPECT_DOUBLE_EQ(infeed_inch_per_min("T01F02"), 20);
  EXPECT_DOUBLE_EQ(infeed_inch_per_min("T01F07"), 70);
  EXPECT_DOUBLE_EQ(infeed_inch_per_min("T01F03"), 30);
  EXPECT_DOUBLE_EQ(infeed_inch_per_min("T1F080"), 80);
  EXPECT_DOUBLE_EQ(read("T01F2", kMetric).tool().infeed->in_mm_s(), 200);
}

TEST(Tools, ManualRetractRate) {
  EXPECT_DOUBLE_EQ(*read("T01B02").tool().retract / inch_per_min(1), 200);
  EXPECT_DOUBLE_EQ(*read("T01B002").tool().retract / inch_per_min(1), 20);
  EXPECT_DOUBLE_EQ(*read("T1B0500").tool().retract / inch_per_min(1), 500);
  EXPECT_DOUBLE_EQ(read("T01B02", kMetric).tool().retract->in_mm_s(), 200);
}

TEST(Tools, ManualSpindleSpeed) {
  EXPECT_EQ(read("T01S612").tool().speed->in_rpm(), 61'200);
  EXPECT_EQ(read("T06F200S61").tool().speed->in_rpm(), 61'000);
  EXPECT_EQ(read("T03S6").tool().speed->in_rpm(), 60'000);
  EXPECT_EQ(read("T04S110.5").tool().speed->in_rpm(), 110'500);
  EXPECT_EQ(read("T2S70").tool().speed->in_rpm(), 70'000);
}

TEST(Tools, ManualDiameter) {
  EXPECT_DOUBLE_EQ(read("T1C.04").tool().diameter->in_inch(), 0.04);
  const Tool tool = read("T1C.04F200S65").tool();
  EXPECT_DOUBLE_EQ(tool.diameter->in_inch(), 0.04);
  EXPECT_DOUBLE_EQ(*tool.infeed / inch_per_min(1), 200);
  EXPECT_EQ(tool.speed->in_rpm(), 65'000);
}

TEST(Tools, ManualHierarchyHasTwoOrdersOfTheSameData) {
  // The manual's text says 0.0038 inch here, which C.038 is not.
  EXPECT_EQ(read("T01F190S73C.038").tool(), read("T01C.038F190S73").tool());
  EXPECT_DOUBLE_EQ(read("T01F190S73C.038").tool().diameter->in_inch(), 0.038);
}

TEST(Tools, ManualMaximumHits) {
  EXPECT_EQ(read("T03H2000").tool().max_hits, 2000);
  EXPECT_EQ(read("T01H").tool().max_hits, std::nullopt);
  EXPECT_EQ(read("T01H20H").tool().max_hits, std::nullopt);
}

TEST(Tools, ManualDepthOffset) {
  const Tool below = read("T01C00125Z-00001").tool();
  EXPECT_DOUBLE_EQ(below.diameter->in_inch(), 0.125);
  EXPECT_DOUBLE_EQ(below.depth_offset->in_inch(), -0.001);
  const Tool mean = read("T02C0009Z").tool();
  EXPECT_DOUBLE_EQ(mean.diameter->in_inch(), 0.09);
  EXPECT_EQ(mean.depth_offset, Length());
  const Tool above = read("T03C00008Z00002").tool();
  EXPECT_DOUBLE_EQ(above.diameter->in_inch(), 0.008);
  EXPECT_DOUBLE_EQ(above.depth_offset->in_inch(), 0.002);
  EXPECT_DOUBLE_EQ(read("T1Z+.01").tool().depth_offset->in_inch(), 0.01);
}

TEST(Tools, ManualSampleProgramHeader) {
  const Tool tool = read("T1C.0135F080S80B0500H1500").tool();
  EXPECT_DOUBLE_EQ(tool.diameter->in_inch(), 0.0135);
  EXPECT_DOUBLE_EQ(*tool.infeed / inch_per_min(1), 80);
  EXPECT_EQ(tool.speed->in_rpm(), 80'000);
  EXPECT_DOUBLE_EQ(*tool.retract / inch_per_min(1), 500);
  EXPECT_EQ(tool.max_hits, 1500);
  EXPECT_DOUBLE_EQ(read("T7C.125F040S20B1000Z-.010").tool().depth_offset->in_inch(), -0.01);
}

TEST(Tools, DataNotGivenStayUnknown) {
  EXPECT_EQ(read("T1").tool(), Tool{.number = 1});
  EXPECT_EQ(read("T1C0").tool().diameter, std::nullopt);
}

TEST(Tools, RatesOutsideTheManualsRangeAreWarnedOf) {
  EXPECT_EQ(read("T1F6").diagnostics, Texts{"p.exc:1:3: warning[rate-out-of-range]"});
  EXPECT_EQ(read("T1B0009").diagnostics, Texts{"p.exc:1:3: warning[rate-out-of-range]"});
  EXPECT_EQ(read("T1F3", kMetric).diagnostics.size(), 1U);
}

TEST(Tools, TheManualsLimitsThemselvesAreInside) {
  for (const char* text : {"T1F010", "T1F500", "T1B0010", "T1B1000"}) {
    EXPECT_EQ(read(text).diagnostics, Texts{}) << text;
  }
  for (const char* text : {"T1F004", "T1F212", "T1B0005", "T1B0425"}) {
    EXPECT_EQ(read(text, kMetric).diagnostics, Texts{}) << text;
  }
  for (const char* text : {"T1F009", "T1F501", "T1B1001"}) {
    EXPECT_EQ(read(text).diagnostics.size(), 1U) << text;
  }
  for (const char* text : {"T1F003", "T1F213", "T1B0004", "T1B0426"}) {
    EXPECT_EQ(read(text, kMetric).diagnostics.size(), 1U) << text;
  }
}

TEST(Tools, RefusesBadDataWithPlaceAndForm) {
  EXPECT_EQ(read("T").diagnostics, Texts{"p.exc:1:1: error[argument-invalid]"});
  EXPECT_EQ(read("T12345").diagnostics.size(), 1U);
  EXPECT_EQ(read("T1F20.5").diagnostics, Texts{"p.exc:1:3: error[argument-invalid]"});
  EXPECT_EQ(read("T1S-5").diagnostics, Texts{"p.exc:1:3: error[argument-invalid]"});
  EXPECT_EQ(read("T1H2.5").diagnostics, Texts{"p.exc:1:3: error[argument-invalid]"});
  EXPECT_EQ(read("T1C").diagnostics, Texts{"p.exc:1:3: error[argument-invalid]"});
  EXPECT_EQ(read("T1C-.04").diagnostics, Texts{"p.exc:1:3: error[argument-invalid]"});
  EXPECT_EQ(read("T1C.0.4").diagnostics, Texts{"p.exc:1:4: error[number-malformed]"});
  EXPECT_EQ(read("T1X01").diagnostics, Texts{"p.exc:1:3: error[block-not-alone]"});
  EXPECT_EQ(read("T1,2").diagnostics, Texts{"p.exc:1:4: error[block-not-alone]"});
}

TEST(ToolLink, IsNumbersBetweenSlashes) {
  EXPECT_TRUE(is_tool_link("1/5/6"));
  EXPECT_TRUE(is_tool_link("01/12"));
  for (const char* text : {"", "/", "1", "1/", "/1", "1//2", "1/2 ", "T1/2"}) {
    EXPECT_FALSE(is_tool_link(text)) << text;
  }
}

}  // namespace
}  // namespace panelcal::excellon
