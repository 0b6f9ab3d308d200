// SPDX-License-Identifier: Apache-2.0
// Runs every input that once broke a reader, and the fuzzers' seeds, as ordinary tests.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include <gtest/gtest.h>

#include "tests/fuzz/excellon_entry.h"
#include "tests/fuzz/gcode_entry.h"
#include "tests/fuzz/sieb_meyer_entry.h"
#include "tests/support/folders.h"

namespace panelcal {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

void expect_no_complaint(const fs::path& folder) {
  const std::vector<fs::path> files = files_in(folder);
  EXPECT_FALSE(files.empty()) << folder;
  for (const fs::path& file : files) {
    const auto bytes = read_file(file);
    ASSERT_TRUE(bytes) << file;
    const fs::path kind = file.extension();
    EXPECT_EQ(kind == ".sm5"   ? fuzz::run_sieb_meyer(*bytes)
              : kind == ".ngc" ? fuzz::run_gcode(*bytes)
                               : fuzz::run_excellon(*bytes),
              std::nullopt)
        << file;
  }
}

const fs::path kFuzz = test::source_folder() / "tests" / "fuzz";

TEST(FuzzFixed, InputsThatOnceBrokeTheReaderStayFixed) {
  expect_no_complaint(kFuzz / "fixed");
}

TEST(FuzzFixed, SeedsOfTheExcellonReaderRun) {
  expect_no_complaint(kFuzz / "corpus" / "excellon");
}

TEST(FuzzFixed, SeedsOfTheSiebMeyerReaderRun) {
  expect_no_complaint(kFuzz / "corpus" / "sieb_meyer");
}

TEST(FuzzFixed, SeedsOfTheGcodeReaderRun) {
  expect_no_complaint(kFuzz / "corpus" / "gcode");
}

TEST(FuzzFixed, BytesThatAreNoSiebMeyerProgramAreRefusedInOrder) {
  const std::string head = "%%5000\n";
  for (const std::string& bytes : {std::string(),
                                   std::string("$"),
                                   std::string("\0\xff\xfe", 3),
                                   std::string(100'000, '%'),
                                   std::string(100'000, '$'),
                                   std::string(100'000, '/'),
                                   head + "X" + std::string(100'000, '1'),
                                   head + "X1Y1(" + std::string(1'000'000, 'A')}) {
    EXPECT_EQ(fuzz::run_sieb_meyer(bytes), std::nullopt) << bytes.substr(0, 20);
  }
}

TEST(FuzzFixed, BytesThatAreNoProgramAreRefusedInOrder) {
  EXPECT_EQ(fuzz::run_excellon(""), std::nullopt);
  EXPECT_EQ(fuzz::run_excellon(std::string_view("\0\xff\xfe", 3)), std::nullopt);
  EXPECT_EQ(fuzz::run_excellon(std::string(100'000, 'X')), std::nullopt);
  EXPECT_EQ(fuzz::run_excellon(std::string(100'000, '%')), std::nullopt);
  EXPECT_EQ(fuzz::run_excellon(std::string(100'000, ',')), std::nullopt);
}

}  // namespace
}  // namespace panelcal
