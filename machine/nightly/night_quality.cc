// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/night_quality.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "calib/charts/spread_monitor.h"
#include "calib/drift/amount.h"
#include "calib/drift/monitor.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// The F test is exact after one night, but one night may be an odd one.
constexpr int kLeastNights = 3;

template <class T>
const T* named(const std::vector<T>& all, const std::string& name) {
  const auto found = std::ranges::find(all, name, &T::name);
  return found == all.end() ? nullptr : &*found;
}

Diagnostic no_number(const std::string& name) {
  return {Code::CalibrationInvalid,
          {},
          fmt::format("the night's {} is out of range", quoted(name)),
          "a finite number above 0"};
}

/// A night's alarm of a scatter that grew.
void say_spread(const WatchedSpread& watched,
                NightQuality quality,
                int n_nights,
                QualityVerdict& out) {
  if (watched.expected_variance > 0) quality.usual = std::sqrt(watched.expected_variance);
  quality.is_alarm = watched.is_alarm();
  quality.text = amount(quality.value, quality.unit);
  if (quality.usual) {
    quality.text +=
        fmt::format(", usually {} ({} nights)", amount(*quality.usual, quality.unit), n_nights);
  }
  if (watched.is_alarm_of_night) {
    const std::string words = fmt::format("{}: the scatter is {:.1f} times as large as usual ({})",
                                          quality.name,
                                          std::sqrt(watched.ratio),
                                          quality.text);
    out.gates.push_back({quality.name, false, words});
    out.alarms.push_back(words);
  } else if (watched.is_alarm_of_sum) {
    out.alarms.push_back(
        fmt::format("{}: the scatter grows, night after night ({})", quality.name, quality.text));
  }
  out.qualities.push_back(std::move(quality));
}

Expected<void> judge_spread(std::span<const QualityNight> nights,
                            const QualityNight& tonight,
                            const NightSpread& spread,
                            const NightlyConfig& config,
                            QualityVerdict& out) {
  const bool is_sound = std::isfinite(spread.variance) && spread.variance >= 0 &&
                        std::isfinite(spread.degrees_of_freedom) && spread.degrees_of_freedom > 0;
  if (!is_sound) return failure(no_number(spread.name));
  PANELCAL_TRY(SpreadMonitor monitor,
               SpreadMonitor::make(config.watch.nights_per_false_alarm, kLeastNights));
  int n_nights = 0;
  bool is_fresh = false;
  for (const QualityNight& night : nights) {
    const NightSpread* before = named(night.spreads, spread.name);
    is_fresh = is_fresh || night.is_fresh_start;
    if (before == nullptr || night.is_left_out) continue;
    if (is_fresh) n_nights = 0;
    PANELCAL_CHECK(monitor.add({night.time,
                                before->variance,
                                before->degrees_of_freedom,
                                std::exchange(is_fresh, false)}));
    ++n_nights;
  }
  is_fresh = is_fresh || tonight.is_fresh_start;
  PANELCAL_TRY(const WatchedSpread watched,
               monitor.add({tonight.time, spread.variance, spread.degrees_of_freedom, is_fresh}));
  NightQuality quality;
  quality.name = spread.name;
  quality.unit = spread.unit;
  quality.value = std::sqrt(spread.variance);
  say_spread(watched, std::move(quality), n_nights, out);
  return {};
}

/// Of logarithms: lamps and lenses change by some tenths of a percent from day to day.
DriftOptions level_options(const NightlyConfig& config) {
  DriftOptions options;
  options.min_nights = config.drift.min_nights;
  options.priors.drift = 0.002;
  options.priors.repeatability = 0.005;
  options.priors.per_kelvin = 0.002;
  return options;
}

DriftPoint level_point(const QualityNight& night, const NightLevel& level, bool is_fresh) {
  constexpr double kLeastLevelSigma = 1e-4;  // of what is averaged over many pictures
  DriftPoint point;
  point.time = night.time;
  point.value = Eigen::VectorXd::Constant(1, std::log(level.value));
  point.cov = Eigen::MatrixXd::Constant(1, 1, kLeastLevelSigma * kLeastLevelSigma);
  point.is_fresh_start = is_fresh;
  return point;
}

std::string level_text(const NightLevel& level, const NightQuality& quality, int n_nights) {
  const auto number = [&](double v) {
    return level.unit == "1" ? fmt::format("{:.3g}", v) : fmt::format("{:.3g} {}", v, level.unit);
  };
  if (!quality.usual) return number(level.value);
  return fmt::format(
      "{}, usually {} ({} nights)", number(level.value), number(*quality.usual), n_nights);
}

void say_level(const WatchedNight& watched,
               const NightLevel& level,
               int n_nights,
               QualityVerdict& out) {
  NightQuality quality;
  quality.name = level.name;
  quality.unit = level.unit;
  quality.value = level.value;
  if (watched.is_judged) quality.usual = std::exp(watched.expected(0));
  quality.is_alarm = !watched.alarms.empty();
  quality.text = level_text(level, quality, n_nights);
  const bool is_bad = quality.usual && (level.value < *quality.usual) == level.low_is_bad;
  if (watched.is_step()) {
    const std::string words = fmt::format(
        "{} has jumped to the {} side: {}", level.name, is_bad ? "bad" : "good", quality.text);
    if (is_bad) out.gates.push_back({level.name, false, words});
    out.alarms.push_back(words);
  } else if (quality.is_alarm) {
    out.alarms.push_back(fmt::format("{} changes slowly: {}", level.name, quality.text));
  }
  out.qualities.push_back(std::move(quality));
}

Expected<void> judge_level(std::span<const QualityNight> nights,
                           const QualityNight& tonight,
                           const NightLevel& level,
                           const NightlyConfig& config,
                           QualityVerdict& out) {
  if (!std::isfinite(level.value) || !(level.value > 0)) return failure(no_number(level.name));
  WatchOptions watch;
  watch.nights_per_false_alarm = config.watch.nights_per_false_alarm;
  watch.moved.reset();
  PANELCAL_TRY(DriftMonitor monitor, DriftMonitor::make(1, level_options(config), watch));
  int n_nights = 0;
  bool is_fresh = false;
  for (const QualityNight& night : nights) {
    const NightLevel* before = named(night.levels, level.name);
    is_fresh = is_fresh || night.is_fresh_start;
    if (before == nullptr || night.is_left_out || !(before->value > 0)) continue;
    if (is_fresh) n_nights = 0;
    PANELCAL_CHECK(monitor.add(level_point(night, *before, std::exchange(is_fresh, false))));
    ++n_nights;
  }
  is_fresh = is_fresh || tonight.is_fresh_start;
  PANELCAL_TRY(const WatchedNight watched, monitor.add(level_point(tonight, level, is_fresh)));
  say_level(watched, level, n_nights, out);
  return {};
}

}  // namespace

Expected<QualityVerdict> judge_qualities(std::span<const QualityNight> nights,
                                         const QualityNight& tonight,
                                         const NightlyConfig& config) {
  QualityVerdict out;
  for (const NightSpread& spread : tonight.spreads) {
    PANELCAL_CHECK(judge_spread(nights, tonight, spread, config, out));
  }
  for (const NightLevel& level : tonight.levels) {
    PANELCAL_CHECK(judge_level(nights, tonight, level, config, out));
  }
  return out;
}

}  // namespace panelcal
