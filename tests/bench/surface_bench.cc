// SPDX-License-Identifier: Apache-2.0
// Time and errors of heights of a probed surface; surface_peers.py holds both against scipy.
//
//   surface_bench speed [QUERIES]     against OpenCV's remap, one core, turn by turn, 10,000 places
//                                     at once and all of them, in the order of a drill program and
//                                     at random
//   surface_bench accuracy FOLDER     50 warps: probes, places with truth and our heights, as text
//
// Columns of speed: ns a query, the best of the rounds; then the median over the rounds of our time
// by the peer's of the same round. OpenCV interpolates single precision at places rounded to 1/32
// of a cell; ours are doubles throughout.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "calib/base/statistics/random.h"
#include "surface/map/height_lattice.h"
#include "surface/map/height_map.h"
#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/surface/fit/simulated_warp.h"

namespace panelcal::bench {
namespace {

using Eigen::Vector2d;

constexpr int kNodes = 200;
constexpr int kRounds = 9;
constexpr int kAtOnce = 10'000;
constexpr std::uint64_t kSeed = 20261122;
constexpr int kWarps = 50;
constexpr int kPlaces = 2000;

/// Of this thread alone: others on the machine take none of it.
double seconds_of(const auto& work) {
  const auto now = [] {
    timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  const double begin = now();
  work();
  return now() - begin;
}

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

/// As programs go through a panel: board by board and on each row by row, to and fro. Holes of a
/// row and rows stand off their pitch by up to half of it.
std::vector<Vector2d> in_program_order(Random& random, int n) {
  constexpr int kBoards = 6;  // along each side
  constexpr double kBoard = (kNodes - 3.0) / kBoards;
  const int n_side = std::max(1, static_cast<int>(std::ceil(std::sqrt(n) / kBoards)));
  const double pitch = kBoard / n_side;
  const auto to_and_fro = [](int i_row, int i, int n_all) {
    return i_row % 2 == 0 ? i : n_all - 1 - i;
  };
  std::vector<Vector2d> out;
  for (int board = 0; board < kBoards * kBoards; ++board) {
    const int column = to_and_fro(board / kBoards, board % kBoards, kBoards);
    const Vector2d corner(1 + column * kBoard, 1 + board / kBoards * kBoard);
    for (int row = 0; row < n_side; ++row) {
      const double y = pitch * (row + random.uniform());
      for (int k = 0; k < n_side && static_cast<int>(out.size()) < n; ++k) {
        const double x = pitch * (to_and_fro(row, k, n_side) + random.uniform());
        out.push_back(corner + Vector2d(x, y));
      }
    }
  }
  return out;
}

std::vector<Vector2d> at_random(Random& random, int n) {
  std::vector<Vector2d> out;
  for (int k = 0; k < n; ++k) {
    const double x = random.uniform(1, kNodes - 2);
    out.emplace_back(x, random.uniform(1, kNodes - 2));
  }
  return out;
}

/// The same lattice and places for all.
struct Queries {
  LatticeAxis axis{0, 1, kNodes};
  std::vector<double> heights_mm;
  std::vector<Vector2d> places_mm;
  cv::Mat image, x_map, y_map;

  Queries(int n, bool is_random) {
    Random random(kSeed);
    const test::SimulatedWarp warp(random, 1);
    image.create(kNodes, kNodes, CV_32F);
    for (int j = 0; j < kNodes; ++j) {
      for (int i = 0; i < kNodes; ++i) {
        const double height_mm = warp(Vector2d(i - 0.5 * kNodes, j - 0.5 * kNodes));
        heights_mm.push_back(height_mm);
        image.at<float>(j, i) = static_cast<float>(height_mm);
      }
    }
    // remap's pictures have fewer than 32768 columns and rows.
    constexpr int kColumns = 1000;
    const int n_rows = std::max(1, n / kColumns);
    x_map.create(n_rows, kColumns, CV_32F);
    y_map.create(n_rows, kColumns, CV_32F);
    n = n_rows * kColumns;
    places_mm = is_random ? at_random(random, n) : in_program_order(random, n);
    for (int k = 0; k < n; ++k) {
      const Vector2d& p_mm = places_mm[static_cast<std::size_t>(k)];
      x_map.at<float>(k / kColumns, k % kColumns) = static_cast<float>(p_mm.x());
      y_map.at<float>(k / kColumns, k % kColumns) = static_cast<float>(p_mm.y());
    }
  }
};

void compare(const Queries& queries,
             int n_times,
             LatticeInterpolation ours,
             int peer,
             std::string_view order) {
  const auto lattice = HeightLattice::make(queries.axis, queries.axis, queries.heights_mm, ours);
  std::vector<double> found_mm(queries.places_mm.size());
  cv::Mat remapped;
  double best_s = std::numeric_limits<double>::infinity(), best_peer_s = best_s;
  std::vector<double> ratios;
  for (int round = 0; round < kRounds; ++round) {
    const double ours_s = seconds_of([&] {
      for (int k = 0; k < n_times; ++k) lattice->heights_mm(queries.places_mm, found_mm, {});
    });
    const double peer_s = seconds_of([&] {
      for (int k = 0; k < n_times; ++k) {
        cv::remap(queries.image, remapped, queries.x_map, queries.y_map, peer);
      }
    });
    best_s = std::min(best_s, ours_s);
    best_peer_s = std::min(best_peer_s, peer_s);
    ratios.push_back(ours_s / peer_s);
  }
  double worst_mm = 0;
  for (std::size_t k = 0; k < found_mm.size(); ++k) {
    const double other_mm = remapped.at<float>(static_cast<int>(k) / remapped.cols,
                                               static_cast<int>(k) % remapped.cols);
    worst_mm = std::max(worst_mm, std::abs(found_mm[k] - other_mm));
  }
  const double to_ns = 1e9 / static_cast<double>(found_mm.size()) / n_times;
  fmt::print("| {}, {} at once, {} | {:.2f} | {:.2f} | {:.2f} | {:.2g} |\n",
             ours == LatticeInterpolation::Bilinear ? "bilinear" : "bicubic",
             found_mm.size(),
             order,
             best_s * to_ns,
             best_peer_s * to_ns,
             median(std::move(ratios)),
             worst_mm);
}

int run_speed(int n_queries) {
  cv::setNumThreads(1);
  fmt::print("| | ours ns | remap ns | ours / remap | greatest difference mm |\n");
  fmt::print("| --- | --- | --- | --- | --- |\n");
  // So many at once as stay in the cache, then all: these measure memory as well.
  for (const int at_once : {std::min(kAtOnce, n_queries), n_queries}) {
    const int n_times = std::max(1, n_queries / at_once);
    for (const bool is_random : {false, true}) {
      const Queries queries(at_once, is_random);
      const char* order = is_random ? "at random" : "program order";
      compare(queries, n_times, LatticeInterpolation::Bilinear, cv::INTER_LINEAR, order);
      compare(queries, n_times, LatticeInterpolation::MonotoneBicubic, cv::INTER_CUBIC, order);
    }
  }
  return 0;
}

/// Probes `x y z sigma`, and behind an empty line `x y truth ours`, mm.
int run_accuracy(const std::filesystem::path& folder) {
  for (int k = 0; k < kWarps; ++k) {
    Random random = Random(kSeed).fork(static_cast<std::uint64_t>(k));
    const test::SimulatedWarp warp(random, 1);
    const auto probes = test::probed_lattice(random, warp, 12, 10);
    const auto map = HeightMap::of_probes(probes);
    if (!map) {
      fmt::print(stderr, "{}\n", map.error().text());
      return 1;
    }
    std::string text;
    for (const ProbePoint& probe : probes) {
      text += fmt::format("{} {} {} {}\n",
                          probe.place.in_mm().x(),
                          probe.place.in_mm().y(),
                          probe.measured.height.in_mm(),
                          probe.measured.sigma.in_mm());
    }
    text += '\n';
    for (int i = 0; i < kPlaces; ++i) {
      const Vector2d p_mm(random.uniform(-150, 150), random.uniform(-150, 150));
      const auto found = map->height_at(position_mm<frame::Nominal>(p_mm));
      text += fmt::format("{} {} {} {}\n", p_mm.x(), p_mm.y(), warp(p_mm), found->height.in_mm());
    }
    if (auto written = write_file(folder / fmt::format("{:02}.txt", k), text); !written) {
      fmt::print(stderr, "{}\n", written.error().text());
      return 3;
    }
  }
  return 0;
}

}  // namespace
}  // namespace panelcal::bench

int main(int argc, char** argv) {
  const std::string_view what = argc > 1 ? argv[1] : "";
  if (what == "speed")
    return panelcal::bench::run_speed(argc > 2 ? std::atoi(argv[2]) : 10'000'000);
  if (what == "accuracy" && argc > 2) return panelcal::bench::run_accuracy(argv[2]);
  std::fputs("surface_bench speed [QUERIES] | accuracy FOLDER\n", stderr);
  return 2;
}
