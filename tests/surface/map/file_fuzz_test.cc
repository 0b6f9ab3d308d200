// SPDX-License-Identifier: Apache-2.0
// The fuzzer's seeds, and seeds with bytes changed at random, as ordinary tests.
#include <filesystem>
#include <string>

#include "calib/base/files/atomic_file.h"
#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

#include "tests/fuzz/changed_bytes.h"
#include "tests/fuzz/map_file_entry.h"
#include "tests/support/folders.h"

namespace panelcal {
namespace {

namespace fs = std::filesystem;

TEST(MapFileFuzz, AnyBytesGiveAMapOrADiagnostic) {
  constexpr int kChanged = 100;
  const fs::path corpus = test::source_folder() / "tests" / "fuzz" / "corpus" / "map_file";
  Random random(93);
  int n_seeds = 0;
  for (const auto& entry : fs::directory_iterator(corpus)) {
    ++n_seeds;
    const auto bytes = read_file(entry.path());
    ASSERT_TRUE(bytes) << bytes.error().text();
    ASSERT_LE(bytes->size(), fuzz::kMostFuzzedMap) << entry.path();
    EXPECT_TRUE(parse_zoned_map_file(*bytes, "fuzz")) << entry.path();
    EXPECT_EQ(fuzz::run_map_file(*bytes), std::nullopt) << entry.path();
    for (int i = 0; i < kChanged; ++i) {
      const std::string input = fuzz::changed(random, *bytes);
      ASSERT_EQ(fuzz::run_map_file(input), std::nullopt) << entry.path() << "\n" << input;
    }
  }
  EXPECT_GE(n_seeds, 6);
}

}  // namespace
}  // namespace panelcal
