// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "calib/base/statistics/covariance_check.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr int kMostAxes = 12;
/// Steps of the grid and how far it reaches, in standard deviations of the prior's logarithm. A
/// sigma between two neighbours is then at most 15 % from one, and their mean is nearer.
constexpr double kStep = 1.35;
constexpr double kDriftReach = 2.5;
/// Variance of a level of which nothing is known, in those of a night.
constexpr double kDiffuse = 1e8;
constexpr double kMostKelvin = 1000;
/// Squares of larger values would overflow.
constexpr double kLargest = 1e100;
/// For how many nights DriftOptions::unknown_kelvin counts.
constexpr int kNightsOfUnknown = 2;

Diagnostic invalid_drift(std::string what, std::string expected) {
  return {Code::CalibrationInvalid, {}, std::move(what), std::move(expected)};
}

/// Values of a log-normal prior and the logarithms of their weights.
std::vector<std::pair<double, double>> grid(double median, double factor) {
  const double step = std::log(kStep) / std::log(factor);
  const int n = static_cast<int>(std::ceil(kDriftReach / step));
  std::vector<std::pair<double, double>> out;
  for (int i = -n; i <= n; ++i) {
    const double z = i * step;
    out.emplace_back(median * std::pow(kStep, i), -0.5 * z * z);
  }
  return out;
}

double days_between(std::chrono::sys_seconds a, std::chrono::sys_seconds b) {
  constexpr double kSecondsPerDay = 86400;
  return static_cast<double>((b - a).count()) / kSecondsPerDay;
}

}  // namespace

Expected<void> DriftOptions::validate() const {
  const auto above = [](std::string_view field, double value, double bound) -> Expected<void> {
    if (std::isfinite(value) && value > bound) return {};
    return failure(invalid_drift(fmt::format("{} of a drift model is {}", field, value),
                                 fmt::format("a number above {}", bound)));
  };
  PANELCAL_CHECK(above("drift", priors.drift, 0));
  PANELCAL_CHECK(above("drift_factor", priors.drift_factor, 1.05));
  PANELCAL_CHECK(above("repeatability", priors.repeatability, 0));
  PANELCAL_CHECK(above("repeatability_factor", priors.repeatability_factor, 1.05));
  PANELCAL_CHECK(above("per_kelvin", priors.per_kelvin, 0));
  PANELCAL_CHECK(above("unknown_kelvin", unknown_kelvin, 0));
  PANELCAL_CHECK(above("reference_c", reference_c, -kMostKelvin));
  PANELCAL_CHECK(above("min_nights", min_nights, 2));
  constexpr double kLargestFactor = 100;  // above, the grids would take minutes
  if (priors.drift_factor <= kLargestFactor && priors.repeatability_factor <= kLargestFactor) {
    return {};
  }
  return failure(invalid_drift("a factor of a drift model's priors is too large", "100 at most"));
}

Eigen::VectorXd DriftPrediction::mean() const {
  Eigen::VectorXd out(static_cast<Eigen::Index>(axes.size()));
  for (std::size_t i = 0; i < axes.size(); ++i) out(static_cast<Eigen::Index>(i)) = axes[i].mean();
  return out;
}

Eigen::MatrixXd DriftPrediction::cov() const {
  Eigen::VectorXd sigma(static_cast<Eigen::Index>(axes.size()));
  for (std::size_t i = 0; i < axes.size(); ++i) {
    sigma(static_cast<Eigen::Index>(i)) = std::sqrt(axes[i].variance());
  }
  return sigma.asDiagonal() * correlation * sigma.asDiagonal();
}

Expected<DriftModel> DriftModel::make(int n_axes, const DriftOptions& options) {
  PANELCAL_CHECK(options.validate());
  if (n_axes >= 1 && n_axes <= kMostAxes) return DriftModel(n_axes, options);
  return failure(
      invalid_drift(fmt::format("a series of {} axes", n_axes), fmt::format("1 to {}", kMostAxes)));
}

