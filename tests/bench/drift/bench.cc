// SPDX-License-Identifier: Apache-2.0
// Which chart catches which fault, and when: simulated years, all methods at one rate of false
// alarms. The tables in ../README.md.
//
//   drift_bench faults [YEARS]   nights until a fault is caught, by method
//   drift_bench season [YEARS]   a year with and without its temperature noted
#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "tests/bench/drift/faults.h"
#include "tests/bench/drift/season.h"
#include "tests/bench/drift/trial.h"

namespace panelcal::bench {
namespace {

/// Adds the age at which each method caught the fault of a year whose first nights have been seen.
void watch(const Fault& fault,
           Year& year,
           int onset,
           Learner learner,
           std::vector<Detector> detectors,
           std::vector<Catches>& catches) {
  constexpr int kWatched = 60;
  const int n_nights = fault.shape == FaultShape::Ramp ? kNightsOfAYear - onset : kWatched;
  std::vector<std::optional<int>> ages(detectors.size());
  int broken = n_nights + 1;
  for (int age = 1; age <= n_nights; ++age) {
    if (Year::is_broken(fault, age)) broken = std::min(broken, age);
    const Look look = learner.add(year.night(onset + age - 1, fault, onset));
    for (std::size_t k = 0; k < detectors.size(); ++k) {
      if (!ages[k] && detectors[k].add(look)) ages[k] = age;
    }
    if (std::ranges::all_of(ages, [](const auto& a) { return a.has_value(); })) break;
  }
  for (std::size_t k = 0; k < ages.size(); ++k) {
    catches[k].add(ages[k], ages[k] && *ages[k] <= broken);
  }
}

void print_faults(Channel channel, int n_years) {
  const auto healthy = healthy_looks(n_years, channel, kSeed);
  std::vector<Detector> fresh;
  std::string head = "| fault |";
  std::string line = "| --- |";
  std::string rates = "| alarms in 1000 healthy nights |";
  for (const Method& method : methods(channel)) {
    fresh.push_back(tuned(method, channel, healthy, method.nights_per_false_alarm));
    head += fmt::format(" {}{} |", method.name, method.has_moved ? ", moved" : "");
    line += " --- |";
    rates += fmt::format(" {:.2f} |", 1000 * alarms_a_night(healthy, fresh.back()));
  }
  fmt::print("{}\n{}\n{}\n", head, line, rates);
  const std::vector<Fault> all = faults(channel);
  std::vector<std::vector<Catches>> catches(all.size(), std::vector<Catches>(fresh.size()));
  const Learner unlearned(channel);
  for (int i = 0; i < n_years; ++i) {
    const std::uint64_t seed = kSeed + 1'000'000 + static_cast<std::uint64_t>(i);
    Year year(seed, 0);
    const int onset = onset_of(seed);
    Learner learner = unlearned;
    std::vector<Detector> detectors = fresh;
    for (int night = 0; night < onset; ++night) {
      const Look look = learner.add(year.night(night, {}, onset));
      for (Detector& detector : detectors) static_cast<void>(detector.add(look));
    }
    for (std::size_t k = 0; k < all.size(); ++k) {
      watch(all[k], year, onset, learner, detectors, catches[k]);
    }
  }
  for (std::size_t k = 0; k < all.size(); ++k) {
    fmt::print("| {} |", all[k].name);
    for (const Catches& one : catches[k]) fmt::print(" {} |", one.text());
    fmt::print("\n");
  }
  fmt::print("\n");
}

}  // namespace

int run(const std::string& what, int n_years) {
  if (what == "faults") {
    for (const Channel channel : {Channel::Offset, Channel::Scatter, Channel::Contrast}) {
      print_faults(channel, n_years);
    }
    return 0;
  }
  if (what == "season") return print_season(n_years, kSeed);
  return 2;
}

}  // namespace panelcal::bench

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  const int n_years = argc > 2 ? std::atoi(argv[2]) : 400;
  const int code = n_years < 1 || argc > 3 ? 2 : panelcal::bench::run(what, n_years);
  if (code == 2) fmt::print(stderr, "usage: drift_bench faults|season [YEARS]\n");
  return code;
}
