// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/change_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "calib/base/clock.h"
#include "calib/drift/amount.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Widths of the prior of a size, in standard deviations of a night.
constexpr std::array kWidths = {3.0, 10.0, 30.0, 100.0, 300.0};
constexpr double kDaysOfASlope = 30;
constexpr double kMinSigmas = 3;
constexpr double kQuietShareOfNights = 0.9;

/// An axis reduced to what is needed: the usual steps of the level, the noise, the values.
struct Axis {
  std::vector<double> days;      ///< since the first night
  std::vector<double> value;     ///< temperature taken out
  std::vector<double> variance;  ///< of a night
  double drift = 0;              ///< per square root of a day
};

/// Size and its variance if the change has this shape.
struct Estimate {
  double size = 0;
  double variance = 0;
};

/// Runs the filter of the level over value and shape at once.
template <class Shape>
Estimate estimate(const Axis& axis, const Shape& shape) {
  double level = axis.value[0];
  double shape_level = shape(0);
  double variance = axis.variance[0];
  double information = 0;
  double product = 0;
  for (std::size_t t = 1; t < axis.value.size(); ++t) {
    variance += axis.drift * axis.drift * (axis.days[t] - axis.days[t - 1]);
    const double spread = variance + axis.variance[t];
    const double away = axis.value[t] - level;
    const double shape_away = shape(t) - shape_level;
    information += shape_away * shape_away / spread;
    product += shape_away * away / spread;
    const double gain = variance / spread;
    level += gain * away;
    shape_level += gain * shape_away;
    variance *= 1 - gain;
  }
  if (!(information > 0)) return {0, std::numeric_limits<double>::infinity()};
  return {product / information, 1 / information};
}

/// Log of the ratio of likelihoods, change to no change, with the size integrated out.
double log_ratio(const Estimate& e, double unit) {
  if (std::isinf(e.variance)) return 0;
  double sum = 0;
  double most = -std::numeric_limits<double>::infinity();
  std::array<double, kWidths.size()> logs{};
  for (std::size_t i = 0; i < kWidths.size(); ++i) {
    const double prior = kWidths[i] * kWidths[i] * unit * unit;
    logs[i] = 0.5 * std::log(e.variance / (e.variance + prior)) +
              0.5 * e.size * e.size * prior / (e.variance * (e.variance + prior));
    most = std::max(most, logs[i]);
  }
  for (const double log : logs) sum += std::exp(log - most) / kWidths.size();
  return most + std::log(sum);
}

double log_sum(const std::vector<double>& logs) {
  const double most = *std::ranges::max_element(logs);
  double sum = 0;
  for (const double log : logs) sum += std::exp(log - most);
  return most + std::log(sum);
}

Estimate estimate_of(const Axis& axis, ChangeKind kind, std::size_t k) {
  if (kind == ChangeKind::Step) {
    return estimate(axis, [k](std::size_t t) { return t >= k ? 1.0 : 0.0; });
  }
  // It begins with the night before the first one that shows it.
  return estimate(
      axis, [&axis, k](std::size_t t) { return std::max(0.0, axis.days[t] - axis.days[k - 1]); });
}

/// Log likelihood ratios of a kind for each first night from 1 on; all axes together. An axis may
/// or may not take part, with even chances.
std::vector<double> scan(const std::vector<Axis>& axes, ChangeKind kind) {
  std::vector<double> logs;
  for (std::size_t k = 1; k < axes[0].value.size(); ++k) {
    double sum = 0;
    for (const Axis& axis : axes) {
      const double sigma = std::sqrt(axis.variance[k]);
      const double unit = kind == ChangeKind::Step ? sigma : sigma / kDaysOfASlope;
      const double log = log_ratio(estimate_of(axis, kind, k), unit);
      sum += log > 0 ? log + std::log(0.5 + 0.5 * std::exp(-log))
                     : std::log(0.5 + 0.5 * std::exp(log));
    }
    logs.push_back(sum);
  }
  return logs;
}

/// The nights that are looked at, as indices of points.
std::vector<std::size_t> nights_of(const DriftSeries& series) {
  std::vector<std::size_t> nights;
  for (std::size_t i = 0; i < series.points.size(); ++i) {
    if (series.points[i].is_left_out) continue;
    if (series.points[i].is_fresh_start) nights.clear();
    nights.push_back(i);
  }
  return nights;
}

/// With parameters as the first half of the nights shows them: a change would pass for drift.
Expected<std::vector<Axis>> axes_of(const DriftSeries& series,
                                    const DriftOptions& options,
                                    const std::vector<std::size_t>& nights) {
  const int n_axes = static_cast<int>(series.names.size());
  PANELCAL_TRY(DriftModel all, DriftModel::make(n_axes, options));
  PANELCAL_TRY(DriftModel early, DriftModel::make(n_axes, options));
  for (std::size_t i = 0; i < series.points.size(); ++i) {
    PANELCAL_CHECK(all.add(series.points[i]));
    if (i <= nights[nights.size() / 2]) PANELCAL_CHECK(early.add(series.points[i]));
  }
  std::vector<Axis> axes;
  for (int i = 0; i < n_axes; ++i) {
    const DriftParameters p = early.parameters(i);
    Axis axis;
    axis.drift = p.drift_per_sqrt_day;
    for (const std::size_t night : nights) {
      const DriftPoint& point = series.points[night];
      const auto since = point.time - series.points[nights.front()].time;
      axis.days.push_back(static_cast<double>(since.count()) / 86400);
      const double kelvin = point.temperature_c ? *point.temperature_c - options.reference_c : 0;
      axis.value.push_back(point.value(i) - p.per_kelvin * kelvin);
      axis.variance.push_back(point.cov(i, i) + p.repeatability * p.repeatability +
                              std::pow(p.per_kelvin_sigma * kelvin, 2));
    }
    axes.push_back(std::move(axis));
  }
  return axes;
}

