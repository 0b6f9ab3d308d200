// SPDX-License-Identifier: Apache-2.0
// libFuzzer target; tests/fuzz/README.md says how to run it.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "tests/fuzz/map_file_entry.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto complaint = panelcal::fuzz::run_map_file({reinterpret_cast<const char*>(data), size});
  if (complaint) {
    std::fprintf(stderr, "%s\n", complaint->c_str());
    std::abort();
  }
  return 0;
}
