// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/drift/year.h"

#include <cmath>
#include <numbers>

namespace panelcal::bench {
namespace {

constexpr double kStated_um = 1;
constexpr double kCorrelation = 0.3;
constexpr double kHoles_um = 3;
constexpr int kDegreesOfFreedom = 16;
constexpr double kDaily_K = 1.5;
constexpr double kContrastOfANight = 0.005;
constexpr double kContrastDrift = 0.002;
constexpr double kTolerance_um = 10;
constexpr int kMonth = 30;

/// What the fault has done at an age, in its channel's measure: um, times, share.
double effect(const Fault& fault, int age) {
  if (age < 1) return 0;
  switch (fault.shape) {
    case FaultShape::Step:
      return fault.size;
    case FaultShape::Ramp:
      return fault.channel == Channel::Contrast ? fault.size * age * age : fault.size * age;
    case FaultShape::Wild:
      return age == 1 ? fault.size : 0;
    default:
      return 0;
  }
}

double drawn(Random& random, double median, double factor) {
  return median * std::pow(factor, random.normal());
}

Eigen::Vector2d two(Random& random) {
  const double first = random.normal();
  return {first, random.normal()};
}

}  // namespace

Year::Year(std::uint64_t seed, double season_kelvin)
    : seed_(seed), season_kelvin_(season_kelvin), walk_um_{} {
  Random random = seed_.fork(0);
  drift_um_ = drawn(random, 0.3, 1.6);
  repeatability_um_ = drawn(random, 0.7, 1.5);
  um_per_kelvin_ = random.normal();
  turn_rad_ = random.uniform(0, 2 * std::numbers::pi);
  Eigen::Vector2d at_um(51200, -3700);
  double contrast = std::log(120);
  for (std::size_t i = 0; i < walk_um_.size(); ++i) {
    at_um += drift_um_ * two(random);
    contrast += kContrastDrift * random.normal();
    walk_um_[i] = at_um;
    walk_of_contrast_[i] = contrast;
  }
}

Year::Night Year::night(int i, const Fault& fault, int onset) {
  const int age = i - onset + 1;
  const double done = effect(fault, age);
  const bool has_begun = age >= 1;
  Random random = seed_.fork(static_cast<std::uint64_t>(i) + 1);
  const auto at = static_cast<std::size_t>(i);
  Night out;
  DriftPoint& offset = out.offset;
  offset.time = std::chrono::sys_seconds(std::chrono::seconds(86400LL * (20000 + i)));
  double kelvin = kDaily_K * random.normal() -
                  season_kelvin_ * std::cos(2 * std::numbers::pi * i / kNightsOfAYear);
  if (fault.shape == FaultShape::Temperature && has_begun) kelvin += fault.size;
  offset.temperature_c = 21 + kelvin;
  const Eigen::Vector2d stated = two(random);
  const Eigen::Vector2d of_night = two(random);
  const Eigen::Vector2d loose = two(random);
  Eigen::Vector2d value_um = walk_um_[at] + repeatability_um_ * of_night;
  value_um.x() += um_per_kelvin_ * kelvin;
  const double root = std::sqrt(1 - kCorrelation * kCorrelation);
  value_um.x() += kStated_um * stated.x();
  value_um.y() += kStated_um * (kCorrelation * stated.x() + root * stated.y());
  if (fault.channel == Channel::Offset) {
    value_um += done * Eigen::Vector2d(std::cos(turn_rad_), std::sin(turn_rad_));
    if (fault.shape == FaultShape::Loose && has_begun) value_um += fault.size * loose;
  }
  offset.value = 1e-3 * value_um;
  offset.cov.resize(2, 2);
  offset.cov << 1, kCorrelation, kCorrelation, 1;
  offset.cov *= 1e-6 * kStated_um * kStated_um;
  double sum = 0;
  for (int k = 0; k < kDegreesOfFreedom; ++k) sum += std::pow(random.normal(), 2);
  double times = 1;
  if (fault.channel == Channel::Scatter && done > 0) {
    times = fault.shape == FaultShape::Ramp ? 1 + done : done;
  }
  out.scatter.time = offset.time;
  out.scatter.degrees_of_freedom = kDegreesOfFreedom;
  out.scatter.variance = std::pow(1e-3 * kHoles_um * times, 2) * sum / kDegreesOfFreedom;
  out.contrast.time = offset.time;
  const double noise = kContrastOfANight * random.normal();
  const double lost = fault.channel == Channel::Contrast ? done : 0;
  out.contrast.value = Eigen::VectorXd::Constant(1, walk_of_contrast_[at] + noise - lost);
  out.contrast.cov = Eigen::MatrixXd::Constant(1, 1, 1e-8);
  return out;
}

bool Year::is_broken(const Fault& fault, int age) {
  switch (fault.channel) {
    case Channel::Offset:
      if (std::abs(effect(fault, age)) > kTolerance_um) return true;
      break;
    case Channel::Scatter:
      if (effect(fault, age) + (fault.shape == FaultShape::Ramp ? 1 : 0) >= 2) return true;
      break;
    case Channel::Contrast:
      if (effect(fault, age) >= std::numbers::ln2) return true;
      break;
  }
  return age >= kMonth && !(fault.shape == FaultShape::Ramp);
}

}  // namespace panelcal::bench
