// SPDX-License-Identifier: Apache-2.0
// The fuzzer's seeds, and seeds with bytes changed at random, as ordinary tests.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "panelcal/calib/base/atomic_file.h"
#include "panelcal/calib/base/random.h"
#include "tests/fuzz/probe_file_entry.h"

namespace panelcal {
namespace {

namespace fs = std::filesystem;

/// Bytes that readers look at.
constexpr std::string_view kBytes = "0123456789.,-+eE<>/\"'={}[]: \t\r\nXYn\xff\0";

std::string changed(Random& random, std::string bytes) {
  const int n_changes = 1 + static_cast<int>(random.uniform(0, 4));
  for (int i = 0; i < n_changes; ++i) {
    const auto at = static_cast<std::size_t>(random.uniform(0, static_cast<double>(bytes.size())));
    const auto byte =
        static_cast<std::size_t>(random.uniform(0, static_cast<double>(kBytes.size())));
    const double kind = random.uniform();
    if (kind < 0.6) {
      bytes[at] = kBytes[byte];
    } else if (kind < 0.8) {
      bytes.insert(at, 1, kBytes[byte]);
    } else {
      bytes.erase(at, 1 + static_cast<std::size_t>(random.uniform(0, 9)));
    }
    if (bytes.empty()) break;
  }
  return bytes;
}

TEST(ProbeFileFuzz, AnyBytesGiveAValueOrADiagnostic) {
  constexpr int kChanged = 2000;
  const fs::path corpus =
      fs::path(PANELCAL_SOURCE_DIR) / "tests" / "fuzz" / "corpus" / "probe_file";
  Random random(92);
  int n_seeds = 0;
  for (const auto& entry : fs::directory_iterator(corpus)) {
    ++n_seeds;
    const auto bytes = read_file(entry.path());
    ASSERT_TRUE(bytes) << bytes.error().text();
    EXPECT_EQ(fuzz::run_probe_file(*bytes), std::nullopt) << entry.path();
    for (int i = 0; i < kChanged; ++i) {
      const std::string other = changed(random, *bytes);
      ASSERT_EQ(fuzz::run_probe_file(other), std::nullopt) << entry.path() << '\n' << other;
    }
  }
  EXPECT_GE(n_seeds, 6);
}

}  // namespace
}  // namespace panelcal
