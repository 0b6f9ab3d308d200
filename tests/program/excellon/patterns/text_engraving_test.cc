// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/patterns/text_engraving.h"

#include <optional>
#include <string>

#include "program/geometry/dot_font.h"
#include <gtest/gtest.h>

namespace panelcal::excellon {
namespace {

TEST(TextPitch, ManualSpacing) {
  EXPECT_DOUBLE_EQ(text_pitch_mm(inch(0.032)), inch(0.0384).in_mm());
  EXPECT_DOUBLE_EQ(text_pitch_mm(mm(1)), 1.2);
  EXPECT_DOUBLE_EQ(text_pitch_mm(std::nullopt), inch(0.0417).in_mm());
  EXPECT_DOUBLE_EQ(text_pitch_mm(mm(0)), inch(0.0417).in_mm());
  // Letters of a quarter inch.
  EXPECT_NEAR(text_pitch_mm(std::nullopt) * (rows(CharacterSet::Excellon4x7) - 1),
              inch(0.25).in_mm(),
              0.01);
}

TEST(PrepareText, ManualSampleProgram) {
  EXPECT_EQ(prepare_text("COMPLEX,PART,PROGRAM", ""), "COMPLEX PART PROGRAM");
  EXPECT_EQ(prepare_text("DEMONSTRATION,PANEL", ""), "DEMONSTRATION PANEL");
  EXPECT_EQ(prepare_text("EXCELLON,AUTOMATION", ""), "EXCELLON AUTOMATION");
}

TEST(PrepareText, AnAsteriskIsTheOperatorsText) {
  EXPECT_EQ(prepare_text("LOT,*-1", "JS/7,A"), "LOT JS/7 A-1");
  EXPECT_EQ(prepare_text("*", "B"), "B");
  EXPECT_EQ(prepare_text("*+*", "42"), "42+42");
}

TEST(PrepareText, WithoutOperatorTheGapClosesUp) {
  EXPECT_EQ(prepare_text("LOT,*7", ""), "LOT 7");
  EXPECT_EQ(prepare_text("*", ""), "");
  EXPECT_EQ(prepare_text("", "X"), "");
}

TEST(PrepareText, SpacesAreSpaces) {
  EXPECT_EQ(prepare_text("A B", ""), "A B");
}

TEST(PrepareText, NamesThePlaceOfACharacterThatTheMachineDoesNotKnow) {
  for (const char c : std::string("abc.:_#\t\x80")) {
    const auto prepared = prepare_text(std::string("AB,") + c + "D", "");
    ASSERT_FALSE(prepared.has_value()) << c;
    EXPECT_EQ(prepared.error(), 3U);
  }
  // In the operator's text: the place of the asterisk; an asterisk there has no meaning.
  EXPECT_EQ(prepare_text("AB*", "ok").error(), 2U);
  EXPECT_EQ(prepare_text("AB*", "*").error(), 2U);
}

}  // namespace
}  // namespace panelcal::excellon
