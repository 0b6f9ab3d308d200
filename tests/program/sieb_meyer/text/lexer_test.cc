// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/text/lexer.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace panelcal::sieb_meyer {
namespace {

/// `X@1=1. Y@4=2. ,@7=text`: letter, column, number; the argument last.
std::string words_of(const SourceLine& line) {
  Block block;
  if (const auto fault = lex(line, block)) {
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
std::string words_of(std::string_view text) {
  return words_of({text, 1});
}

TEST(SiebMeyerLexer, SplitsALineIntoWords) {
  EXPECT_EQ(words_of("X12.345Y34.567T1M31"), "X@1=12.345 Y@8=34.567 T@15=1 M@17=31");
  EXPECT_EQ(words_of("X-5Y+.5"), "X@1=-5 Y@4=+.5");
  EXPECT_EQ(words_of("XYM60M90M30"), "X@1= Y@2= M@3=60 M@6=90 M@9=30");
  EXPECT_EQ(words_of(""), "");
}

TEST(SiebMeyerLexer, BlanksSeparateWordsOnly) {
  EXPECT_EQ(words_of("  X1. \tY2. M50  M30 "), "X@3=1. Y@8=2. M@12=50 M@17=30");
  EXPECT_EQ(words_of(" \t"), "");
  EXPECT_EQ(words_of("X 1."), "fault@3 1");
}

TEST(SiebMeyerLexer, TheDummyToolIsTwoWords) {
  EXPECT_EQ(words_of("TD"), "T@1= D@2=");
  EXPECT_EQ(words_of("X1.Y1.TD"), "X@1=1. Y@4=1. T@7= D@8=");
}

TEST(SiebMeyerLexer, ACommentEndsTheLine) {
  EXPECT_EQ(words_of("X1.Y2.T1 (FIRST HOLE T9)"), "X@1=1. Y@4=2. T@7=1");
  EXPECT_EQ(words_of("(small letters, and # signs"), "");
  EXPECT_EQ(words_of("X1. (A) (B (C))"), "X@1=1.");
  EXPECT_EQ(words_of("X1.(A)Y2."), "fault@7 Y2.");
}

TEST(SiebMeyerLexer, NamesTheCharacterThatNoWordBeginsWith) {
  EXPECT_EQ(words_of("X1.y2."), "fault@4 y");
  EXPECT_EQ(words_of("  X1.=Y2."), "fault@6 =");
  EXPECT_EQ(words_of("/X1."), "fault@1 /");
  EXPECT_EQ(words_of("X1.,5"), "fault@4 ,");
  EXPECT_EQ(words_of("\xC3\xA4"), "fault@1 \xC3");
}

TEST(SiebMeyerLexer, ColumnsCountFromWhereTheTextBegins) {
  EXPECT_EQ(words_of({"X1.Y2.", 1, 2}), "X@2=1. Y@5=2.");
  EXPECT_EQ(words_of({"X1.y", 1, 7}), "fault@10 y");
  EXPECT_EQ(words_of({" M47,A", 1, 3}), "M@4=47 ,@8=A");
}

TEST(SiebMeyerLexer, ALineHasAtMost32Words) {
  EXPECT_EQ(words_of(std::string(32, 'X')).substr(0, 4), "X@1=");
  EXPECT_EQ(words_of(std::string(32, 'X') + "Y1."), "fault@33 Y1.");
}

TEST(SiebMeyerLexer, ABlockKnowsItsTextWithoutBlanks) {
  Block block;
  ASSERT_FALSE(lex({"\t X1.Y2. (A) ", 7}, block));
  EXPECT_EQ(block.line, 7);
  EXPECT_EQ(block.text, "X1.Y2. (A)");
  EXPECT_EQ(block.column, 3);
}

TEST(SiebMeyerLexer, ABlockForgetsTheLineBefore) {
  Block block;
  ASSERT_FALSE(lex({"X1.Y2.M47,TURN", 1}, block));
  ASSERT_FALSE(lex({"X3.", 2}, block));
  EXPECT_EQ(block.n_words, 1U);
  EXPECT_EQ(block.argument, "");
  EXPECT_EQ(block.argument_column, 0);
}

// --- texts ---------------------------------------------------------------------------------------

/// "Command that include plain text must be programmed at the end of the program line. Otherwise,
/// other commands are interpreted as plain text."
TEST(SiebMeyerLexer, ATextIsTheRestOfTheLine) {
  EXPECT_EQ(words_of("X100.Y300.T7M97,ABC"), "X@1=100. Y@6=300. T@11=7 M@13=97 ,@17=ABC");
  EXPECT_EQ(words_of("M97,A, B (1) M30"), "M@1=97 ,@5=A, B (1) M30");
  EXPECT_EQ(words_of("M47,Any text = at all"), "M@1=47 ,@5=Any text = at all");
  EXPECT_EQ(words_of("M49,CHEKX100.Y10.DXDY10."), "M@1=49 ,@5=CHEKX100.Y10.DXDY10.");
  EXPECT_EQ(words_of("M099,A"), "fault@5 ,");
}

TEST(SiebMeyerLexer, BlanksRoundATextAreNoneOfIt) {
  EXPECT_EQ(words_of("M99, FINAL "), "M@1=99 ,@6=FINAL");
  EXPECT_EQ(words_of("M99 ,FINAL"), "M@1=99 ,@6=FINAL");
}

TEST(SiebMeyerLexer, ATextMayBeEmpty) {
  EXPECT_EQ(words_of("M49,"), "M@1=49 ,@5=");
  EXPECT_EQ(words_of("M49"), "M@1=49");
  EXPECT_EQ(words_of("M97 "), "M@1=97");
}

TEST(SiebMeyerLexer, NineCommandsTakeAText) {
  const std::set<std::string> with_text = {
      "M47", "M49", "M75", "M76", "M97", "M98", "M99", "G35", "G39"};
  for (const CommandInfo& row : command_table()) {
    const std::string code = code_text(row.command);
    const std::string column = std::to_string(code.size() + 2);
    const std::string found = words_of(code + ",TEXT");
    if (with_text.contains(code)) {
      EXPECT_TRUE(found.ends_with(" ,@" + column + "=TEXT")) << found;
    } else {
      EXPECT_TRUE(found.starts_with("fault@")) << code << " " << found;
    }
  }
}

/// Only M47 may have its text without a comma.
TEST(SiebMeyerLexer, TheMessageNeedsNoComma) {
  EXPECT_EQ(words_of("M47TURN BOARD"), "M@1=47 ,@4=TURN BOARD");
  EXPECT_EQ(words_of("M47 !TURN"), "M@1=47 ,@5=!TURN");
  EXPECT_EQ(words_of("M49FV1"), "fault@4 FV1");
  EXPECT_EQ(words_of("X1.Y1.M97 ABC"), "fault@11 ABC");
  EXPECT_EQ(words_of("G35 7"), "fault@5 7");
}

// --- lines ---------------------------------------------------------------------------------------

TEST(SiebMeyerLine, IsBlankWithoutAWord) {
  EXPECT_TRUE(is_blank(""));
  EXPECT_TRUE(is_blank(" \t"));
  EXPECT_TRUE(is_blank(" ( SECTION T2 ) "));
  EXPECT_FALSE(is_blank(" ( SECTION T2 ) X1."));
  EXPECT_FALSE(is_blank(" X"));
  EXPECT_FALSE(is_blank("/"));
}

TEST(SiebMeyerLine, LosesItsSlashAndKeepsItsPlace) {
  const auto rest = without_slash({"  /X1.Y2.", 9, 4});
  ASSERT_TRUE(rest);
  EXPECT_EQ(rest->text, "X1.Y2.");
  EXPECT_EQ(rest->number, 9);
  EXPECT_EQ(rest->column, 7);
  EXPECT_EQ(words_of(*rest), "X@7=1. Y@10=2.");
  EXPECT_EQ(without_slash({"//", 1})->text, "/");
  EXPECT_FALSE(without_slash({"X1./", 1}));
  EXPECT_FALSE(without_slash({"", 1}));
}

// --- the command table ---------------------------------------------------------------------------

std::optional<Command> found(char letter, std::string_view number) {
  return command_of({letter, 1, number});
}

TEST(SiebMeyerCommands, EveryRowIsFoundByItsCode) {
  for (const CommandInfo& row : command_table()) {
    const std::string number = std::to_string(row.number);
    EXPECT_EQ(found(row.letter, number), row.command) << row.letter << number;
    EXPECT_EQ(&info(row.command), &row);
    EXPECT_EQ(code_text(row.command), row.letter + number);
  }
}

TEST(SiebMeyerCommands, EveryCodeHasOneRow) {
  std::set<std::string> codes;
  for (const CommandInfo& row : command_table()) {
    EXPECT_TRUE(codes.insert(code_text(row.command)).second) << code_text(row.command);
  }
}

TEST(SiebMeyerCommands, ALeadingZeroIsAllowed) {
  EXPECT_EQ(found('G', "01"), Command::RoutLine);
  EXPECT_EQ(found('G', "1"), Command::RoutLine);
  EXPECT_EQ(found('G', "001"), std::nullopt);
  EXPECT_EQ(found('M', "050"), std::nullopt);
}

TEST(SiebMeyerCommands, OtherNumbersAreNoCode) {
  for (const char* const number :
       {"", "0", "00", "+1", "-1", "1.", ".1", "99", "37", "38", "101"}) {
    EXPECT_EQ(found('G', number), std::nullopt) << number;
  }
  for (const char* const number : {"", "2", "8", "08", "25.", "32", "46", "51", "91", "101"}) {
    EXPECT_EQ(found('M', number), std::nullopt) << number;
  }
}

std::set<std::string> codes(std::string_view letter_and_numbers) {
  std::set<std::string> out;
  const char letter = letter_and_numbers.front();
  std::string number;
  for (const char c : std::string(letter_and_numbers.substr(1)) + " ") {
    if (c != ' ') {
      number += c;
    } else if (!number.empty()) {
      out.insert(letter + number);
      number.clear();
    }
  }
  return out;
}

/// Table B, and the table at the head of each command's section where B cannot be read or has it
/// otherwise: M50 and G43.
TEST(SiebMeyerCommands, ManualTableOfFormats) {
  std::map<std::string, std::set<std::string>> expected;
  expected["135"] = codes("G 1 2 3 11 41 42 45 46 49 50 90 91");
  expected["135"].merge(codes("M 20 21 30 50 60 70 80 90"));
  expected["35"] = codes("G 40 47 48 82 83 84 85");
  expected["35"].merge(codes("M 28 29 31 47 49 97 98"));
  expected["5"] = codes("G 6 30 31 32 33 34 35 36 39 43 70 71 72 73 74 75 76 77 78 79 80 81 88 89");
  expected["5"].merge(codes("M 22 23 24 25 26 27 34 35 36 37 38 39 40 41 42 43 44 45 52 53 54 55"));
  expected["5"].merge(codes("M 56 57 58 75 76 92 93 94 95 99"));
  std::map<std::string, std::set<std::string>> found;
  for (const CommandInfo& row : command_table()) {
    found[std::string(row.formats)].insert(code_text(row.command));
  }
  EXPECT_EQ(found, expected);
}

TEST(SiebMeyerCommands, ExistInTheFormatsThatTheyState) {
  for (const CommandInfo& row : command_table()) {
    EXPECT_EQ(row.exists_in(FileFormat::F1000), row.formats == "135") << row.formats;
    EXPECT_EQ(row.exists_in(FileFormat::F3000), row.formats != "5") << row.formats;
    EXPECT_TRUE(row.exists_in(FileFormat::F5000)) << row.formats;
  }
}

TEST(SiebMeyerCommands, EveryRowSaysEverything) {
  for (const CommandInfo& row : command_table()) {
    EXPECT_FALSE(row.section.empty() || row.effect.empty() || row.test.empty())
        << code_text(row.command);
  }
  for (const WordInfo& row : word_table()) {
    EXPECT_FALSE(row.form.empty() || row.formats.empty() || row.section.empty() ||
                 row.effect.empty() || row.test.empty())
        << row.form;
  }
}

std::set<std::string> codes_that(bool (*is_kind)(Command)) {
  std::set<std::string> out;
  for (const CommandInfo& row : command_table()) {
    if (is_kind(row.command)) out.insert(code_text(row.command));
  }
  return out;
}

TEST(SiebMeyerCommands, FiveAreOffsets) {
  EXPECT_EQ(codes_that(is_offset), codes("M 50 60 70 80 90"));
}

/// The commands of chapter 9, Optical Measurement.
TEST(SiebMeyerCommands, NineAreForTheCamera) {
  std::set<std::string> camera = codes("G 30 31 32 33 34 35 36 39");
  camera.insert("M75");
  EXPECT_EQ(codes_that(is_camera), camera);
}

}  // namespace
}  // namespace panelcal::sieb_meyer
