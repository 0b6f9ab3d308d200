// SPDX-License-Identifier: Apache-2.0
// Digits that nothing states are held against the holes: those of one tool do not lie in each
// other.
#include "program/excellon/text/digit_evidence.h"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "program/excellon/text/header_reader.h"
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal::excellon {
namespace {

using testing::HasSubstr;
using Places = std::vector<Eigen::Vector2d>;
using Lines = std::vector<std::string>;

constexpr double kDrill_mm = 0.8;

/// Rows and columns of holes.
Places grid(int n_columns, int n_rows, double pitch_mm) {
  Places out;
  for (int row = 0; row < n_rows; ++row) {
    for (int column = 0; column < n_columns; ++column) {
      out.emplace_back(10 + column * pitch_mm, 5 + row * pitch_mm);
    }
  }
  return out;
}

/// A slot drilled hole by hole.
Places nibble(double length_mm, double step_mm, double y_mm = 5) {
  Places out;
  for (int i = 0; i * step_mm <= length_mm; ++i) out.emplace_back(10 + i * step_mm, y_mm);
  return out;
}

/// A program whose coordinates have all their digits, of which so many stand behind the point.
std::string program(const std::string& unit, const Places& places, int n_decimals) {
  const bool is_inch = unit == "INCH,TZ" || unit == "M72";
  std::string out =
      fmt::format("M48\n{}\nT1C{:.4f}\n%\nT1\n", unit, kDrill_mm / (is_inch ? 25.4 : 1));
  for (const Eigen::Vector2d& at_mm : places) {
    const Eigen::Vector2d steps = at_mm / (is_inch ? 25.4 : 1) * std::pow(10, n_decimals);
    const int n_digits = is_inch ? 2 + n_decimals : 6;
    out += fmt::format(
        "X{0:0{2}}Y{1:0{2}}\n", std::lround(steps.x()), std::lround(steps.y()), n_digits);
  }
  return out + "M30\n";
}

struct Read {
  Lines diagnostics;  ///< without their wording
  std::string text;   ///< of the first one
  bool is_refused = false;
  std::string format;
};

Read read(const std::string& text, const ReadOptions& reading = {}) {
  DiagnosticLog log;
  const Header header = read_header({"p.exc", text}, reading, log);
  Read out{test::briefs(log), "", header.is_refused, header.number_summary()};
  if (!log.kept().empty()) out.text = log.kept().front().text();
  return out;
}

const Lines kAmbiguous{"p.exc:6:1: error[format-ambiguous]"};
const Lines kAssumed{"p.exc:6:1: warning[format-assumed]"};

// --- how holes lie -------------------------------------------------------------------------------

TEST(HoleOverlap, CountsPlacesOfAGridAsCrowded) {
  const HoleOverlap overlap = overlap_of(grid(8, 8, 0.254), kDrill_mm);
  EXPECT_EQ(overlap.n_places, 64);
  EXPECT_EQ(overlap.n_overlapping, 64);
  EXPECT_EQ(overlap.n_crowded, 64);
}

TEST(HoleOverlap, HolesThatTouchAndHolesDrilledTwiceDoNotOverlap) {
  Places places = grid(8, 8, kDrill_mm);
  places.insert(places.end(), places.begin(), places.end());
  const HoleOverlap overlap = overlap_of(places, kDrill_mm);
  EXPECT_EQ(overlap.n_places, 64);
  EXPECT_EQ(overlap.n_overlapping, 0);
}

/// Slots of one row and of two, and rings: what CAM systems nibble.
TEST(HoleOverlap, NibbledPlacesAreNoCrowd) {
  Places wide = nibble(8, 0.2);
  for (const Eigen::Vector2d& at_mm : nibble(8, 0.2, 5.4)) wide.push_back(at_mm);
  Places ring;
  for (int i = 0; i < 48; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / 48;
    ring.emplace_back(1.5 * std::cos(angle_rad), 1.5 * std::sin(angle_rad));
  }
  for (const Places& places : {nibble(8, 0.2), wide, ring}) {
    const HoleOverlap overlap = overlap_of(places, kDrill_mm);
    EXPECT_EQ(overlap.n_overlapping, overlap.n_places);
    EXPECT_LT(10 * overlap.n_crowded, overlap.n_places);
  }
}

// --- what contradicts the digits -----------------------------------------------------------------

/// "the digit format you last selected" may have been 0000.00 (CNC-7 manual, Metric Measuring
/// Mode).
TEST(CheckDigits, RefusesHolesThatLieInEachOther) {
  for (const char* unit : {"METRIC,TZ", "METRIC,LZ", "M71\nMETRIC,TZ"}) {
    const Read out = read(program(unit, grid(8, 8, 2.54), 2));
    ASSERT_EQ(out.diagnostics.size(), 1U) << unit;
    EXPECT_THAT(out.diagnostics[0], HasSubstr("error[format-ambiguous]")) << unit;
    EXPECT_TRUE(out.is_refused) << unit;
    EXPECT_THAT(out.text,
                HasSubstr("(x 1 to 2.778, y 0.5 to 2.278 mm; of tool 1, 0.8 mm, 64 of 64"))
        << unit;
    EXPECT_THAT(out.text, HasSubstr("(x 10 to 27.78, y 5 to 22.78 mm; of tool 1, 0.8 mm, 0 of 64"))
        << unit;
  }
  const Read out = read(program("METRIC,TZ", grid(8, 8, 2.54), 2));
  EXPECT_EQ(out.diagnostics, kAmbiguous);
  EXPECT_THAT(out.text, HasSubstr("such as METRIC,TZ,000.000"));
}

TEST(CheckDigits, RefusesInchIn00_000) {
  const Read out = read(program("INCH,TZ", grid(8, 8, 2.54), 3));
  EXPECT_EQ(out.diagnostics, kAmbiguous);
  EXPECT_THAT(out.text, HasSubstr("inch 2.3"));
  EXPECT_THAT(out.text, HasSubstr("such as INCH,TZ,00.0000"));
}

TEST(CheckDigits, TakesTheUsualDigitsOfHolesThatLieApart) {
  for (const double pitch_mm : {0.96, 2.54, 20.0}) {
    EXPECT_EQ(read(program("METRIC,TZ", grid(8, 8, pitch_mm), 3)).diagnostics, Lines{}) << pitch_mm;
    EXPECT_EQ(read(program("INCH,TZ", grid(8, 8, pitch_mm), 4)).diagnostics, Lines{}) << pitch_mm;
  }
}

TEST(CheckDigits, StatedDigitsAreNotQuestioned) {
  const Places places = grid(8, 8, 2.54);
  EXPECT_EQ(read(program("METRIC,TZ,000.000", places, 2)).diagnostics, Lines{});
  EXPECT_EQ(read(program("METRIC,TZ,0000.00", places, 2)).diagnostics, Lines{});
  EXPECT_EQ(read(program(";FILE_FORMAT=3:3\nMETRIC,TZ", places, 2)).diagnostics, Lines{});
  ReadOptions forced;
  forced.forced_format = *parse_format("metric,tz,4.2");
  EXPECT_EQ(read(program("METRIC,TZ", places, 2), forced).diagnostics, Lines{});
  ReadOptions setting;
  setting.last_format = *parse_format("metric,3.3");
  EXPECT_FALSE(read(program("METRIC,TZ", places, 2), setting).is_refused);
}

TEST(CheckDigits, SlotsNibbledHoleByHoleAreWarnedOf) {
  const Read out = read(program("METRIC,TZ", nibble(8, 0.2), 3));
  EXPECT_EQ(out.diagnostics, kAssumed);
  EXPECT_FALSE(out.is_refused);
  EXPECT_EQ(out.format, "metric 3.3, trailing zeros kept");
}

TEST(CheckDigits, SomeSlotsAmongOtherHolesSayNothing) {
  Places places = grid(20, 20, 2.54);
  for (const Eigen::Vector2d& at_mm : nibble(8, 0.2, 80)) places.push_back(at_mm);
  EXPECT_EQ(read(program("METRIC,TZ", places, 3)).diagnostics, Lines{});
}

TEST(CheckDigits, HolesOfACycleAndOfRoutsSayNothing) {
  const std::string head = "M48\nMETRIC,TZ\nT1C.8\n%\nT1\n";
  std::string slots;
  std::string routs = "G00X10000Y5000\nM15\n";
  for (int i = 0; i < 100; ++i) {
    slots += fmt::format("X10000Y{0}G85X18000Y{0}\n", 5000 + 200 * i);
    routs += fmt::format("G01X{}Y{}\n", 10000 + 200 * (i % 10), 5000 + 200 * (i / 10));
  }
  EXPECT_EQ(read(head + slots + "M30\n").diagnostics, Lines{});
  EXPECT_EQ(read(head + routs + "M16\nM30\n").diagnostics, Lines{});
}

/// A board that would not fit on the machine is no better reading.
TEST(CheckDigits, AReadingBeyondTheTravelExplainsNothing) {
  const std::string text = program("METRIC,TZ", grid(8, 8, 2.54), 2);
  EXPECT_EQ(read(text, {.travel_mm = {{20, 20}}}).diagnostics, kAmbiguous);
  EXPECT_EQ(read(text, {.travel_mm = {{15, 15}}}).diagnostics, Lines{});
}

TEST(CheckDigits, HolesWithoutADiameterSayNothing) {
  std::string text = program("METRIC,TZ", grid(8, 8, 2.54), 2);
  text.erase(text.find("C0.8000"), 7);
  EXPECT_EQ(read(text).diagnostics, Lines{});
}

}  // namespace
}  // namespace panelcal::excellon
