// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/rim_rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Cholesky>

namespace panelcal::internal {
namespace {

constexpr int kRays = 64;
constexpr double kLookInwards = 0.25;  // of the radius
constexpr double kLookOutwards = 0.3;
constexpr double kStepPx = 0.5;
constexpr double kMinSupport = 0.4;

/// Picture coordinates of rays: the frame's local linear map is enough for a start value.
class RaySampler {
 public:
  RaySampler(const Image& image, const FitFrame& fit_frame, const Eigen::Vector2d& center)
      : image_(image) {
    const auto u = fit_frame.to_image(center);
    usable_ = u.has_value();
    if (!usable_) return;
    center_px_ = *u;
    const Eigen::Matrix2d j = fit_frame.jacobian(*u);
    const double det = j(0, 0) * j(1, 1) - j(0, 1) * j(1, 0);
    px_from_frame_ << j(1, 1), -j(0, 1), -j(1, 0), j(0, 0);
    px_from_frame_ /= det;
  }

  bool usable() const { return usable_; }

  /// The bilinear level at an offset from the centre; empty outside of the picture.
  std::optional<double> operator()(const Eigen::Vector2d& offset) const {
    const Eigen::Vector2d u = center_px_ + px_from_frame_ * offset;
    const double fx = std::floor(u.x());
    const double fy = std::floor(u.y());
    if (!(fx >= 0) || !(fy >= 0) || !(fx < image_.width() - 1) || !(fy < image_.height() - 1)) {
      return std::nullopt;
    }
    const int x = static_cast<int>(fx);
    const int y = static_cast<int>(fy);
    const double tx = u.x() - fx;
    const double ty = u.y() - fy;
    return (1 - ty) * ((1 - tx) * image_.at(x, y) + tx * image_.at(x + 1, y)) +
           ty * ((1 - tx) * image_.at(x, y + 1) + tx * image_.at(x + 1, y + 1));
  }

