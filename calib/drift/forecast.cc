// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/forecast.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/base/clock.h"
#include "calib/base/statistics/distributions.h"
#include "calib/drift/amount.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr int kParts = 5;

Diagnostic invalid_forecast(std::string what, std::string expected) {
  return {Code::CalibrationInvalid, {}, std::move(what), std::move(expected)};
}

double chance_at(const DriftModel& model,
                 const Eigen::VectorXd& in_force,
                 std::chrono::sys_seconds time,
                 const ForecastLimits& limits) {
  return chance_beyond(model.forecast(time, limits.temperature_c), in_force, limits.tolerance);
}

/// Of one or two axes.
double chance_of_length(const DriftPrediction& prediction,
                        const Eigen::VectorXd& center,
                        double radius) {
  const NormalMixture first = prediction.axes[0].condensed(kParts);
  const bool is_flat = prediction.axes.size() > 1;
  const NormalMixture second =
      is_flat ? prediction.axes[1].condensed(kParts) : NormalMixture{{{1, 0, 0}}};
  const Eigen::Index n = is_flat ? 2 : 1;
  double sum = 0;
  for (const NormalMixture::Part& a : first.parts) {
    for (const NormalMixture::Part& b : second.parts) {
      Eigen::VectorXd mean(n);
      Eigen::MatrixXd cov(n, n);
      mean(0) = a.mean - center(0);
      cov(0, 0) = a.variance;
      if (is_flat) {
        mean(1) = b.mean - center(1);
        cov(1, 1) = b.variance;
        cov(0, 1) = cov(1, 0) = prediction.correlation(0, 1) * std::sqrt(a.variance * b.variance);
      }
      sum += a.weight * b.weight * exceedance_about(mean, cov, radius);
    }
  }
  return sum;
}

/// The size of an error that a tolerance is held against.
double size_of(const Eigen::VectorXd& error) {
  return error.size() <= 2 ? error.norm() : error.lpNorm<Eigen::Infinity>();
}

}  // namespace

Expected<void> ForecastLimits::validate() const {
  if (!(tolerance > 0) || !std::isfinite(tolerance)) {
    return failure(
        invalid_forecast(fmt::format("the tolerance of a forecast is {}", tolerance), "above 0"));
  }
  if (!(probability > 0 && probability < 0.5)) {
    return failure(invalid_forecast(fmt::format("the probability of a forecast is {}", probability),
                                    "above 0 and below 0.5"));
  }
  constexpr double kLongest_s = 10 * 366 * 86400.0;
  if (!(horizon.in_s() > 0 && horizon.in_s() <= kLongest_s)) {
    return failure(
        invalid_forecast(fmt::format("the horizon of a forecast is {} s", horizon.in_s()),
                         "above 0 and up to ten years"));
  }
  if (!(trusted.in_s() > 0 && trusted.in_s() <= kLongest_s)) {
    return failure(
        invalid_forecast(fmt::format("a calibration is trusted for {} s", trusted.in_s()),
                         "above 0 and up to ten years"));
  }
  if (temperature_c && !std::isfinite(*temperature_c)) {
    return failure(
        invalid_forecast("the temperature of a forecast is not finite", "degrees Celsius"));
  }
  return {};
}

double chance_beyond(const DriftPrediction& prediction,
                     const Eigen::VectorXd& center,
                     double radius) {
  if (prediction.axes.size() <= 2) return chance_of_length(prediction, center, radius);
  double sum = 0;
  for (std::size_t i = 0; i < prediction.axes.size(); ++i) {
    const DriftPrediction axis = {{prediction.axes[i]}, Eigen::MatrixXd::Identity(1, 1)};
    sum += chance_of_length(axis, center.segment<1>(static_cast<Eigen::Index>(i)), radius);
  }
  return std::min(1.0, sum);
}

