// SPDX-License-Identifier: Apache-2.0
// The fuzzer's seeds, and seeds with bytes changed at random, as ordinary tests.
#include <filesystem>
#include <string>

#include "calib/base/files/atomic_file.h"
#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

#include "tests/fuzz/changed_bytes.h"
#include "tests/fuzz/probe_file_entry.h"
#include "tests/support/folders.h"

namespace panelcal {
namespace {

namespace fs = std::filesystem;

TEST(ProbeFileFuzz, AnyBytesGiveAValueOrADiagnostic) {
  constexpr int kChanged = 500;
  const fs::path corpus = test::source_folder() / "tests" / "fuzz" / "corpus" / "probe_file";
  Random random(92);
  int n_seeds = 0;
  for (const auto& entry : fs::directory_iterator(corpus)) {
    ++n_seeds;
    const auto bytes = read_file(entry.path());
    ASSERT_TRUE(bytes) << bytes.error().text();
    EXPECT_EQ(fuzz::run_probe_file(*bytes), std::nullopt) << entry.path();
    for (int i = 0; i < kChanged; ++i) {
      const std::string other = fuzz::changed(random, *bytes);
      ASSERT_EQ(fuzz::run_probe_file(other), std::nullopt) << entry.path() << '\n' << other;
    }
  }
  EXPECT_GE(n_seeds, 24);
}

}  // namespace
}  // namespace panelcal