/// Night, interval and sizes of the kind that was chosen.
void describe(ChangeFound& found,
              const std::vector<Axis>& axes,
              const std::vector<double>& logs,
              const std::vector<std::size_t>& nights) {
  const double total = log_sum(logs);
  const auto best = std::ranges::max_element(logs);
  const auto k = static_cast<std::size_t>(best - logs.begin()) + 1;
  found.i_night = nights[k];
  found.night_probability = std::exp(*best - total);
  double below = 0;
  bool has_first = false;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    below += std::exp(logs[i] - total);
    if (!has_first && below >= 0.5 * (1 - kQuietShareOfNights)) {
      found.i_first = nights[i + 1];
      has_first = true;
    }
    found.i_last = nights[i + 1];
    if (below >= 0.5 * (1 + kQuietShareOfNights)) break;
  }
  const auto n = static_cast<Eigen::Index>(axes.size());
  found.size.resize(n);
  found.size_sigma.resize(n);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const Estimate e = estimate_of(axes[i], found.kind, k);
    const auto at = static_cast<Eigen::Index>(i);
    found.size(at) = e.size;
    found.size_sigma(at) = std::sqrt(e.variance);
    if (std::abs(e.size) > kMinSigmas * found.size_sigma(at)) found.axes.push_back(i);
  }
}

std::string day_of(const DriftPoint& point) {
  constexpr std::size_t kLength = 10;  // 2026-11-21
  return iso_8601(point.time).substr(0, kLength);
}

}  // namespace

Expected<ChangeFound> find_change(const DriftSeries& series, const DriftOptions& options) {
  PANELCAL_CHECK(options.validate());
  const std::vector<std::size_t> nights = nights_of(series);
  if (nights.size() < static_cast<std::size_t>(options.min_nights)) {
    return failure({Code::CalibrationInvalid,
                    {},
                    fmt::format("not enough history: {} nights", nights.size()),
                    fmt::format("{} or more", options.min_nights)});
  }
  PANELCAL_TRY(const std::vector<Axis> axes, axes_of(series, options, nights));
  const std::vector<double> steps = scan(axes, ChangeKind::Step);
  const std::vector<double> slopes = scan(axes, ChangeKind::Slope);
  const double a_night = std::log(0.5 * kChangeBefore / static_cast<double>(steps.size()));
  const std::array<double, 3> logs = {
      std::log(1 - kChangeBefore), a_night + log_sum(steps), a_night + log_sum(slopes)};
  const double total = log_sum({logs.begin(), logs.end()});
  const auto best = static_cast<std::size_t>(std::ranges::max_element(logs) - logs.begin());
  ChangeFound found;
  found.probability = std::exp(logs[best] - total);
  if (best == 0) return found;
  found.kind = best == 1 ? ChangeKind::Step : ChangeKind::Slope;
  describe(found, axes, best == 1 ? steps : slopes, nights);
  return found;
}

std::string words_of(const ChangeFound& change, const DriftSeries& series) {
  if (change.kind == ChangeKind::None) {
    return fmt::format("nothing has changed but as usual (probability {:.2f})", change.probability);
  }
  const bool is_step = change.kind == ChangeKind::Step;
  std::string out;
  for (const std::size_t i : change.axes) {
    const auto at = static_cast<Eigen::Index>(i);
    out += fmt::format("{}{} {} {}{} (sigma {})",
                       out.empty() ? "" : ", ",
                       series.names[i],
                       is_step ? "moved by" : "drifts by",
                       signed_amount(change.size(at), series.unit),
                       is_step ? "" : " a day",
                       amount(change.size_sigma(at), series.unit));
  }
  if (out.empty()) out = is_step ? "something moved" : "something drifts";
  if (change.i_first == change.i_last) {
    // A night changes against the one before it that counts; that one is named.
    std::size_t before = change.i_night - 1;
    while (before > 0 && series.points[before].is_left_out) --before;
    out += fmt::format(
        fmt::runtime(is_step ? " between the nights of {} and {}" : ", begun between {} and {}"),
        day_of(series.points[before]),
        day_of(series.points[change.i_night]));
  } else {
    out += fmt::format(", since about {} (between {} and {} with 90 %)",
                       day_of(series.points[change.i_night]),
                       day_of(series.points[change.i_first]),
                       day_of(series.points[change.i_last]));
  }
  return out + fmt::format("; probability {:.3f}", change.probability);
}

}  // namespace panelcal
