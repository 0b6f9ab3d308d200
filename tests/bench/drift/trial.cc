// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/drift/trial.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace panelcal::bench {

std::vector<std::vector<Look>> healthy_looks(int n_years, Channel channel, std::uint64_t seed) {
  const Learner fresh(channel);
  std::vector<std::vector<Look>> years;
  for (int i = 0; i < n_years; ++i) {
    Year year(seed + static_cast<std::uint64_t>(i), 0);
    Learner learner = fresh;
    std::vector<Look>& looks = years.emplace_back();
    for (int night = 0; night < kNightsOfAYear; ++night) {
      looks.push_back(learner.add(year.night(night, {}, kNightsOfAYear)));
    }
  }
  return years;
}

double alarms_a_night(const std::vector<std::vector<Look>>& years, const Detector& fresh) {
  double n_alarms = 0;
  double n_judged = 0;
  for (const std::vector<Look>& looks : years) {
    Detector detector = fresh;
    for (const Look& look : looks) {
      n_judged += look.is_judged ? 1 : 0;
      n_alarms += detector.add(look) ? 1 : 0;
    }
  }
  return n_alarms / n_judged;
}

Detector tuned(const Method& method,
               Channel channel,
               const std::vector<std::vector<Look>>& healthy,
               double nights) {
  Method charts = method;
  charts.has_moved = false;
  double low = std::log(30);
  double high = std::log(20000);
  constexpr int kHalvings = 14;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    const double rate = alarms_a_night(healthy, Detector(charts, channel, std::exp(middle)));
    (rate * nights > 1 ? low : high) = middle;
  }
  return Detector(method, channel, std::exp(0.5 * (low + high)));
}

void Catches::add(std::optional<int> age, bool in_time) {
  ages_.push_back(age ? *age : std::numeric_limits<double>::infinity());
  n_in_time_ += in_time ? 1 : 0;
}

std::string Catches::text() const {
  std::vector<double> sorted = ages_;
  std::ranges::sort(sorted);
  const double median = sorted[sorted.size() / 2];
  const std::string nights = std::isinf(median) ? "-" : fmt::format("{:.0f}", median);
  const double share = 100.0 * n_in_time_ / static_cast<double>(sorted.size());
  return fmt::format("{} / {:.0f} %", nights, share);
}

}  // namespace panelcal::bench
