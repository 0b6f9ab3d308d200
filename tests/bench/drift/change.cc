// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/drift/change.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "calib/drift/change_point.h"
#include <fmt/format.h>

#include "tests/bench/drift/faults.h"
#include "tests/bench/drift/trial.h"

namespace panelcal::bench {
namespace {

/// As the nights ask it (machine/nightly/night_outlook.cc).
constexpr std::size_t kSearched = 60;
constexpr double kTold = 0.95;
constexpr int kLater = 10;
/// One false alarm of find_change is followed by others while its window holds the same nights.
constexpr int kQuiet = 30;
constexpr int kFirstSearched = 60;
constexpr int kLastSearched = 240;
constexpr int kWatched = 45;

/// The last nights, and the probability that something has changed in them.
class Window {
 public:
  void add(const DriftPoint& point) {
    if (series_.points.size() == kSearched) series_.points.erase(series_.points.begin());
    series_.points.push_back(point);
  }
  ChangeFound search() const { return find_change(series_, {}).value(); }
  /// As a logarithm of odds, so that a limit far out is one.
  double odds() const {
    const ChangeFound found = search();
    const double p = found.kind == ChangeKind::None ? 1 - found.probability : found.probability;
    return std::log(p / std::max(1 - p, 1e-300));
  }
  std::size_t size() const { return series_.points.size(); }

