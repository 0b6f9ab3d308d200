// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/lexer.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

namespace panelcal::excellon {
namespace {

/// `X@1=01 Y@4=02 ,@7=rest`: letter, column, number.
std::string words_of(std::string_view text) {
  Block block;
  if (const auto fault = lex({text, 1}, block)) {
    return "fault@" + std::to_string(fault->column) + " " + std::string(fault->text);
  }
  std::string out;
  for (const Word& word : block.all()) {
    out += (out.empty() ? "" : " ") + std::string(1, word.letter) + "@" +
           std::to_string(word.column) + "=" + std::string(word.number);
  }
  if (block.argument_column != 0) {
    out += " ,@" + std::to_string(block.argument_column) + "=" + std::string(block.argument);
  }
  return out;
}

TEST(Lexer, SplitsABlockIntoWords) {
  EXPECT_EQ(words_of("X012Y-032"), "X@1=012 Y@5=-032");
  EXPECT_EQ(words_of("M02X-002Y038M80M90M70"), "M@1=02 X@4=-002 Y@9=038 M@13=80 M@16=90 M@19=70");
  EXPECT_EQ(words_of("XY"), "X@1= Y@2=");
  EXPECT_EQ(words_of("X.5Y+1."), "X@1=.5 Y@4=+1.");
}

TEST(Lexer, BlanksSeparateWordsOnly) {
  EXPECT_EQ(words_of("  X01 \tY02  "), "X@3=01 Y@8=02");
  EXPECT_EQ(words_of("X 01"), "fault@3 0");
}

TEST(Lexer, ACommaEndsTheWords) {
  EXPECT_EQ(words_of("G34,1,.05"), "G@1=34 ,@5=1,.05");
  EXPECT_EQ(words_of("M47,any Text; at all"), "M@1=47 ,@5=any Text; at all");
  EXPECT_EQ(words_of("M50,"), "M@1=50 ,@5=");
}

TEST(Lexer, NamesTheCharacterThatNoCommandHas) {
  EXPECT_EQ(words_of("X01y02"), "fault@4 y");
  EXPECT_EQ(words_of("X01=Y02"), "fault@4 =");
  EXPECT_EQ(words_of("\xC3\xA4"), "fault@1 \xC3");
}

TEST(Lexer, ABlockHasAtMost16Words) {
  EXPECT_EQ(words_of("XXXXXXXXXXXXXXXX").substr(0, 3), "X@1");
  EXPECT_EQ(words_of("XXXXXXXXXXXXXXXXY01"), "fault@17 Y01");
}

TEST(Lexer, ABlockKnowsItsTextWithoutBlanks) {
  Block block;
  ASSERT_FALSE(lex({"  X01Y02 ", 7}, block));
  EXPECT_EQ(block.line, 7);
  EXPECT_EQ(block.text, "X01Y02");
  EXPECT_EQ(block.column, 3);
  ASSERT_NE(block.find('Y'), nullptr);
  EXPECT_EQ(block.find('Y')->number, "02");
  EXPECT_EQ(block.find('Z'), nullptr);
}

TEST(LineKind, TheFirstCharacterTellsTheKind) {
  EXPECT_EQ(kind_of(""), LineKind::Empty);
  EXPECT_EQ(kind_of(" \t"), LineKind::Empty);
  EXPECT_EQ(kind_of(" ; comment"), LineKind::Empty);
  EXPECT_EQ(kind_of(" % "), LineKind::PatternMark);
  EXPECT_EQ(kind_of("%1"), LineKind::Words);
  EXPECT_EQ(kind_of("/X01"), LineKind::BlockDelete);
  EXPECT_EQ(kind_of("$uvis,calib"), LineKind::KeyboardOrder);
  EXPECT_EQ(kind_of("X01"), LineKind::Words);
}

TEST(CommandTable, EveryRowIsFoundByItsCode) {
  std::set<std::string> codes;
  for (const CommandInfo& row : command_table()) {
    EXPECT_EQ(find_command(row.letter, row.number), row.command) << row.section;
    EXPECT_EQ(&info(row.command), &row) << row.section;
    EXPECT_TRUE(codes.insert(row.letter + std::to_string(row.number)).second) << row.section;
  }
}

TEST(CommandTable, KnowsNothingElse) {
  EXPECT_EQ(find_command('G', 6), std::nullopt);
  EXPECT_EQ(find_command('M', 99), Command::StoredPattern);
  EXPECT_EQ(find_command('M', 100), std::nullopt);
  EXPECT_EQ(find_command('G', -1), std::nullopt);
  EXPECT_EQ(find_command('X', 1), std::nullopt);
}

}  // namespace
}  // namespace panelcal::excellon
