// SPDX-License-Identifier: Apache-2.0
#include "program/gcode/block.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal::gcode {
namespace {

Expected<GcodeBlock> read(std::string_view text) {
  return read_gcode_block({text, 7, 1}, "p.ngc");
}

std::string refusal(std::string_view text) {
  const auto block = read(text);
  return block ? "accepted" : test::brief(block.error());
}

TEST(GcodeBlock, ReadsWordsAndKeepsTheirPlaces) {
  const auto block = read("N10 g1X-12.5 Y+.25F100(to the corner)M3;later");
  ASSERT_TRUE(block) << block.error().text();
  ASSERT_EQ(block->words.size(), 6U);
  EXPECT_TRUE(block->words[1].is('G', 1));
  EXPECT_EQ(block->find('X')->value, -12.5);
  EXPECT_EQ(block->find('Y')->value, 0.25);
  EXPECT_TRUE(block->words[5].is('M', 3));
  const GcodeWord& x = *block->find('X');
  EXPECT_EQ(block->text.substr(x.begin, x.end - x.begin), "X-12.5");
  EXPECT_EQ(block->rest, "(to the corner);later");
  EXPECT_FALSE(block->has('Z'));
  EXPECT_FALSE(block->is_deleted);
}

// RS274NGC, 3.3.1: "g0x +0. 1234y 7" is "g0 x+0.1234 y7".
TEST(GcodeBlock, ForgivesBlanksAnywhere) {
  const auto block = read("g0x +0. 1234y 7");
  ASSERT_TRUE(block) << block.error().text();
  EXPECT_EQ(block->find('X')->value, 0.1234);
  EXPECT_EQ(block->find('Y')->value, 7);
}

TEST(GcodeBlock, ReadsLinesWithoutWords) {
  for (const std::string_view text : {"", "   ", "%", "(comment)", "; comment", " % "}) {
    const auto block = read(text);
    ASSERT_TRUE(block) << block.error().text();
    EXPECT_TRUE(block->words.empty());
  }
  EXPECT_TRUE(read("/G1 X1")->is_deleted);
}

TEST(GcodeBlock, KnowsWhichNumbersAreComputed) {
  const auto block = read("#<a b>=[1+[2*3]] G1 X-#5 Y[#1-2]Z##2 F#<_f>#7=-3 S1");
  ASSERT_TRUE(block) << block.error().text();
  std::string words;
  for (const GcodeWord& word : block->words) {
    words += block->text.substr(word.begin, word.end - word.begin);
    words += word.is_computed ? "! " : " ";
  }
  EXPECT_EQ(words, "#<a b>=[1+[2*3]]! G1 X-#5! Y[#1-2]! Z##2! F#<_f>! #7=-3! S1 ");
  EXPECT_FALSE(block->find('X')->is('X', 0));
}

TEST(GcodeBlock, RefusesAssignmentsToTheControlsVariables) {
  EXPECT_EQ(refusal("#5000=1"), "accepted");
  for (const std::string_view text : {"#5221=0", "##1=5", "#[1]=5", "#1", "#<a>", "#=1", "#-1=5"}) {
    EXPECT_EQ(refusal(text), "p.ngc:7:1: error[not-supported]") << text;
  }
}

TEST(GcodeBlock, RefusesWhatIsNotKnownBeforeItRuns) {
  EXPECT_EQ(refusal("G1 [1]"), "p.ngc:7:4: error[not-supported]");
  EXPECT_EQ(refusal("O100 sub"), "p.ngc:7:1: error[not-supported]");
  for (const std::string_view text : {"X[1", "X#", "X#<a", "X#<>", "X[1(2)]", "#1=", "Xsin[1]"}) {
    EXPECT_THAT(refusal(text), ::testing::HasSubstr("error[number-malformed]")) << text;
  }
}

TEST(GcodeBlock, RefusesWhatIsNoWord) {
  EXPECT_EQ(refusal("G1 X"), "p.ngc:7:4: error[number-malformed]");
  for (const std::string_view text : {"X1.2.3", "X--1", "X+-1", "X.", "XY1", "X1-2", "X+"}) {
    EXPECT_NE(refusal(text), "accepted") << text;
  }
  EXPECT_THAT(refusal("G1 $1"), ::testing::HasSubstr("p.ngc:7:4: error[command-unknown]"));
  EXPECT_THAT(refusal("G1 (open"), ::testing::HasSubstr("p.ngc:7:4: error[command-unknown]"));
  EXPECT_EQ(refusal("X1 X2"), "p.ngc:7:4: error[argument-invalid]");
  EXPECT_NE(refusal(std::string_view("G1\0X", 4)), "accepted");
}

}  // namespace
}  // namespace panelcal::gcode
