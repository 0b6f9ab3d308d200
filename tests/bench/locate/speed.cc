// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/locate/speed.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "tests/bench/locate/methods.h"

namespace panelcal::bench {
namespace {

constexpr int kPictures = 12;
constexpr int kRepetitions = 5;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The peers to beat: both ways of asking SimpleBlobDetector where it knows the shape.
std::vector<Method> peers_of(Shape shape) {
  std::vector<Method> methods = methods_for(shape);
  std::vector<Method> peers;
  for (Method& m : methods) {
    if (m.name.starts_with("SimpleBlob")) peers.push_back(std::move(m));
  }
  if (peers.empty()) peers.push_back(std::move(methods.at(1)));
  return peers;
}

/// Median over pictures of the best of interleaved repetitions; the quickest peer counts.
void print_row(const std::string& what,
               const Condition& condition,
               const Mark& mark,
               int width,
               int height,
               bool is_area_known,
               std::uint64_t seed) {
  const std::vector<Method> peers = peers_of(mark.shape);
  std::vector<double> ours_ms;
  std::vector<std::vector<double>> peers_ms(peers.size());
  int n_found = 0;
  for (int i = 0; i < kPictures; ++i) {
    Random random = Random(seed).fork(static_cast<std::uint64_t>(i));
    const Sample sample = draw_sample(condition, mark, width, height, random);
    const Question question{sample.image, mark, condition, sample.center_px};
    LocateOptions options;
    if (is_area_known) {
      options.search_center = position_px<frame::Image>(Eigen::Vector2d(
          sample.center_px + Eigen::Vector2d(random.uniform(-3, 3), random.uniform(-3, 3))));
      options.search_radius = px(10);
    }
    std::vector<double> least(peers.size() + 1, 1e9);
    for (int k = 0; k < kRepetitions; ++k) {
      const Answer ours = locate_answer(question, options);
      n_found += ours.is_found;
      least.back() = std::min(least.back(), ours.ms);
      for (std::size_t m = 0; m < peers.size(); ++m) {
        least[m] = std::min(least[m], peers[m].find(question).ms);
      }
    }
    ours_ms.push_back(least.back());
    for (std::size_t m = 0; m < peers.size(); ++m) peers_ms[m].push_back(least[m]);
  }
  double peer_ms = 1e9;
  for (const auto& ms : peers_ms) peer_ms = std::min(peer_ms, median(ms));
  fmt::print("  {:<44}{:<9}{:>9.3f}{:>12.3f}{:>8.2f}{:>9.0f}\n",
             what,
             condition.name,
             median(ours_ms),
             peer_ms,
             median(ours_ms) / peer_ms,
             100.0 * n_found / (kPictures * kRepetitions));
}

}  // namespace

void print_speed(const Mark& mark, std::uint64_t seed) {
  fmt::print(
      "\nspeed: ms of processor time, one thread; median of {} pictures, best of {} "
      "interleaved; peer {}, the quickest way to ask it\n",
      kPictures,
      kRepetitions,
      peers_of(mark.shape).front().name);
  fmt::print("  {:<44}{:<9}{:>9}{:>12}{:>8}{:>9}\n", "", "", "panelcal", "peer", "ratio", "found%");
  for (const Condition& c : conditions()) {
    print_row("160 x 160, search whole window", c, mark, 160, 160, false, seed);
    print_row("160 x 160, search 10 px around", c, mark, 160, 160, true, seed);
    print_row("640 x 480, search whole picture", c, mark, 640, 480, false, seed);
    print_row("640 x 480, search 10 px around", c, mark, 640, 480, true, seed);
    print_row("1280 x 1024, search whole picture", c, mark, 1280, 1024, false, seed);
  }
}

}  // namespace panelcal::bench