 private:
  DriftSeries series_ = {{"x", "y"}, "mm", {}};
};

/// The limit of the odds that gives one false alarm in this number of healthy nights.
double odds_limit(const std::vector<std::vector<double>>& odds, double nights) {
  double low = -10;
  double high = 100;
  constexpr int kHalvings = 40;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    double n_alarms = 0;
    double n_nights = 0;
    for (const std::vector<double>& year : odds) {
      int quiet = 0;
      for (const double one : year) {
        n_nights += 1;
        if (--quiet > 0 || !(one > middle)) continue;
        n_alarms += 1;
        quiet = kQuiet;
      }
    }
    (n_alarms * nights > n_nights ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

std::vector<std::vector<double>> healthy_odds(int n_years, std::uint64_t seed) {
  std::vector<std::vector<double>> out;
  for (int i = 0; i < n_years; ++i) {
    Year year(seed + static_cast<std::uint64_t>(i), 0);
    Window window;
    std::vector<double>& odds = out.emplace_back();
    for (int night = 0; night < kLastSearched; ++night) {
      window.add(year.night(night, {}, kNightsOfAYear).offset);
      if (night >= kFirstSearched) odds.push_back(window.odds());
    }
  }
  return out;
}

/// The first night of a change as cumulative sums know it: since when the largest was not zero. A
/// night that is an alarm by itself is its own date.
class SumDate {
 public:
  void add(const Look& look) {
    ++night_;
    if (!look.is_judged) return;
    constexpr double kAllowance = 0.25;
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      const double u = look.scores(static_cast<Eigen::Index>(i / 2)) * (i % 2 == 0 ? 1 : -1);
      if (sums_[i] <= 0) since_[i] = night_;
      sums_[i] = std::max(0.0, sums_[i] + u - kAllowance);
    }
  }
  int night() const {
    const auto largest = std::ranges::max_element(sums_) - sums_.begin();
    return since_[static_cast<std::size_t>(largest)];
  }

 private:
  int night_ = -1;
  std::array<double, 4> sums_{};
  std::array<int, 4> since_{};
};

/// Errors of dates in nights; absent where nothing is told.
class Dates {
 public:
  void add(std::optional<double> error) {
    ++n_;
    if (error) errors_.push_back(std::abs(*error));
  }
  std::string text() const {
    if (errors_.empty()) return "0 %";
    std::vector<double> sorted = errors_;
    std::ranges::sort(sorted);
    return fmt::format("{:.0f} %, {:.0f} ({:.0f})",
                       100.0 * static_cast<double>(sorted.size()) / n_,
                       sorted[sorted.size() / 2],
                       sorted[sorted.size() * 9 / 10]);
  }

 private:
  std::vector<double> errors_;
  int n_ = 0;
};

std::optional<double> error_of(const Window& window, int night, int onset) {
  const ChangeFound found = window.search();
  if (found.kind == ChangeKind::None || found.probability < kTold) return std::nullopt;
  const int first = night + 1 - static_cast<int>(window.size());
  return first + static_cast<int>(found.i_night) - onset;
}

struct ChangeRow {
  std::array<Catches, 4> catches;  ///< charts, find_change, both, find_change as it is told
  Dates by_charts, at_alarm, later;
};

struct Limits {
  Detector charts, half_of_charts;
  double odds, half_of_odds;
};

struct Start {
  Learner learner;
  Limits limits;
  Window window;
  SumDate sums;
};

void follow(const Fault& fault, Year& year, int onset, Start at, ChangeRow& row) {
  std::array<std::optional<int>, 4> ages;
  int broken = kWatched + 1;
  for (int age = 1; age <= kWatched; ++age) {
    if (Year::is_broken(fault, age)) broken = std::min(broken, age);
    const int night = onset + age - 1;
    const Year::Night seen = year.night(night, fault, onset);
    const Look look = at.learner.add(seen);
    at.window.add(seen.offset);
    at.sums.add(look);
    const auto note = [age](std::optional<int>& at_age, bool is_caught) {
      if (!at_age && is_caught) at_age = age;
    };
    const bool is_alarm = at.limits.charts.add(look);
    if (is_alarm && !ages[0]) {
      row.by_charts.add(at.limits.charts.was_night() ? age - 1 : at.sums.night() - onset);
      row.at_alarm.add(error_of(at.window, night, onset));
    }
    note(ages[0], is_alarm);
    if (ages[0] && age == *ages[0] + kLater) row.later.add(error_of(at.window, night, onset));
    const bool needs_odds = !ages[1] || !ages[2] || !ages[3];
    const double odds = needs_odds ? at.window.odds() : 0;
    note(ages[1], odds > at.limits.odds);
    note(ages[2], at.limits.half_of_charts.add(look) || odds > at.limits.half_of_odds);
    note(ages[3], odds > std::log(kTold / (1 - kTold)));
    if (!needs_odds && ages[0] && age > *ages[0] + kLater) break;
  }
  for (std::size_t k = 0; k < ages.size(); ++k) {
    row.catches[k].add(ages[k], ages[k] && *ages[k] <= broken);
  }
}

}  // namespace

int print_changes(int n_years, std::uint64_t seed) {
  const Method all = methods(Channel::Offset)[6];
  const auto healthy = healthy_looks(n_years, Channel::Offset, seed);
  const auto odds = healthy_odds(n_years, seed);
  const Limits fresh = {tuned(all, Channel::Offset, healthy, all.nights_per_false_alarm),
                        tuned(all, Channel::Offset, healthy, 2 * all.nights_per_false_alarm),
                        odds_limit(odds, all.nights_per_false_alarm),
                        odds_limit(odds, 2 * all.nights_per_false_alarm)};
  fmt::print("limits of the probability: {:.6f}, {:.6f}\n",
             1 / (1 + std::exp(-fresh.odds)),
             1 / (1 + std::exp(-fresh.half_of_odds)));
  std::vector<Fault> some;
  for (const Fault& fault : faults(Channel::Offset)) {
    const bool is_slow = fault.shape == FaultShape::Ramp && fault.size < 0.3;
    if (!is_slow && fault.shape != FaultShape::Temperature) some.push_back(fault);
  }
  std::vector<ChangeRow> rows(some.size());
  for (int i = 0; i < n_years; ++i) {
    const std::uint64_t of_year = seed + 1'000'000 + static_cast<std::uint64_t>(i);
    Year year(of_year, 0);
    const int onset = onset_of(of_year);
    Start start = {Learner(Channel::Offset), fresh, {}, {}};
    for (int night = 0; night < onset; ++night) {
      const Year::Night seen = year.night(night, {}, onset);
      const Look look = start.learner.add(seen);
      start.window.add(seen.offset);
      start.sums.add(look);
      static_cast<void>(start.limits.charts.add(look));
      static_cast<void>(start.limits.half_of_charts.add(look));
    }
    for (std::size_t k = 0; k < some.size(); ++k) follow(some[k], year, onset, start, rows[k]);
  }
  fmt::print(
      "| fault | night, EWMA, CUSUM | find_change | both | find_change at 0.95 | date by charts | "
      "by "
      "find_change in that night | {} nights later |\n| --- | --- | --- | --- | --- | --- | --- | "
      "--- |\n",
      kLater);
  for (std::size_t k = 0; k < some.size(); ++k) {
    const ChangeRow& row = rows[k];
    fmt::print("| {} |", some[k].name);
    for (const Catches& one : row.catches) fmt::print(" {} |", one.text());
    fmt::print(" {} | {} | {} |\n", row.by_charts.text(), row.at_alarm.text(), row.later.text());
  }
  return 0;
}

}  // namespace panelcal::bench
