// SPDX-License-Identifier: Apache-2.0
// Gerber Layer Format Specification 2022.02: flashes that are fiducials.
#include <string>

#include "machine/align/pad_readers.h"
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

constexpr const char* kHead = "%FSLAX46Y46*%\n%MOMM*%\n%LPD*%\n";

Expected<internal::FoundPads> pads_in(const std::string& text,
                                      std::optional<Length> diameter = std::nullopt) {
  return internal::pads_of_gerber(text, "a.gbr", diameter);
}

/// "40 20; 75 5.5", in the order of the file.
std::string places(const Expected<internal::FoundPads>& found) {
  if (!found) return found.error().text();
  std::string text;
  for (const internal::FoundPad& one : found->pads) {
    const Eigen::Vector2d at_mm = one.pad.nominal.in_mm();
    text += fmt::format("{}{:g} {:g}", text.empty() ? "" : "; ", at_mm.x(), at_mm.y());
  }
  return text;
}

std::string two_kinds(const std::string& attribute, const std::string& end) {
  return std::string(kHead) + attribute + "FiducialPad,Local" + end + "%ADD10C,0.5*%\n" +
         attribute + "FiducialPad,Global" + end +
         "%ADD11C,1.0*%\n%TD*%\n%ADD12C,1.0*%\nD10*\nX1000000Y2000000D03*\nD11*"
         "\nX5000000Y5500000D03*\n"
         "X75000000D03*\nD12*\nX9000000Y9000000D03*\nM02*\n";
}

TEST(GerberFiducials, AreFlashesOfTheWidestKind) {
  for (const auto& [attribute, end] :
       {std::pair{"%TA.AperFunction,", "*%\n"}, std::pair{"G04 #@! TA.AperFunction,", "*\n"}}) {
    const auto found = pads_in(two_kinds(attribute, end));
    EXPECT_EQ(places(found), "5 5.5; 75 5.5") << "coordinates stay in force";
    ASSERT_TRUE(found);
    EXPECT_EQ(found->words, "flashes FiducialPad,Global");
    EXPECT_EQ(found->pads[0].diameter, mm(1));
    EXPECT_EQ(found->pads[1].pad.line, 14);
  }
}

TEST(GerberFiducials, MayBeNamedByTheirDiameter) {
  const std::string text =
      std::string(kHead) +
      "%ADD10C,0.5*%\n%ADD11C,1.0X0.3*%\n%ADD12R,1.0X1.0*%\nD10*\nX1000000Y0D03*\nD11*\n"
      "X2000000Y0D03*\nD12*\nX3000000Y0D03*\nM02*\n";
  EXPECT_EQ(places(pads_in(text, mm(1.0))), "2 0");
  const auto refused = pads_in(text);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::Usage);
  EXPECT_NE(refused.error().what.find("0.5 mm (1), 1 mm (1)"), std::string::npos);
}

TEST(GerberFiducials, AreReadInInches) {
  EXPECT_EQ(
      places(pads_in("%FSLAX24Y24*%\n%MOIN*%\n%ADD10C,0.1*%\nG54D10*\nX10000Y-5000D03*\nM02*\n",
                     inch(0.1))),
      "25.4 -12.7");
}

TEST(GerberFiducials, SkipsWhatMovesNoFlash) {
  EXPECT_EQ(
      places(pads_in(
          std::string(kHead) +
              "G04 a comment*\n%AMROUND*\n1,1,$1,0,0*\n%\n%ADD10C,1*%\n%ADD11ROUND,1*%\nG75*\n"
              "D10*\nG01X0Y0D02*\nX1000000Y0D01*\nG36*\nG03X2000000Y0I500000J0D01*\nG37*\n"
              "X7000000Y8000000D03*\n%LPC*%\nX1000000Y1000000D03*\nM02*\n",
          mm(1))),
      "7 8");
}

TEST(GerberFiducials, RefusesWhatItDoesNotUnderstand) {
  const auto code = [](const std::string& text) {
    const auto found = pads_in(text, mm(1));
    return found ? std::string("none")
                 : fmt::format("{} {}", info(found.error().code).slug, found.error().place.line);
  };
  const std::string head = kHead;
  const std::string flash = "%ADD10C,1*%\nD10*\nX0Y0D03*\n";
  EXPECT_EQ(code(head + flash), "end-missing 7");
  EXPECT_EQ(code(head + "%SRX2Y2I10.0J10.0*%\n" + flash + "M02*\n"), "not-supported 4");
  EXPECT_EQ(code(head + "%ABD12*%\nM02*\n"), "not-supported 4");
  EXPECT_EQ(code("%FSTAX46Y46*%\nM02*\n"), "not-supported 1");
  EXPECT_EQ(code("%FSLIX46Y46*%\nM02*\n"), "not-supported 1");
  EXPECT_EQ(code("%FSLAX46Y46*%\nX1Y1D02*\nM02*\n"), "argument-invalid 2");
  EXPECT_EQ(code(head + "G91*\nM02*\n"), "not-supported 4");
  EXPECT_EQ(code(head + "D10*\nM02*\n"), "argument-invalid 4");
  EXPECT_EQ(code(head + "%ADD10C,1*%\nX1.5Y0D02*\nM02*\n"), "number-malformed 5");
  EXPECT_EQ(code(head + "%LS0.5*%\nM02*\n"), "not-supported 4");
}

}  // namespace
}  // namespace panelcal
