// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/wild_probe.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "surface/fit/fit.h"

namespace panelcal::internal {
namespace {

/// Of a probe to be wild, beforehand.
constexpr double kWildBefore = 0.005;
/// ln 1000: decades of a wild probe's deviation.
constexpr double kWildDecades = 6.907755278982137;
constexpr double kFoundOdds = 20;
constexpr double kDoubtOdds = 0.5;
/// Fewer others than this predict no probe well enough.
constexpr std::size_t kLeastOthers = 5;

/// Logarithm of the density of a deviation of variance sigma^2 whose scale nu contrasts tell.
double log_student(double deviation, double sigma, double nu) {
  const double scale = sigma * std::sqrt((nu - 2) / nu);
  const double t = deviation / scale;
  return std::lgamma(0.5 * (nu + 1)) - std::lgamma(0.5 * nu) -
         0.5 * std::log(nu * std::numbers::pi) - std::log(scale) -
         0.5 * (nu + 1) * std::log1p(t * t / nu);
}

struct Suspect {
  double odds = 0;
  double deviation_mm = 0;
};

Suspect suspect(std::span<const ProbePoint> points, std::size_t i) {
  std::vector<ProbePoint> others(points.begin(), points.end());
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
  // Others in one line predict nothing.
  const auto fit = fit_surface(others, SurfaceModel::GaussianProcess);
  if (!fit) return {};
  const HeightEstimate predicted = fit->at(points[i].place);
  const double own_mm = fit->noise_factor() * points[i].measured.sigma.in_mm();
  const double sigma_mm = std::hypot(predicted.sigma.in_mm(), own_mm);
  const double deviation_mm = (points[i].measured.height - predicted.height).in_mm();
  const double nu = std::max(3.0, static_cast<double>(others.size()) - fit->n_trend());
  const double log_wild = std::log(kWildBefore / (1 - kWildBefore)) -
                          std::log(2 * kWildDecades * std::max(std::abs(deviation_mm), own_mm));
  const double log_odds = log_wild - log_student(deviation_mm, sigma_mm, nu);
  return {std::exp(std::min(log_odds, 100.0)), deviation_mm};
}

}  // namespace

WildProbe wild_probe(std::span<const ProbePoint> points) {
  WildProbe out;
  if (points.size() <= kLeastOthers) {
    out.is_doubtful = true;
    return out;
  }
  std::vector<Suspect> suspects;
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    suspects.push_back(suspect(points, i));
    sum += suspects.back().odds;
  }
  const auto worst = std::ranges::max_element(suspects, {}, &Suspect::odds);
  out.i_worst = static_cast<std::size_t>(worst - suspects.begin());
  out.deviation = mm(worst->deviation_mm);
  out.is_found = worst->odds > kFoundOdds * (1 + sum - worst->odds);
  out.is_doubtful = !out.is_found && sum > kDoubtOdds;
  return out;
}

}  // namespace panelcal::internal
