// SPDX-License-Identifier: Apache-2.0
#include "vision/texture/weave.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace panelcal::internal {
namespace {

constexpr double kYarnWander = 0.06;  // of the period, sideways
constexpr double kWandersPerPeriod = 1.3;
constexpr double kYarnsPerPeriod = 2;     // each with a thickness of its own
constexpr double kYarnInequality = 0.35;  // of a yarn's brightness
constexpr double kMottle = 0.35;          // share of the irregular part
constexpr double kMottlesPerPeriod = 1 / 0.18;
constexpr std::int64_t kWarp = 1'000'003;
constexpr std::int64_t kWeft = 2'000'003;

/// Of the tables. Linear interpolation between them is good to 2e-5.
constexpr int kStepsPerValue = 256;
constexpr int kSineSteps = 1024;
constexpr double kMostKept = 1 << 22;

/// std::floor is a function call on plain x86-64. Precondition: |x| < 2^62.
std::int64_t floor_of(double x) {
  const auto truncated = static_cast<std::int64_t>(x);
  return truncated - (x < static_cast<double>(truncated) ? 1 : 0);
}

/// Far away, too.
std::int64_t far_floor_of(double x) {
  return floor_of(std::clamp(x, -1e15, 1e15));
}

double mix(double share, double a, double b) {
  return a + share * (b - a);
}

/// 0 to 1 with zero slope at both ends, so that cells join smoothly.
double smooth_step(double t) {
  return t * t * (3 - 2 * t);
}

/// -1 to 1, from a lattice point; SplitMix64's mixing (Steele, Lea and Flood 2014).
double lattice_level(std::uint64_t seed, std::int64_t i, std::int64_t j) {
  std::uint64_t z = seed + static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15ULL +
                    static_cast<std::uint64_t>(j) * 0xD1B54A32D192ED03ULL;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1.0;
}

/// Between two lattice points; x in units of the lattice.
double between(std::uint64_t seed, double x, std::int64_t lane) {
  const std::int64_t i = floor_of(x);
  const double share = smooth_step(x - static_cast<double>(i));
  return mix(share, lattice_level(seed, i, lane), lattice_level(seed, i + 1, lane));
}

}  // namespace

WeaveField::Curve::Curve(
    std::uint64_t seed, std::int64_t lane, double per_period, double low, double high)
    : seed_(seed), lane_(lane), per_period_(per_period) {
  const double steps_per_period = per_period * kStepsPerValue;
  if (!((high - low) * steps_per_period < kMostKept)) return;
  first_ = far_floor_of(low * steps_per_period);
  const std::int64_t last = far_floor_of(high * steps_per_period) + 1;
  for (std::int64_t i = first_; i <= last; ++i) {
    values_.push_back(between(seed, static_cast<double>(i) / kStepsPerValue, lane));
  }
}

double WeaveField::Curve::at(double x) const {
  const double step = x * per_period_ * kStepsPerValue - static_cast<double>(first_);
  const auto i = static_cast<std::uint64_t>(static_cast<std::int64_t>(step));
  if (!(step >= 0) || i + 1 >= values_.size()) return between(seed_, x * per_period_, lane_);
  return mix(step - static_cast<double>(static_cast<std::int64_t>(i)), values_[i], values_[i + 1]);
}

WeaveField::Cloud::Cloud(std::uint64_t seed,
                         const Eigen::Vector2d& low,
                         const Eigen::Vector2d& high)
    : seed_(seed), first_x_(far_floor_of(low.x())), first_y_(far_floor_of(low.y())) {
  const Eigen::Vector2d size = high - low + Eigen::Vector2d::Constant(3);
  if (!(size.x() * size.y() < kMostKept)) return;
  width_ = static_cast<std::uint64_t>(size.x());
  height_ = static_cast<std::uint64_t>(size.y());
  values_.reserve(width_ * height_);
  for (std::uint64_t j = 0; j < height_; ++j) {
    for (std::uint64_t i = 0; i < width_; ++i) {
      values_.push_back(lattice_level(
          seed, first_x_ + static_cast<std::int64_t>(i), first_y_ + static_cast<std::int64_t>(j)));
    }
  }
}

double WeaveField::Cloud::at(double x, double y) const {
  const std::int64_t i = floor_of(x);
  const std::int64_t j = floor_of(y);
  const double share_x = smooth_step(x - static_cast<double>(i));
  const double share_y = smooth_step(y - static_cast<double>(j));
  const auto column = static_cast<std::uint64_t>(i - first_x_);
  const auto row = static_cast<std::uint64_t>(j - first_y_);
  if (column >= width_ || row >= height_ || column + 1 == width_ || row + 1 == height_) {
    return mix(share_y, between(seed_, x, j), between(seed_, x, j + 1));
  }
  const double* upper = values_.data() + row * width_ + column;
  const double* lower = upper + width_;
  return mix(share_y, mix(share_x, upper[0], upper[1]), mix(share_x, lower[0], lower[1]));
}

WeaveField::WeaveField(const Weave& weave,
                       const Eigen::Vector2d& low_mm,
                       const Eigen::Vector2d& high_mm)
    : per_mm_(1 / weave.period.in_mm()),
      warp_wander_(
          weave.seed, kWarp, kWandersPerPeriod, per_mm_ * low_mm.y(), per_mm_ * high_mm.y()),
      weft_wander_(
          weave.seed, kWeft, kWandersPerPeriod, per_mm_ * low_mm.x(), per_mm_ * high_mm.x()),
      warp_thickness_(
          weave.seed, kWarp + 1, kYarnsPerPeriod, per_mm_ * low_mm.x(), per_mm_ * high_mm.x()),
      weft_thickness_(
          weave.seed, kWeft + 1, kYarnsPerPeriod, per_mm_ * low_mm.y(), per_mm_ * high_mm.y()),
      mottle_(weave.seed + 7,
              kMottlesPerPeriod * per_mm_ * low_mm,
              kMottlesPerPeriod * per_mm_ * high_mm) {
  sines_.reserve(kSineSteps + 2);
  for (int i = 0; i < kSineSteps + 2; ++i) {
    sines_.push_back(std::sin(2 * std::numbers::pi * i / kSineSteps));
  }
}

double WeaveField::sine_of_turns(double x) const {
  const double step = (x - static_cast<double>(floor_of(x))) * kSineSteps;
  const auto i = static_cast<std::int64_t>(step);
  const double* sine = sines_.data() + i;
  return mix(step - static_cast<double>(i), sine[0], sine[1]);
}

double WeaveField::level(const Eigen::Vector2d& at_mm) const {
  const double x = at_mm.x() * per_mm_;
  const double y = at_mm.y() * per_mm_;
  const double warp = x + kYarnWander * warp_wander_.at(y);
  const double weft = y + kYarnWander * weft_wander_.at(x);
  const double thickness = warp_thickness_.at(x) + weft_thickness_.at(y);
  const double knots = sine_of_turns(warp) * sine_of_turns(weft);
  const double mottle = mottle_.at(kMottlesPerPeriod * x, kMottlesPerPeriod * y);
  return (1 - kMottle) * knots * (1 + kYarnInequality * thickness) + kMottle * mottle;
}

}  // namespace panelcal::internal