DriftModel::DriftModel(int n_axes, const DriftOptions& options)
    : options_(options), cross_(Eigen::MatrixXd::Zero(n_axes, n_axes)) {
  const DriftPriors& p = options.priors;
  Bank bank;
  for (const auto& [drift, log_drift] : grid(p.drift, p.drift_factor)) {
    for (const auto& [repeat, log_repeat] : grid(p.repeatability, p.repeatability_factor)) {
      Filter f;
      f.drift = drift;
      f.repeatability = repeat;
      f.log_weight = log_drift + log_repeat;
      f.cov(1, 1) = p.per_kelvin * p.per_kelvin;
      bank.push_back(f);
    }
  }
  banks_.assign(static_cast<std::size_t>(n_axes), bank);
}

DriftModel::Look DriftModel::look(std::chrono::sys_seconds time,
                                  const std::optional<double>& temperature_c) const {
  Look out;
  const double usual_c = n_temperatures_ > 0 ? mean_temperature_c_ : options_.reference_c;
  out.row << 1, temperature_c.value_or(usual_c) - options_.reference_c;
  if (!temperature_c && n_temperatures_ > 0) {
    const double before = kNightsOfUnknown * options_.unknown_kelvin * options_.unknown_kelvin;
    out.unknown =
        std::sqrt((before + spread_of_temperatures_) / (kNightsOfUnknown + n_temperatures_));
  }
  out.days = last_ ? std::max(0.0, days_between(*last_, time)) : 0;
  return out;
}

NormalMixture DriftModel::mixture(const Bank& bank,
                                  const Look& look,
                                  const double* measured_variance) const {
  NormalMixture out;
  out.parts.reserve(bank.size());
  double most = -std::numeric_limits<double>::infinity();
  for (const Filter& f : bank) most = std::max(most, f.log_weight);
  double sum = 0;
  for (const Filter& f : bank) {
    NormalMixture::Part part;
    part.weight = std::exp(f.log_weight - most);
    sum += part.weight;
    part.mean = look.row.dot(f.mean);
    part.variance = look.row.dot(f.cov * look.row) + f.drift * f.drift * look.days +
                    look.unknown * look.unknown * (f.cov(1, 1) + f.mean(1) * f.mean(1));
    if (measured_variance != nullptr) {
      part.variance += *measured_variance + f.repeatability * f.repeatability;
    }
    out.parts.push_back(part);
  }
  for (NormalMixture::Part& part : out.parts) part.weight /= sum;
  return out;
}

DriftPrediction DriftModel::predict(const DriftPoint& point) const {
  const Look at = look(point.time, point.temperature_c);
  const auto n = static_cast<Eigen::Index>(banks_.size());
  DriftPrediction out;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double variance = point.cov(i, i);
    out.axes.push_back(mixture(banks_[static_cast<std::size_t>(i)], at, &variance));
  }
  out.correlation = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      const double size = std::sqrt(out.axes[static_cast<std::size_t>(i)].variance() *
                                    out.axes[static_cast<std::size_t>(j)].variance());
      out.correlation(i, j) = out.correlation(j, i) = (cross_(i, j) + point.cov(i, j)) / size;
    }
  }
  return out;
}

DriftPrediction DriftModel::forecast(std::chrono::sys_seconds time,
                                     std::optional<double> temperature_c) const {
  const Look at = look(time, temperature_c);
  const auto n = static_cast<Eigen::Index>(banks_.size());
  DriftPrediction out;
  for (const Bank& bank : banks_) out.axes.push_back(mixture(bank, at, nullptr));
  out.correlation = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      const double size = std::sqrt(out.axes[static_cast<std::size_t>(i)].variance() *
                                    out.axes[static_cast<std::size_t>(j)].variance());
      if (size > 0) out.correlation(i, j) = out.correlation(j, i) = cross_(i, j) / size;
    }
  }
  return out;
}

