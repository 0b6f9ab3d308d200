// SPDX-License-Identifier: Apache-2.0
// Runs every input that once broke the reader, and the fuzzer's seeds, as ordinary tests.
#include <algorithm>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include "panelcal/calib/base/atomic_file.h"
#include "tests/fuzz/excellon_entry.h"

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
    EXPECT_EQ(fuzz::run_excellon(*bytes), std::nullopt) << file;
  }
}

const fs::path kFuzz = fs::path(PANELCAL_SOURCE_DIR) / "tests" / "fuzz";

TEST(FuzzFixed, InputsThatOnceBrokeTheReaderStayFixed) {
  expect_no_complaint(kFuzz / "fixed");
}

TEST(FuzzFixed, SeedsOfTheExcellonReaderRun) {
  expect_no_complaint(kFuzz / "corpus" / "excellon");
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