Expected<DrillForecast> may_drill(const DriftModel& model,
                                  const Eigen::VectorXd& in_force,
                                  std::chrono::sys_seconds now,
                                  const ForecastLimits& limits) {
  PANELCAL_CHECK(limits.validate());
  if (in_force.size() != model.n_axes() || !in_force.allFinite()) {
    return failure(invalid_forecast("the value in force does not have the series' axes",
                                    "as many numbers as the nights have"));
  }
  if (model.last() && now < *model.last()) {
    return failure(
        invalid_forecast("a forecast is asked for before the last night", "a time after it"));
  }
  DrillForecast out;
  out.now = now;
  if (!model.has_enough()) return out;
  const DriftPrediction prediction = model.forecast(now, limits.temperature_c);
  out.error = prediction.mean() - in_force;
  out.cov = prediction.cov();
  out.chance_now = chance_beyond(prediction, in_force, limits.tolerance);
  out.answer = DrillAnswer::No;
  if (!(out.chance_now <= limits.probability)) return out;
  // Below one half the chance rises with the variance, and that with time.
  const auto is_good = [&](long minutes) {
    return chance_at(model, in_force, now + std::chrono::minutes(minutes), limits) <=
           limits.probability;
  };
  long good = 0;
  long bad = static_cast<long>(limits.horizon.in_s() / 60) + 1;
  out.answer = DrillAnswer::BeyondHorizon;
  if (is_good(bad)) return out;
  while (bad - good > 1) {
    const long middle = good + (bad - good) / 2;
    (is_good(middle) ? good : bad) = middle;
  }
  out.answer = DrillAnswer::Until;
  out.until = now + std::chrono::minutes(good);
  return out;
}

void limit_to_trust(const DriftModel& model,
                    const ForecastLimits& limits,
                    DrillForecast& forecast) {
  if (!model.last()) return;
  forecast.last_measured = *model.last();
  const bool may_be_used =
      forecast.answer == DrillAnswer::Until || forecast.answer == DrillAnswer::BeyondHorizon;
  if (!may_be_used) return;
  const auto end = *model.last() + std::chrono::seconds(std::llround(limits.trusted.in_s()));
  const auto until = forecast.answer == DrillAnswer::Until
                         ? forecast.until
                         : forecast.now + std::chrono::seconds(std::llround(limits.horizon.in_s()));
  if (until <= end) return;
  forecast.is_limited_by_trust = true;
  forecast.until = end;
  forecast.answer = end > forecast.now ? DrillAnswer::Until : DrillAnswer::No;
}

namespace {

/// "", or since when nothing was measured, and what that means.
std::string trust_words(const DrillForecast& forecast, const ForecastLimits& limits) {
  if (!forecast.last_measured) return {};
  constexpr double kDay_s = 86400;
  const bool is_over = forecast.answer == DrillAnswer::No && forecast.is_limited_by_trust;
  return fmt::format(
      "; it was last measured {} and {} trusted for {:.4g} days after that "
      "([nightly.drift] trusted_days)",
      iso_8601(*forecast.last_measured),
      is_over ? "was" : "is",
      limits.trusted.in_s() / kDay_s);
}

}  // namespace

std::string words_of(const DrillForecast& forecast,
                     const ForecastLimits& limits,
                     const std::string& unit) {
  if (forecast.answer == DrillAnswer::NotEnoughHistory) {
    return "no forecast: not enough history";
  }
  const std::string bound = amount(limits.tolerance, unit);
  const std::string now = fmt::format(
      "the calibration in force is {} off, and off by more than {} with a probability of {:.2g}",
      amount(size_of(forecast.error), unit),
      bound,
      forecast.chance_now);
  const std::string trust = trust_words(forecast, limits);
  switch (forecast.answer) {
    case DrillAnswer::Until:
      if (forecast.is_limited_by_trust) {
        return fmt::format("yes, until {}: now {}{}", iso_8601(forecast.until), now, trust);
      }
      return fmt::format("yes, until {}: now {}; then it is {:.2g}{}",
                         iso_8601(forecast.until),
                         now,
                         limits.probability,
                         trust);
    case DrillAnswer::BeyondHorizon:
      return fmt::format(
          "yes, for {:.0f} days and more: {}{}", limits.horizon.in_s() / 86400, now, trust);
    default:
      return fmt::format("no: {}, limit {:.2g}{}", now, limits.probability, trust);
  }
}

}  // namespace panelcal
