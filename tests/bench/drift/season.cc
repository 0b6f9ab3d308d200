// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/drift/season.h"

#include <algorithm>
#include <functional>
#include <optional>

#include "calib/drift/monitor.h"
#include <fmt/format.h>

#include "tests/bench/drift/faults.h"
#include "tests/bench/drift/trial.h"

namespace panelcal::bench {
namespace {

constexpr double kSeason_K = 8;

struct SeasonRow {
  double n_alarms = 0;  ///< of the charts, in healthy years
  double n_moved = 0;
  int n_of_step = 0;  ///< alarms within three nights after the hall is warmer
  Catches step;
  Catches ramp;
};

bool is_chart(const DriftAlarm& alarm) {
  return alarm.chart != DriftChart::Moved;
}

/// The age of the fault at which a chart alarms or the value has moved.
std::optional<int> age_of_catch(
    Year& year, const Fault& fault, int onset, DriftMonitor monitor, bool is_noted, int n_nights) {
  for (int age = 1; age <= n_nights; ++age) {
    DriftPoint point = year.night(onset + age - 1, fault, onset).offset;
    if (!is_noted) point.temperature_c.reset();
    if (!monitor.add(point)->alarms.empty()) return age;
  }
  return std::nullopt;
}

SeasonRow season_row(int n_years, std::uint64_t seed, double season_K, bool is_noted) {
  constexpr Fault kStep = {"", Channel::Offset, FaultShape::Step, 5};
  constexpr Fault kRamp = {"", Channel::Offset, FaultShape::Ramp, 0.3};
  constexpr Fault kWarm = {"", Channel::Offset, FaultShape::Temperature, 8};
  constexpr int kMonth = 30;
  constexpr int kSoon = 3;
  const DriftMonitor fresh = *DriftMonitor::make(2, {}, {});
  SeasonRow row;
  for (int i = 0; i < n_years; ++i) {
    const std::uint64_t of_year = seed + static_cast<std::uint64_t>(i);
    Year year(of_year, season_K);
    const int onset = onset_of(of_year);
    DriftMonitor monitor = fresh;
    for (int night = 0; night < kNightsOfAYear; ++night) {
      if (night == onset) {
        const auto caught = [&](const Fault& fault, int n_nights) {
          return age_of_catch(year, fault, onset, monitor, is_noted, n_nights);
        };
        const auto step = caught(kStep, kMonth);
        row.step.add(step, step.has_value());
        const auto ramp = caught(kRamp, kNightsOfAYear - onset);
        row.ramp.add(ramp, ramp && *ramp <= 34);  // 10 um
        row.n_of_step += caught(kWarm, kSoon) ? 1 : 0;
      }
      DriftPoint point = year.night(night, {}, kNightsOfAYear).offset;
      if (!is_noted) point.temperature_c.reset();
      const WatchedNight seen = *monitor.add(point);
      row.n_alarms += std::ranges::any_of(seen.alarms, is_chart) ? 1 : 0;
      row.n_moved += std::ranges::any_of(seen.alarms, std::not_fn(is_chart)) ? 1 : 0;
    }
  }
  row.n_alarms /= n_years;
  row.n_moved /= n_years;
  return row;
}

}  // namespace

int print_season(int n_years, std::uint64_t seed) {
  fmt::print(
      "| years | temperature | alarms of charts a healthy year | \"has moved\" a healthy year | "
      "hall "
      "warmer by 8 K: alarm within 3 nights | step of 5 um | ramp of 0.3 um a day |\n"
      "| --- | --- | --- | --- | --- | --- | --- |\n");
  for (const double season_K : {0.0, kSeason_K}) {
    for (const bool is_noted : {true, false}) {
      const SeasonRow row = season_row(n_years, seed, season_K, is_noted);
      fmt::print("| {} | {} | {:.2f} | {:.2f} | {:.0f} % | {} | {} |\n",
                 season_K > 0 ? "season of +- 8 K" : "no season",
                 is_noted ? "noted" : "not noted",
                 row.n_alarms,
                 row.n_moved,
                 100.0 * row.n_of_step / n_years,
                 row.step.text(),
                 row.ramp.text());
    }
  }
  return 0;
}

}  // namespace panelcal::bench
