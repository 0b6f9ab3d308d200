// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/bench/drift/detector.h"

namespace panelcal::bench {

inline constexpr std::uint64_t kSeed = 20261127;

/// Years in which nothing happens, as charts see them.
std::vector<std::vector<Look>> healthy_looks(int n_years, Channel channel, std::uint64_t seed);

double alarms_a_night(const std::vector<std::vector<Look>>& years, const Detector& fresh);

/// The method with limits that give one false alarm in this number of healthy nights; a move beyond
/// the limit is true when it comes, and does not count.
Detector tuned(const Method& method,
               Channel channel,
               const std::vector<std::vector<Look>>& healthy,
               double nights);

/// How soon one method caught one fault, over the years.
class Catches {
 public:
  void add(std::optional<int> age, bool in_time);
  /// "2 / 98 %": the median of the nights (1: the fault's first), the share in time.
  std::string text() const;

 private:
  std::vector<double> ages_;
  int n_in_time_ = 0;
};

}  // namespace panelcal::bench
