// SPDX-License-Identifier: Apache-2.0
#include "vision/render/outline_circle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/base/statistics/random.h"

namespace panelcal::internal {
namespace {

constexpr int kMaxCircleOrder = 1000;
/// The rim stays outside of this share of the radius, so that it never crosses itself.
constexpr double kLeastRadius = 0.4;
/// Between samples, 32 a wave, a wave exceeds them by less than this.
constexpr int kSamplesPerWave = 32;
constexpr double kCircleMargin = 1.01;

}  // namespace

RoughCircle::RoughCircle(double radius_mm, const Roughness& roughness)
    : radius_mm_(radius_mm),
      lowest_order_(std::clamp(roughness.lowest_order, 2, kMaxCircleOrder)),
      reach_mm_(radius_mm),
      speed_mm_(radius_mm) {
  if (!(roughness.rms > mm(0)) || !(radius_mm > 0)) return;
  Random random(roughness.seed);
  const int highest = std::clamp(roughness.highest_order, lowest_order_, kMaxCircleOrder);
  double power = 0;
  for (int order = lowest_order_; order <= highest; ++order) {
    const double cosine = random.normal() / order;
    const double sine = random.normal() / order;
    waves_mm_.push_back({cosine, sine});
    power += 0.5 * (cosine * cosine + sine * sine);
  }
  const double to_rms = roughness.rms.in_mm() / std::sqrt(power);
  for (Eigen::Vector2d& wave : waves_mm_) wave *= to_rms;

  double most = 0;
  double steepest = 0;
  const int n = kSamplesPerWave * highest;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector2d r = evaluate(2 * std::numbers::pi * i / n);
    most = std::max(most, std::abs(r.x() - radius_mm));
    steepest = std::max(steepest, std::abs(r.y()));
  }
  const double limit = std::min(1.0, (1 - kLeastRadius) * radius_mm / (kCircleMargin * most));
  for (Eigen::Vector2d& wave : waves_mm_) wave *= limit;
  reach_mm_ = radius_mm + kCircleMargin * limit * most;
  speed_mm_ = reach_mm_ + kCircleMargin * limit * steepest;
}

Eigen::Vector2d RoughCircle::evaluate(double angle_rad) const {
  Eigen::Vector2d result(radius_mm_, 0);
  if (waves_mm_.empty()) return result;
  const double step_c = std::cos(angle_rad);
  const double step_s = std::sin(angle_rad);
  double c = std::cos(lowest_order_ * angle_rad);
  double s = std::sin(lowest_order_ * angle_rad);
  int order = lowest_order_;
  for (const Eigen::Vector2d& wave : waves_mm_) {
    result.x() += wave.x() * c + wave.y() * s;
    result.y() += order * (wave.y() * c - wave.x() * s);
    const double next_c = c * step_c - s * step_s;
    s = s * step_c + c * step_s;
    c = next_c;
    ++order;
  }
  return result;
}

int RoughCircle::highest_order() const {
  return waves_mm_.empty() ? 0 : lowest_order_ + static_cast<int>(waves_mm_.size()) - 1;
}

/// Half the integral of r^2: waves of different orders do not mix (Parseval).
double RoughCircle::area_mm2() const {
  double squares = radius_mm_ * radius_mm_;
  for (const Eigen::Vector2d& wave : waves_mm_) squares += 0.5 * wave.squaredNorm();
  return std::numbers::pi * squares;
}

}  // namespace panelcal::internal
