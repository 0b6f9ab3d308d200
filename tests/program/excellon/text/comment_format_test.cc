// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/comment_format.h"

#include <string>

#include <gtest/gtest.h>

namespace panelcal::excellon {
namespace {

std::string said(std::string_view comment) {
  const CommentFormat format = read_comment_format(comment);
  std::string text;
  if (format.digits) {
    text += std::to_string(format.digits->first) + "." + std::to_string(format.digits->second);
  }
  if (format.unit) text += *format.unit == LengthUnit::Inch ? " inch" : " metric";
  if (format.zeros) text += *format.zeros == Zeros::LeadingKept ? " LZ" : " TZ";
  if (format.is_incremental) text += *format.is_incremental ? " incremental" : " absolute";
  return text;
}

TEST(CommentFormat, ReadsFileFormat) {
  EXPECT_EQ(said("; FILE_FORMAT=2:5"), "2.5");
  EXPECT_EQ(said(";FILE_FORMAT = 2:5 "), "2.5");
  EXPECT_EQ(said(";FILE_FORMAT"), "");
}

TEST(CommentFormat, ReadsFormatInBraces) {
  EXPECT_EQ(said(";FORMAT={3:3/ absolute}"), "3.3 absolute");
  EXPECT_EQ(said("; FORMAT={3:3/ absolute / metric / suppress leading zeros}"),
            "3.3 metric TZ absolute");
  EXPECT_EQ(said("; FORMAT={2:4/ incremental / inch / suppress trailing zeros}"),
            "2.4 inch LZ incremental");
  EXPECT_EQ(said("; FORMAT={-:-/ absolute / metric / decimal}"), " metric absolute");
}

/// gerbv's example of Mentor's output: `; Format  : 3.3 / Absolute / MM / Leading` with METRIC,TZ.
TEST(CommentFormat, ReadsMentorsPartsWhichNameTheZerosThatAreLeftOff) {
  EXPECT_EQ(said("; Format  : 3.3 / Absolute / MM / Leading"), "3.3 metric TZ absolute");
  EXPECT_EQ(said("; Format  : 2.4 / Incremental / Inch / Trailing"), "2.4 inch LZ incremental");
  EXPECT_EQ(said("; Format  : 2.5 / Absolute / Inch / None"), "2.5 inch absolute");
}

TEST(CommentFormat, NamesAPartOfMentorsThatSaysNothingKnown) {
  EXPECT_EQ(read_comment_format("; Format : 3.3 / Absolute / Furlong / Leading").unknown,
            "FURLONG");
  EXPECT_EQ(said("; Format : 3.3 / Absolute / MM / Suppress Leading"), "3.3 metric TZ absolute");
}

TEST(CommentFormat, ReadsNothingElse) {
  EXPECT_EQ(said("; 3:3"), "");
  EXPECT_EQ(said("; format of the panel: 3.3"), "");
  EXPECT_EQ(said(";FORMAT 3.3"), "");
  EXPECT_EQ(said("; Contents: Thru / Mill / Plated"), "");
}

}  // namespace
}  // namespace panelcal::excellon
