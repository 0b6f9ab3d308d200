// SPDX-License-Identifier: Apache-2.0
// The floor that command_speed.py holds whole commands against, measured on one file: seconds of
// processor time of the floor, the median of five, and of libgerbv's load.
#include <algorithm>
#include <array>
#include <exception>

#include "calib/base/files/atomic_file.h"
#include <fmt/format.h>

#include "tests/bench/bench_peers.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: command_floor FILE\n");
    return 2;
  }
  try {
    const auto text = panelcal::read_file(argv[1]);
    if (!text) {
      fmt::print(stderr, "{}\n", text.error().text());
      return 2;
    }
    std::array<double, 5> floors_s{};
    for (double& floor_s : floors_s) floor_s = panelcal::bench::from_chars_floor_s(*text);
    std::ranges::sort(floors_s);
    const auto gerbv_s = panelcal::bench::libgerbv_load_s(argv[1]);
    fmt::print("{:.9f} {}\n", floors_s[2], gerbv_s ? fmt::format("{:.9f}", *gerbv_s) : "missing");
  } catch (const std::exception& error) {
    fmt::print(stderr, "command_floor: {}\n", error.what());
    return 1;
  }
}