Expected<void> DriftModel::check(const DriftPoint& point) const {
  const auto n = static_cast<Eigen::Index>(banks_.size());
  if (point.value.size() != n || point.cov.rows() != n || point.cov.cols() != n) {
    return failure(invalid_drift(fmt::format("a night of {} axes", point.value.size()),
                                 fmt::format("{} values and their covariance", n)));
  }
  if (!point.value.allFinite() || !(point.value.cwiseAbs().maxCoeff() < kLargest)) {
    return failure(invalid_drift("a night's value is not finite", "numbers"));
  }
  if (!(point.cov.cwiseAbs().maxCoeff() < kLargest) || internal::covariance_flaw(point.cov)) {
    return failure(invalid_drift("the covariance of a night is not positive semidefinite",
                                 "a symmetric one, not negative"));
  }
  if (point.temperature_c && !(std::abs(*point.temperature_c) < kMostKelvin)) {
    return failure(invalid_drift(fmt::format("a night's temperature is {}", *point.temperature_c),
                                 "degrees Celsius"));
  }
  if (last_ && point.time <= *last_) {
    return failure(
        invalid_drift("a night is not after the one before it", "nights in order of time"));
  }
  return {};
}

void DriftModel::start_anew(const DriftPoint& point, const Look& look) {
  cross_.setZero();
  for (std::size_t i = 0; i < banks_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    for (Filter& f : banks_[i]) {
      const double night = point.cov(k, k) + f.repeatability * f.repeatability;
      f.mean(0) = point.value(k) - look.row(1) * f.mean(1);
      f.cov(0, 1) = f.cov(1, 0) = 0;
      f.cov(0, 0) = kDiffuse * night;
    }
  }
}

double DriftModel::update(Bank& bank, const Look& look, double value, double variance) const {
  double most = -std::numeric_limits<double>::infinity();
  for (Filter& f : bank) {
    f.cov(0, 0) += f.drift * f.drift * look.days;
    const double noise = variance + f.repeatability * f.repeatability +
                         look.unknown * look.unknown * (f.cov(1, 1) + f.mean(1) * f.mean(1));
    const Eigen::Vector2d with_row = f.cov * look.row;
    const double spread = look.row.dot(with_row) + noise;
    const double away = value - look.row.dot(f.mean);
    const Eigen::Vector2d gain = with_row / spread;
    f.mean += gain * away;
    // Joseph's form stays a covariance also after a diffuse start.
    const Eigen::Matrix2d left = Eigen::Matrix2d::Identity() - gain * look.row.transpose();
    f.cov = (left * f.cov * left.transpose() + noise * gain * gain.transpose()).eval();
    f.log_weight -= 0.5 * (std::log(spread) + away * away / spread);
    most = std::max(most, f.log_weight);
  }
  double sum = 0;
  double mean_left = 0;
  for (Filter& f : bank) {
    f.log_weight -= most;
    const double weight = std::exp(f.log_weight);
    sum += weight;
    const double noise = variance + f.repeatability * f.repeatability;
    // The gain of the level is what its variance became, relative to the night's.
    mean_left += weight * (1 - std::min(1.0, f.cov(0, 0) / noise));
  }
  return mean_left / sum;
}

Expected<void> DriftModel::add(const DriftPoint& point) {
  if (point.is_left_out) return {};
  PANELCAL_CHECK(check(point));
  const Look at = look(point.time, point.temperature_c);
  if (!last_ || point.is_fresh_start) start_anew(point, at);
  const auto n = static_cast<Eigen::Index>(banks_.size());
  Eigen::VectorXd left(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    left(i) = update(banks_[static_cast<std::size_t>(i)], at, point.value(i), point.cov(i, i));
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      if (i == j) continue;
      cross_(i, j) =
          left(i) * left(j) * cross_(i, j) + (1 - left(i)) * (1 - left(j)) * point.cov(i, j);
    }
  }
  if (point.temperature_c) {
    ++n_temperatures_;
    const double away = *point.temperature_c - mean_temperature_c_;
    mean_temperature_c_ += away / n_temperatures_;
    spread_of_temperatures_ += away * (*point.temperature_c - mean_temperature_c_);
  }
  last_ = point.time;
  ++n_nights_;
  return {};
}

}  // namespace panelcal