 private:
  const Image& image_;
  bool usable_ = false;
  Eigen::Vector2d center_px_ = Eigen::Vector2d::Zero();
  Eigen::Matrix2d px_from_frame_ = Eigen::Matrix2d::Identity();
};

Eigen::Vector2d direction(int i_ray) {
  const double angle = 2 * std::numbers::pi * i_ray / kRays;
  return {std::cos(angle), std::sin(angle)};
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The best step on one ray.
struct RayStep {
  double radius = 0;
  double height = 0;  ///< inner side minus outer side, times the sign looked for
};

/// The largest step of the right sign between two radii, steps near `expected` preferred.
std::optional<RayStep> best_step(const RaySampler& sample,
                                 const Eigen::Vector2d& e,
                                 double from,
                                 double to,
                                 double expected,
                                 double sign) {
  std::vector<double> levels;
  for (double r = from; r <= to; r += kStepPx) {
    const auto level = sample(r * e);
    if (!level) return std::nullopt;
    levels.push_back(*level);
  }
  const int half = std::clamp(static_cast<int>(0.12 * expected / kStepPx), 2, 6);
  std::optional<RayStep> best;
  double best_merit = 0;
  for (int i = half; i + half < static_cast<int>(levels.size()); ++i) {
    double step = 0;
    for (int k = 1; k <= half; ++k) {
      step += levels[static_cast<std::size_t>(i - k)] - levels[static_cast<std::size_t>(i + k)];
    }
    step *= sign / half;
    const double r = from + i * kStepPx;
    const double z = (r - expected) / (0.15 * expected);
    const double merit = step * std::exp(-0.5 * z * z);
    if (merit > best_merit) {
      best_merit = merit;
      best = RayStep{r, step};
    }
  }
  return best;
}

struct Rays {
  std::array<std::optional<RayStep>, kRays> steps;
  int n_inside_picture = 0;
};

Rays cast_rays(const RaySampler& sample, double from, double to, double expected, double sign) {
  Rays rays;
  for (int i = 0; i < kRays; ++i) {
    const Eigen::Vector2d e = direction(i);
    if (!sample(expected * e)) continue;
    ++rays.n_inside_picture;
    // Near the border the range is cut to what can be seen.
    double end = to;
    while (end > expected && !sample(end * e)) end -= 1;
    rays.steps[static_cast<std::size_t>(i)] = best_step(sample, e, from, end, expected, sign);
  }
  return rays;
}

/// A circle as seen from a place near its centre: r(angle) = radius + shift . e(angle).
struct RayCircle {
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double radius = 0;
  double height = 0;  ///< median step
  int n_supporting = 0;
};

std::optional<RayCircle> fit_circle(const Rays& rays) {
  std::vector<double> heights;
  std::vector<double> radii;
  for (const auto& step : rays.steps) {
    if (!step) continue;
    heights.push_back(step->height);
    radii.push_back(step->radius);
  }
  if (heights.size() < 8) return std::nullopt;
  RayCircle circle;
  circle.height = median_of(heights);
  circle.radius = median_of(radii);
  double limit = std::max(2.0, 0.12 * circle.radius);
  for (int pass = 0; pass < 5; ++pass) {
    Eigen::Matrix3d h = Eigen::Matrix3d::Identity() * 1e-9;
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    std::vector<double> errors;
    circle.n_supporting = 0;
    for (int i = 0; i < kRays; ++i) {
      const auto& step = rays.steps[static_cast<std::size_t>(i)];
      if (!step || step->height < 0.4 * circle.height) continue;
      const Eigen::Vector2d e = direction(i);
      const double error = step->radius - circle.radius - circle.shift.dot(e);
      if (std::abs(error) > limit) continue;
      ++circle.n_supporting;
      errors.push_back(std::abs(error));
      const Eigen::Vector3d row(e.x(), e.y(), 1);
      h += row * row.transpose();
      g += row * error;
    }
    if (circle.n_supporting < 8) return std::nullopt;
    const Eigen::Vector3d delta = h.ldlt().solve(g);
    circle.shift += delta.head<2>();
    circle.radius += delta.z();
    limit = std::max({1.0, 0.04 * circle.radius, 3 * 1.4826 * median_of(errors)});
  }
  return circle;
}

/// Level around a circle of radius r; the median, so that neighbours do not matter.
std::optional<double> level_at(const RaySampler& sample, double r) {
  std::vector<double> levels;
  for (int i = 0; i < kRays; ++i) {
    if (const auto level = sample(r * direction(i))) levels.push_back(*level);
  }
  if (levels.empty()) return std::nullopt;
  return median_of(std::move(levels));
}

/// Radius of a ring's hole: the median over rays of the best step the other way.
double inner_radius_of(const RaySampler& sample, double radius, const ExpectedRim& expected) {
  const double guess = expected.inner_radius.value_or(0.55 * expected.radius);
  const double from = expected.inner_radius ? 0.6 * guess : 0.15 * radius;
  const double to = std::min(radius - 2, expected.inner_radius ? 1.4 * guess : radius - 3);
  std::vector<double> radii;
  for (int i = 0; i < kRays; ++i) {
    const auto step = best_step(sample, direction(i), from, to, guess, -expected.sign());
    if (step) radii.push_back(step->radius);
  }
  return radii.size() < 8 ? guess : median_of(std::move(radii));
}

/// The part of a rim that is inside of the picture.
double inside_share(const RaySampler& sample, double radius) {
  int n_inside = 0;
  for (int i = 0; i < kRays; ++i) n_inside += sample((radius + 1) * direction(i)).has_value();
  return static_cast<double>(n_inside) / kRays;
}

}  // namespace

std::optional<RimStart> find_rim(const Image& image,
                                 const FitFrame& fit_frame,
                                 const Eigen::Vector2d& center,
                                 const ExpectedRim& expected,
                                 double min_contrast) {
  constexpr int kPasses = 3;
  Eigen::Vector2d at = center;
  double radius = expected.radius;
  RimStart start;
  std::optional<RayCircle> circle;
  for (int pass = 0; pass < kPasses; ++pass) {
    const RaySampler sample(image, fit_frame, at);
    if (!sample.usable()) return std::nullopt;
    const double from = std::max(0.0, radius * (1 - kLookInwards) - 2);
    const double to = radius * (1 + kLookOutwards) + 2;
    const Rays rays = cast_rays(sample, from, to, radius, expected.sign());
    circle = fit_circle(rays);
    if (!circle || circle->height < min_contrast) return std::nullopt;
    if ((at + circle->shift - center).norm() > expected.radius) return std::nullopt;
    at += circle->shift;
    radius = circle->radius;
    start.support = static_cast<double>(circle->n_supporting) / std::max(1, rays.n_inside_picture);
  }
  if (start.support < kMinSupport || radius < 2 || radius > 2 * expected.radius) {
    return std::nullopt;
  }
  const RaySampler sample(image, fit_frame, at);
  if (!sample.usable()) return std::nullopt;
  RimVector& p = start.parameters;
  p.head<2>() = at;
  p[kRadius] = radius;
  p[kSigma] = 1.2;
  if (expected.shape == Shape::Ring) p[kInnerRadius] = inner_radius_of(sample, radius, expected);
  const auto around = level_at(sample, radius + std::max(3.0, 0.1 * radius));
  const auto on = level_at(sample, 0.5 * (std::max(p[kInnerRadius], 0.5 * radius) + radius));
  if (!around || !on) return std::nullopt;
  p[kLevel] = *around;
  p[kContrast] = *on - *around;
  start.inside = inside_share(sample, radius);
  start.at_border = start.inside < 1;
  return start;
}

}  // namespace panelcal::internal
