// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/files/folder.h"

#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

std::string problem_of(std::string_view text) {
  const auto rows = parse_images_csv(text, "d/images.csv");
  return rows ? "" : test::brief(rows.error());
}

TEST(PictureFolder, ReadsRequiredAndOptionalColumns) {
  const auto rows = parse_images_csv(
      "seq,file,y,x,lamp,z,tool,zoom,time\n"
      "4,a.png,2.5,-1e1,ring,0.1,3,1.5,2026-01-01T00:00:00Z\n"
      "\n"
      ",sub/b.tif, 1 ,2,,,,,\n",
      "images.csv");
  ASSERT_TRUE(rows.has_value()) << rows.error().text();
  ASSERT_EQ(rows->size(), 2U);
  const PictureRow& first = rows->front();
  EXPECT_EQ(first.line, 2);
  EXPECT_EQ(first.file, "a.png");
  EXPECT_EQ(first.axis, position_mm<frame::Machine>(-10, 2.5));
  EXPECT_EQ(first.z, mm(0.1));
  EXPECT_EQ(first.tool, 3);
  EXPECT_EQ(first.lamp, "ring");
  EXPECT_EQ(first.zoom, 1.5);
  EXPECT_EQ(first.seq, 4);
  EXPECT_EQ(first.time, "2026-01-01T00:00:00Z");
  const PictureRow& second = rows->back();
  EXPECT_EQ(second.line, 4);
  EXPECT_EQ(second.file, "sub/b.tif");
  EXPECT_EQ(second.axis, position_mm<frame::Machine>(2, 1));
  EXPECT_FALSE(second.seq.has_value());
}

TEST(PictureFolder, AcceptsByteOrderMarkAndCrLf) {
  const auto rows = parse_images_csv(
      "\xEF\xBB\xBF"
      "file,x,y\r\na.png,1,2\r\n",
      "images.csv");
  ASSERT_TRUE(rows.has_value()) << rows.error().text();
  EXPECT_EQ(rows->front().file, "a.png");
}

TEST(PictureFolder, WhatIsWrittenReadsBackExactly) {
  PictureRow row;
  row.file = "p 01.png";
  row.axis = position_mm<frame::Machine>(0.1 + 0.2, -1e-17);
  row.seq = 7;
  row.z = mm(1.0 / 3);
  const std::string text = format_images_csv(std::vector{row});
  EXPECT_EQ(text, "file,x,y,z,seq\np 01.png,0.30000000000000004,-1e-17,0.3333333333333333,7\n");
  const auto rows = parse_images_csv(text, "images.csv");
  ASSERT_TRUE(rows.has_value());
  EXPECT_EQ(rows->front().axis, row.axis);
  EXPECT_EQ(rows->front().z, row.z);
  EXPECT_EQ(format_images_csv(*rows), text);
}

TEST(PictureFolder, ProblemsNamePlaceTextAndWhatWasExpected) {
  EXPECT_EQ(problem_of(""), "d/images.csv:1:1: error[images-csv]");
  EXPECT_EQ(problem_of("file,x\n"), "d/images.csv:1:1: error[images-csv]");
  EXPECT_EQ(problem_of("file,x,y,tol\n"), "d/images.csv:1:10: error[images-csv]");
  EXPECT_EQ(problem_of("file,x,y,x\n"), "d/images.csv:1:10: error[images-csv]");
  EXPECT_EQ(problem_of("file,x,y\n"), "d/images.csv:1:1: error[images-csv]");
  EXPECT_EQ(problem_of("file,x,y\na.png,1\n"), "d/images.csv:2:1: error[images-csv]");
  EXPECT_EQ(problem_of("file,x,y\na.png,1,2\nb.png, 1,5 mm\n"),
            "d/images.csv:3:10: error[images-csv]");
  EXPECT_EQ(problem_of("file,x,y\na.png,,2\n"), "d/images.csv:2:7: error[images-csv]");
  EXPECT_EQ(problem_of("file,x,y,tool\na.png,1,2,-3\n"), "d/images.csv:2:11: error[images-csv]");
}

TEST(PictureFolder, RefusesNumbersThatAreNone) {
  for (const char* number : {"nan", "inf", "1e999", "0x10", "1,5", "+1", "1.2.3", "\xC2\xB5"}) {
    EXPECT_NE(problem_of("file,x,y\na.png,1," + std::string(number) + "\n"), "") << number;
  }
}

TEST(PictureFolder, RefusesFilesOutsideOfTheFolder) {
  for (const char* file : {"../a.png", "a/../../b.png", "/etc/a.png", "..", "sub/"}) {
    EXPECT_EQ(problem_of("file,x,y\n" + std::string(file) + ",1,2\n"),
              "d/images.csv:2:1: error[images-csv]")
        << file;
  }
}

TEST(PictureFolder, RefusesBinaryAndQuotes) {
  EXPECT_EQ(problem_of(std::string_view("file,x,y\n\0a", 11)),
            "d/images.csv:1:1: error[images-csv]");
  EXPECT_NE(problem_of("file,x,y\n\"a,b.png\",1,2\n"), "");
  EXPECT_NE(problem_of("\x89PNG\r\n\x1A\n"), "");
}

TEST(PictureFolder, ReadsFromAFolderAndNamesAMissingOne) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "folder_test";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "images.csv") << "file,x,y\na.png,1,2\n";
  const auto found = read_picture_folder(folder);
  ASSERT_TRUE(found.has_value()) << found.error().text();
  EXPECT_EQ(found->path_of(found->rows.front()), folder / "a.png");
  const auto missing = read_picture_folder(folder / "none");
  ASSERT_FALSE(missing.has_value());
  EXPECT_EQ(missing.error().code, Code::FileUnreadable);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace panelcal
