// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/text/order.h"

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal::sieb_meyer {
namespace {

using test::Reports;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

constexpr OrderContext k1000 = {.format = FileFormat::F1000};
constexpr OrderContext k3000 = {.format = FileFormat::F3000};

struct Reading {
  std::optional<Order> order;
  std::vector<std::string> diagnostics;
};

/// Line 4 of a file.
Reading read(std::string_view text, const OrderContext& context = {}) {
  DiagnosticLog log;
  const Reporter reporter("p.ss", log);
  Block block;
  EXPECT_FALSE(lex({text, 4}, block)) << text;
  Reading reading{read_order(block, context, reporter), {}};
  for (const Diagnostic& diagnostic : log.kept()) {
    reading.diagnostics.push_back(diagnostic.text());
  }
  return reading;
}

/// Of a line that nothing is wrong with.
Order order_of(std::string_view text, const OrderContext& context = {}) {
  Reading reading = read(text, context);
  EXPECT_THAT(reading.diagnostics, IsEmpty()) << text;
  EXPECT_TRUE(reading.order) << text;
  return reading.order.value_or(Order{});
}

void expect_refused(std::string_view text,
                    int column,
                    const std::string& code_and_word,
                    const OrderContext& context = {}) {
  const Reading reading = read(text, context);
  EXPECT_FALSE(reading.order) << text;
  const std::size_t end = code_and_word.find(']') + 1;
  const std::string place = "p.ss:4:" + std::to_string(column);
  EXPECT_THAT(reading.diagnostics,
              ElementsAre(Reports(place + ": error[" + code_and_word.substr(0, end),
                                  code_and_word.substr(std::min(end + 2, code_and_word.size())))))
      << text;
}

/// The line is read, and one word is said again.
Order order_with_repeat(std::string_view text,
                        const std::string& word,
                        const OrderContext& context = {}) {
  const Reading reading = read(text, context);
  EXPECT_THAT(
      reading.diagnostics,
      ElementsAre(AllOf(HasSubstr(": warning[word-repeated]"), HasSubstr('"' + word + '"'))))
      << text;
  EXPECT_TRUE(reading.order) << text;
  return reading.order.value_or(Order{});
}

// --- letters -------------------------------------------------------------------------------------

TEST(OrderLetters, CoordinatesAreInMillimeters) {
  const Order order = order_of("X12.345Y-34567");
  EXPECT_EQ(order.xy_mm[0], 12.345);
  EXPECT_EQ(order.xy_mm[1], -34.567);
  EXPECT_TRUE(order.has_xy());
  EXPECT_EQ(order_of("X1234", k1000).xy_mm[0], 12.34);
}

TEST(OrderLetters, ALetterAloneIsZeroAndNoLetterIsAbsent) {
  const Order order = order_of("X");
  EXPECT_EQ(order.xy_mm[0], 0.0);
  EXPECT_EQ(order.xy_mm[1], std::nullopt);
  EXPECT_TRUE(order.has_xy());
  EXPECT_FALSE(order_of("T1").has_xy());
}

/// The coarser of both, and never coarser than the format: `X10.` is no rounding to a millimetre.
TEST(OrderLetters, CoordinatesAreAsExactAsTheyAreWritten) {
  EXPECT_DOUBLE_EQ(order_of("X1.Y2.").xy_step_mm, 0.001);
  EXPECT_DOUBLE_EQ(order_of("X1.23456Y2.34567").xy_step_mm, 0.00001);
  EXPECT_DOUBLE_EQ(order_of("X1.23456Y2.").xy_step_mm, 0.001);
  EXPECT_DOUBLE_EQ(order_of("X123Y4", k1000).xy_step_mm, 0.01);
  EXPECT_DOUBLE_EQ(order_of("X1.Y1.R1.2345").parameter_step_mm, 0.0001);
  EXPECT_DOUBLE_EQ(order_of("X1.Y1.I1.2345J1.").parameter_step_mm, 0.001);
}

TEST(OrderLetters, ToolsAreTakenOrLifted) {
  EXPECT_EQ(order_of("X1.Y1.T5").tool, 5);
  EXPECT_FALSE(order_of("T5").is_tool_up);
  EXPECT_TRUE(order_of("T0").is_tool_up);
  EXPECT_EQ(order_of("T0").tool, std::nullopt);
  for (const char* const text : {"T0T5", "T5T0", "T00 T05"}) {
    EXPECT_EQ(order_of(text).tool, 5) << text;
    EXPECT_TRUE(order_of(text).is_tool_up) << text;
  }
}

TEST(OrderLetters, TdIsTheDummyTool) {
  const Order order = order_of("X1.Y1.TD");
  EXPECT_TRUE(order.is_dummy_tool);
  EXPECT_EQ(order.tool, std::nullopt);
  EXPECT_EQ(order.rounding_mm, std::nullopt);
  EXPECT_FALSE(order_of("T1D2.").is_dummy_tool);
  EXPECT_EQ(order_of("T1D2.").rounding_mm, 2.0);
  // The following words are read as ever, and a camera command may end the line.
  EXPECT_EQ(order_of("TDX1.Y1.G73L3").memory, 3);
  EXPECT_EQ(order_of("TDX1.Y1.G32").camera, Command::Measure);
}

TEST(OrderLetters, PlanesAndFeedsHaveTheirOwnUnits) {
  const Order order = order_of("X1.F1.2H20.K-.4Z3500D500L7");
  EXPECT_EQ(order.feed_m_min, 1.2);
  EXPECT_EQ(order.h_mm, 20.0);
  EXPECT_EQ(order.k_mm, -0.4);
  EXPECT_EQ(order.z_mm, 3.5);
  EXPECT_EQ(order.rounding_mm, 0.5);
  EXPECT_EQ(order.memory, 7);
  EXPECT_EQ(order_of("X1.F15Z350", k3000).feed_m_min, 1.5);
  EXPECT_EQ(order_of("X1.F15Z350", k3000).z_mm, 3.5);
}

TEST(OrderLetters, OtherLettersAreUnknown) {
  for (const char letter : std::string_view("ABCNOQSU")) {
    expect_refused("X1." + std::string(1, letter) + "5",
                   4,
                   "command-unknown]: \"" + std::string(1, letter) + "5\"");
  }
}

TEST(OrderLetters, BadNumbersAreRefusedAtTheirWord) {
  expect_refused("X1.Y2.3.", 4, "number-malformed]: \"Y2.3.\"");
  expect_refused("X1.", 1, "number-malformed]: \"X1.\"", k1000);
  expect_refused("X1F1.5", 3, "number-malformed]: \"F1.5\"", k3000);
  expect_refused("X1.F-1", 4, "number-malformed]: \"F-1\"");
  expect_refused("X1G2I-5", 5, "number-malformed]: \"I-5\"", k1000);
  expect_refused("T", 1, "argument-invalid]: \"T\"");
  expect_refused("T1000", 1, "argument-invalid]: \"T1000\"");
  expect_refused("T-1", 1, "argument-invalid]: \"T-1\"");
  expect_refused("T1.", 1, "argument-invalid]: \"T1.\"");
  expect_refused("L", 1, "argument-invalid]: \"L\"");
  expect_refused("V0", 1, "argument-invalid]: \"V0\"");
  expect_refused("V5", 1, "argument-invalid]: \"V5\"");
  expect_refused("V", 1, "argument-invalid]: \"V\"");
}

TEST(OrderLetters, TheFirstErrorEndsTheLine) {
  EXPECT_EQ(read("X1.2.3Y4.5.6").diagnostics.size(), 1U);
}

// --- what the same letter means ------------------------------------------------------------------

TEST(OrderParameters, AreRadiusAndCenterOfContours) {
  const Order order = order_of("X1.Y1.G2I-30J20.");
  EXPECT_EQ(order.parameters, ParameterKind::Rout);
  EXPECT_EQ(order.ij_mm[0], -0.03);
  EXPECT_EQ(order.ij_mm[1], 20.0);
  EXPECT_EQ(order_of("X1.Y1.G2R-5.").r_mm, -5.0);
  // Not only in a routing line: they are modal.
  EXPECT_EQ(order_of("X1.R5.").parameters, ParameterKind::Rout);
}

TEST(OrderParameters, AreNumbersOfPeckDrillingWithG81) {
  for (const char* const text : {"X1.G81I5.P80J1.4W1000", "I5.P80J1.4W1000G81"}) {
    const Order order = order_of(text);
    EXPECT_EQ(order.parameters, ParameterKind::Peck);
    EXPECT_EQ(order.peck, true);
    EXPECT_EQ(order.ij_mm[0], 5.0);
    EXPECT_EQ(order.ij_mm[1], 1.4);
    EXPECT_EQ(order.percent, 80.0);
    EXPECT_EQ(order.permille, 1000.0);
    EXPECT_EQ(order.count, std::nullopt);
  }
}

TEST(OrderParameters, AreNumbersOfPulseDrillingWithG89) {
  const Order order = order_of("X1.G89I1.J.5E100R.1");
  EXPECT_EQ(order.parameters, ParameterKind::Pulse);
  EXPECT_EQ(order.pulse, true);
  EXPECT_EQ(order.ij_mm[0], 1.0);
  EXPECT_EQ(order.ij_mm[1], 0.5);
  EXPECT_EQ(order.dwell_ms, 100.0);
  EXPECT_EQ(order.r_mm, 0.1);
}

TEST(OrderParameters, AreOfWhatIsInForce) {
  EXPECT_EQ(order_of("X1.J.9", {.is_pecking = true}).parameters, ParameterKind::Peck);
  EXPECT_EQ(order_of("W900", {.is_pecking = true}).permille, 900.0);
  EXPECT_EQ(order_of("X1.J.9", {.is_pulsing = true}).parameters, ParameterKind::Pulse);
  // Peck drilling may be on while a contour is routed: "two sets of variables".
  const OrderContext routing = {.is_routing = true, .is_pecking = true};
  EXPECT_EQ(order_of("X1.R5.", routing).parameters, ParameterKind::Rout);
  EXPECT_EQ(order_of("X1.G81J.9", routing).parameters, ParameterKind::Peck);
  for (const char* const text : {"X1.G2R5.", "X1.G45R5.", "X1.G50R5.", "X1.R5.G84"}) {
    EXPECT_EQ(order_of(text, {.is_pecking = true}).parameters, ParameterKind::Rout) << text;
  }
}

/// A partial stroke cannot be negative; a centre can.
TEST(OrderParameters, HaveTheSignsOfTheirKind) {
  expect_refused("X1.G81J-1.", 7, "number-malformed]: \"J-1.\"");
  EXPECT_EQ(order_of("X1.G3J-1.").ij_mm[1], -1.0);
}

TEST(OrderParameters, WCountsBehindAPattern) {
  const OrderContext waiting = {.expects_count = true, .is_pecking = true};
  const Order order = order_of("X20.Y20.W5", waiting);
  EXPECT_EQ(order.count, 5);
  EXPECT_EQ(order.permille, std::nullopt);
  expect_refused("W0", 1, "argument-invalid]: \"W0\"", waiting);
  expect_refused("W2.5", 1, "argument-invalid]: \"W2.5\"", waiting);
}

TEST(OrderParameters, WAloneMeansNothing) {
  expect_refused("X20.W5", 5, "argument-invalid]: \"W5\"");
  expect_refused("W5", 1, "argument-invalid]: \"W5\"", {.is_pulsing = true});
}

// --- commands ------------------------------------------------------------------------------------

TEST(OrderCommands, HoldWhereverTheyStand) {
  for (const char* const text : {"G1G41F2.X10.Y20.", "X10.Y20.G1G41F2.", "X10.G41Y20.F2.G1"}) {
    const Order order = order_of(text);
    EXPECT_EQ(order.motion, Command::RoutLine) << text;
    EXPECT_EQ(order.side, CompensationSide::Left) << text;
    EXPECT_EQ(order.feed_m_min, 2.0) << text;
    EXPECT_EQ(order.xy_mm[1], 20.0) << text;
  }
}

TEST(OrderCommands, AreSortedByWhatTheyDecide) {
  EXPECT_EQ(order_of("X1.G45R5.G43").motion, Command::CircleCounterclockwise);
  EXPECT_TRUE(order_of("X1.G45R5.G43").clears_area);
  EXPECT_EQ(order_of("X1.G84R5.").nibble, Command::NibbleCircle);
  EXPECT_EQ(order_of("X1.G85").nibble, Command::NibbleSlot);
  EXPECT_EQ(order_of("X1.G85").motion, std::nullopt);
  EXPECT_EQ(order_of("X1.V3").v, 3);
  EXPECT_TRUE(order_of("X1.G6Z3.").is_ramp);
  EXPECT_TRUE(order_of("X1.G11").finishes);
  EXPECT_EQ(order_of("X1.G40").side, CompensationSide::Off);
  EXPECT_EQ(order_of("X1.G42").side, CompensationSide::Right);
  EXPECT_EQ(order_of("G71K.4").slm, true);
  EXPECT_EQ(order_of("X1.G79").surface, Command::GridPoint);
  EXPECT_TRUE(order_of("X1.G77").skips_surface);
  EXPECT_EQ(order_of("X1.G77").surface, std::nullopt);
  EXPECT_EQ(order_of("G80").peck, false);
  EXPECT_EQ(order_of("G88").pulse, false);
  EXPECT_EQ(order_of("G82").depth_control, false);
  EXPECT_EQ(order_of("G83").depth_control, true);
  EXPECT_TRUE(order_of("G71G82").suspends_depth_control);
  EXPECT_FALSE(order_of("G82G71").suspends_depth_control);
  EXPECT_EQ(order_of("G90").incremental, false);
  EXPECT_EQ(order_of("G91").incremental, true);
  EXPECT_EQ(order_of("M92").is_scaled, false);
  EXPECT_EQ(order_of("M93").is_scaled, true);
  EXPECT_EQ(order_of("M94").checks_breakage, false);
  EXPECT_EQ(order_of("M95").checks_breakage, true);
  EXPECT_TRUE(order_of("X1.M20").may_stop);
  EXPECT_EQ(order_of("M28").stop, Command::MachineZero);
  EXPECT_EQ(order_of("X1.Y1.D5.M58").area, Command::ForbiddenArea);
}

TEST(OrderCommands, MachineFunctionsAllHoldInTheirOrder) {
  EXPECT_THAT(
      order_of("M38M21M45").functions,
      ElementsAre(Command::MachineFunction38, Command::OutputOn, Command::MachineFunction45));
}

TEST(OrderCommands, BracketsAndOffsetsAreLeftToTheSections) {
  const Order order = order_of("X10.Y20.T1M31M31");
  EXPECT_EQ(order.xy_mm[0], 10.0);
  EXPECT_THAT(order.functions, IsEmpty());
  EXPECT_THAT(order_of("X1.Y1.M60M90M30").functions, IsEmpty());
}

TEST(OrderCommands, TextsNeedOne) {
  EXPECT_EQ(order_of("X1.Y1.T7M97,ABC").text, Command::TextX);
  EXPECT_EQ(order_of("M99,FINAL").text, Command::Subprogram);
  for (const char* const code : {"M47", "M49", "M75", "M76", "M97", "M98", "M99", "G35", "G39"}) {
    expect_refused(code, 1, "argument-invalid]: \"" + std::string(code) + "\"");
    expect_refused(std::string(code) + ", ", 1, "argument-invalid]");
  }
}

TEST(OrderCommands, UnknownCodesAreRefused) {
  expect_refused("X1.G99", 4, "command-unknown]: \"G99\"");
  expect_refused("M08", 1, "command-unknown]: \"M08\"");
  expect_refused("G", 1, "command-unknown]: \"G\"");
}

// --- of contradicting ones the last holds --------------------------------------------------------

/// "If commands are programmed twice in one line, the last entry is considered."
TEST(OrderRepeats, TheLastHoldsWithAWarning) {
  EXPECT_EQ(order_with_repeat("X1.Y2.X3.", "X3.").xy_mm[0], 3.0);
  EXPECT_EQ(order_with_repeat("T1T2", "T2").tool, 2);
  EXPECT_EQ(order_with_repeat("X1.F1.F2.", "F2.").feed_m_min, 2.0);
  EXPECT_EQ(order_with_repeat("X1.V1V2", "V2").v, 2);
  EXPECT_EQ(order_with_repeat("L1L2", "L2").memory, 2);
  EXPECT_EQ(order_with_repeat("W2W3", "W3", {.expects_count = true}).count, 3);
}

TEST(OrderRepeats, TheLastOfContradictingCommandsHoldsWithAWarning) {
  EXPECT_EQ(order_with_repeat("X1.G1G2R5.", "G2").motion, Command::RoutClockwise);
  EXPECT_EQ(order_with_repeat("X1.G41G42", "G42").side, CompensationSide::Right);
  EXPECT_EQ(order_with_repeat("X1.G42G40", "G40").side, CompensationSide::Off);
  EXPECT_EQ(order_with_repeat("G91G90", "G90").incremental, false);
  EXPECT_EQ(order_with_repeat("G83G82", "G82").depth_control, false);
  EXPECT_EQ(order_with_repeat("G81G80", "G80").peck, false);
  EXPECT_EQ(order_with_repeat("G88G89", "G89").pulse, true);
  EXPECT_EQ(order_with_repeat("M93M92", "M92").is_scaled, false);
  EXPECT_EQ(order_with_repeat("M95M94", "M94").checks_breakage, false);
  EXPECT_EQ(order_with_repeat("M28M29", "M29").stop, Command::ParkPosition);
  EXPECT_EQ(order_with_repeat("G70G71", "G71").slm, true);
  EXPECT_EQ(order_with_repeat("X1.R1.G84G85", "G85").nibble, Command::NibbleSlot);
}

TEST(OrderRepeats, SayTheirPlace) {
  EXPECT_THAT(read("X1.Y2.X3.").diagnostics,
              ElementsAre(StartsWith("p.ss:4:7: warning[word-repeated]")));
}

TEST(OrderRepeats, LiftingTheToolContradictsNoTool) {
  EXPECT_THAT(read("T0T5T0").diagnostics, IsEmpty());
}

// --- camera commands -----------------------------------------------------------------------------

/// "Programming other commands after a camera command in the same program line is not allowed."
TEST(OrderCamera, ACameraCommandIsLast) {
  EXPECT_EQ(order_of("X10.Y10.G32").camera, Command::Measure);
  EXPECT_EQ(order_of("T1M31X10.Y10.G36 (HERE)").camera, Command::MeasureOffset);
  EXPECT_EQ(order_of("G35,7").text, Command::CameraByte);
  for (const char* const code : {"G30", "G31", "G32", "G33", "G34", "G36"}) {
    expect_refused("X1." + std::string(code) + "T2", 7, "camera-not-last]: \"T2\"");
  }
  expect_refused("G30G31", 4, "camera-not-last]: \"G31\"");
}

// --- formats -------------------------------------------------------------------------------------

/// "Minus sign (-): The command is not available in the format."
TEST(OrderFormats, CommandsThatAFormatLacksAreRefused) {
  for (const CommandInfo& row : command_table()) {
    const std::string code = code_text(row.command);
    const std::string text = row.command == Command::UserMessage ? code + ",A" : code;
    for (const FileFormat format : {FileFormat::F1000, FileFormat::F3000}) {
      const OrderContext context = {.format = format};
      if (!row.exists_in(format)) {
        expect_refused(code, 1, "command-format]: \"" + code + "\"", context);
      } else {
        const Reading reading = read(text, context);
        EXPECT_THAT(reading.diagnostics, Not(testing::Contains(HasSubstr("command-format"))));
      }
    }
  }
}

TEST(OrderFormats, LettersThatAFormatLacksAreRefused) {
  const auto refuses = [](std::string_view word, std::initializer_list<FileFormat> formats) {
    for (const FileFormat format : formats) {
      expect_refused("X1" + std::string(word),
                     3,
                     "command-format]: \"" + std::string(word) + "\"",
                     {.format = format});
    }
  };
  for (const char* const word : {"D5", "H5", "K5", "R5", "Z5"}) refuses(word, {FileFormat::F1000});
  for (const char* const word : {"E5", "L5", "P5", "V3", "V4"}) {
    refuses(word, {FileFormat::F1000, FileFormat::F3000});
  }
  for (const OrderContext& context : {k1000, k3000}) {
    EXPECT_EQ(order_of("X1F5", context).feed_m_min, 0.5);
    EXPECT_TRUE(order_of("X1G2I5J5", context).ij_mm[1]);
    EXPECT_EQ(order_of("X1V1", context).v, 1);
    EXPECT_EQ(order_of("X1V2", context).v, 2);
  }
  EXPECT_EQ(order_of("D5H5K5R5Z5", k3000).h_mm, 0.05);
}

}  // namespace
}  // namespace panelcal::sieb_meyer
