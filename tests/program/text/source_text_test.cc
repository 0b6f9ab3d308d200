// SPDX-License-Identifier: Apache-2.0
#include "program/text/source_text.h"

#include <filesystem>
#include <fstream>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

std::vector<std::string> lines_of(std::string_view bytes) {
  std::vector<std::string> lines;
  LineCursor cursor(bytes);
  while (!cursor.at_end()) {
    const int number = cursor.line_number();
    const SourceLine line = cursor.next();
    EXPECT_EQ(line.number, number);
    EXPECT_EQ(line.number, static_cast<int>(lines.size()) + 1);
    lines.emplace_back(line.text);
  }
  return lines;
}

using Lines = std::vector<std::string>;

TEST(LineCursor, EveryKindOfLineEndEndsALine) {
  EXPECT_EQ(lines_of("a\nb\n"), (Lines{"a", "b"}));
  EXPECT_EQ(lines_of("a\r\nb\r\n"), (Lines{"a", "b"}));
  EXPECT_EQ(lines_of("a\rb\r"), (Lines{"a", "b"}));
  EXPECT_EQ(lines_of("a\rb\nc\r\nd"), (Lines{"a", "b", "c", "d"}));
}

TEST(LineCursor, EmptyLinesCount) {
  EXPECT_EQ(lines_of("\n\r\n\r\r\na"), (Lines{"", "", "", "", "a"}));
}

TEST(LineCursor, ALastLineNeedsNoEnd) {
  EXPECT_EQ(lines_of("a"), Lines{"a"});
  EXPECT_EQ(lines_of(""), Lines{});
}

TEST(LineCursor, ACopyGoesItsOwnWay) {
  LineCursor cursor("a\nb\nc\n");
  cursor.next();
  LineCursor copy = cursor;
  cursor.next();
  EXPECT_EQ(copy.next().text, "b");
  EXPECT_EQ(cursor.next().text, "c");
  EXPECT_EQ(copy.offset(), 4U);
}

TEST(LineCursor, APlaceIsTakenUpAgain) {
  LineCursor cursor("a\r\nb\nc\n");
  cursor.next();
  const LinePlace place = cursor.place();
  const std::string moved = "a\r\nb\nc\n";
  LineCursor again(moved, place);
  EXPECT_EQ(again.line_number(), 2);
  EXPECT_EQ(again.next().text, "b");
}

TEST(SourceText, KeepsEveryByteAndTheName) {
  const auto path = std::filesystem::temp_directory_path() / "panelcal_source_text_test.exc";
  std::ofstream(path, std::ios::binary) << std::string("M48\r\n\0\xff", 7);
  const auto source = read_source(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(source);
  EXPECT_EQ(source->bytes, std::string("M48\r\n\0\xff", 7));
  EXPECT_EQ(source->file, path.string());
}

TEST(SourceText, AByteOrderMarkIsNoPartOfTheProgram) {
  const auto path = std::filesystem::temp_directory_path() / "panelcal_byte_order_test.exc";
  std::ofstream(path, std::ios::binary) << "\xEF\xBB\xBFM48\n";
  const auto source = read_source(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(source);
  EXPECT_EQ(source->bytes, "M48\n");
}

TEST(SourceText, SaysWhichFileIsMissing) {
  EXPECT_THAT(read_source("no/such/file.exc"), FailsWith(Code::FileUnreadable, "no/such/file.exc"));
}

TEST(LastLine, MayBeIncomplete) {
  for (const char* text : {"A\nB", "A\nB\n", "A\rB\r", "A\n\rB\n\r", "A\r\nB\r\n"}) {
    EXPECT_EQ(last_line(text).text, "B");
    EXPECT_EQ(last_line(text).number, 2);
  }
  EXPECT_EQ(last_line("A\n\n").text, "");
  EXPECT_EQ(last_line("").text, "");
  EXPECT_EQ(last_line("").number, 1);
}

TEST(LastLine, IsCompleteWithALineEnd) {
  for (const char* text : {"A\n", "A\r", "A\r\n", "A\n\r"}) EXPECT_TRUE(ends_in_line_end(text));
  for (const char* text : {"", "A", "A\nB"}) EXPECT_FALSE(ends_in_line_end(text));
}

}  // namespace
}  // namespace panelcal
