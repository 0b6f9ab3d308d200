// SPDX-License-Identifier: Apache-2.0
#include "vision/round/rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "calib/base/statistics/median.h"
#include <Eigen/Cholesky>

namespace panelcal::internal {
namespace {

constexpr int kRays = 64;
constexpr double kLookInwards = 0.25;  // of the radius
constexpr double kLookOutwards = 0.3;
constexpr double kStepPx = 0.5;
constexpr double kMinSupport = 0.4;
/// Spread of the weights of steps by their radius, of the radius expected.
constexpr double kLooseSpread = 0.15;
constexpr double kTightSpread = 0.06;
constexpr double kSpreadTolerances = 2;
/// Rings of which one has the size lie this far apart, or look like one edge.
constexpr double kRingsApart_px = 1.2;
constexpr double kOffCentre_px = 3;
/// Samples that are averaged on either side of a step.
constexpr int kFewestBeside = 2;
constexpr int kMostBeside = 6;
constexpr int kMostBetweenRings = 3;

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
  std::optional<float> operator()(const Eigen::Vector2d& offset) const {
    const Eigen::Vector2d u = center_px_ + px_from_frame_ * offset;
    if (!is_inside(u)) return std::nullopt;
    return level(static_cast<float>(u.x()), static_cast<float>(u.y()));
  }

  /// Levels at from, from + step .. to along a direction; false if an end is outside of the
  /// picture.
  bool along(const Eigen::Vector2d& e,
             double from,
             double to,
             double step,
             std::vector<float>& levels) const {
    levels.clear();
    if (to < from) return true;
    const Eigen::Vector2d first = center_px_ + px_from_frame_ * (from * e);
    const auto n = 1 + static_cast<int>((to - from) / step);
    const Eigen::Vector2d stride = px_from_frame_ * (step * e);
    // All between two inside places is inside.
    if (!is_inside(first) || !is_inside(first + (n - 1) * stride)) return false;
    levels.resize(static_cast<std::size_t>(n));
    for (int k = 0; k < n; ++k) {
      levels[static_cast<std::size_t>(k)] = level(static_cast<float>(first.x() + k * stride.x()),
                                                  static_cast<float>(first.y() + k * stride.y()));
    }
    return true;
  }

 private:
  bool is_inside(const Eigen::Vector2d& u) const {
    return u.x() >= 0 && u.y() >= 0 && u.x() < image_.width() - 1 && u.y() < image_.height() - 1;
  }
  /// Precondition: inside, but for rounding.
  float level(float ux, float uy) const {
    const int x = std::min(static_cast<int>(ux), image_.width() - 2);
    const int y = std::min(static_cast<int>(uy), image_.height() - 2);
    const float tx = ux - static_cast<float>(x);
    const float ty = uy - static_cast<float>(y);
    const float* const above = image_.row(y).data() + x;
    const float* const below = above + image_.width();
    return (1 - ty) * ((1 - tx) * above[0] + tx * above[1]) +
           ty * ((1 - tx) * below[0] + tx * below[1]);
  }

  const Image& image_;
  bool usable_ = false;
  Eigen::Vector2d center_px_ = Eigen::Vector2d::Zero();
  Eigen::Matrix2d px_from_frame_ = Eigen::Matrix2d::Identity();
};

const Eigen::Vector2d& direction(int i_ray) {
  static const std::array<Eigen::Vector2d, kRays> all = [] {
    std::array<Eigen::Vector2d, kRays> rays;
    for (int i = 0; i < kRays; ++i) {
      const double angle = 2 * std::numbers::pi * i / kRays;
      rays[static_cast<std::size_t>(i)] = {std::cos(angle), std::sin(angle)};
    }
    return rays;
  }();
  return all[static_cast<std::size_t>(i_ray)];
}

/// The best step on one ray.
struct RayStep {
  double radius = 0;
  double height = 0;  ///< inner side minus outer side, times the sign looked for
};

/// A radius, and how far from it (1) a step counts less: times exp(-1/2).
struct PreferredRadius {
  double radius = 0;
  double spread = kLooseSpread;
  int most_beside = kMostBeside;
};

/// Where rays look for steps.
struct RayRange {
  double from = 0;
  double to = 0;
};

PreferredRadius preferred_radius(const ExpectedRim& expected, RimChoice choice) {
  if (choice == RimChoice::OfItsSize) {
    const double spread = std::max(expected.size_tolerance, kRingsApart_px / expected.radius);
    return {expected.radius, spread, kMostBetweenRings};
  }
  // Other rings around a rim, such as a mask's opening, often show the stronger edge.
  return {expected.radius,
          std::clamp(kSpreadTolerances * expected.size_tolerance, kTightSpread, kLooseSpread)};
}

/// In     radius: of the rim as far as it is known
RayRange ray_range(const ExpectedRim& expected, double radius, RimChoice choice) {
  if (choice == RimChoice::OfItsSize) {
    const double off = expected.size_tolerance * expected.radius + kOffCentre_px;
    return {std::max(0.0, expected.radius - off), expected.radius + off};
  }
  return {std::max(0.0, radius * (1 - kLookInwards) - 2), radius * (1 + kLookOutwards) + 2};
}

/// Looks for the largest step of the right sign between two radii, some preferred.
class StepFinder {
 public:
  StepFinder(
      const RaySampler& sample, double from, double to, PreferredRadius preferred, double sign)
      : sample_(sample),
        from_(from),
        half_(std::clamp(static_cast<int>(0.12 * preferred.radius / kStepPx),
                         kFewestBeside,
                         preferred.most_beside)),
        sign_(sign) {
    for (double r = from; r <= to; r += kStepPx) {
      const double z = (r / preferred.radius - 1) / preferred.spread;
      preference_.push_back(static_cast<float>(std::exp(-0.5 * z * z)));
    }
  }

  /// In     to: at most that of the constructor
  std::optional<RayStep> best(const Eigen::Vector2d& e, double to) {
    if (!sample_.along(e, from_, to, kStepPx, levels_)) return std::nullopt;
    const int n = std::min(static_cast<int>(levels_.size()), static_cast<int>(preference_.size()));
    float best_merit = 0;
    float best_step = 0;
    int best_i = -1;
    // Means of the `half_` samples before and behind, kept up to date.
    float difference = 0;
    for (int k = 1; k <= half_ && n > 2 * half_; ++k) difference += at(half_ - k) - at(half_ + k);
    for (int i = half_; i + half_ < n; ++i) {
      const float step = difference * static_cast<float>(sign_);
      const float merit = step * preference_[static_cast<std::size_t>(i)];
      if (merit > best_merit) {
        best_merit = merit;
        best_step = step;
        best_i = i;
      }
      if (i + half_ + 1 < n) difference += at(i) + at(i + 1) - at(i - half_) - at(i + half_ + 1);
    }
    if (best_i < 0) return std::nullopt;
    return RayStep{from_ + best_i * kStepPx, static_cast<double>(best_step) / half_};
  }

 private:
  float at(int i) const { return levels_[static_cast<std::size_t>(i)]; }

  const RaySampler& sample_;
  double from_;
  int half_;
  double sign_;
  std::vector<float> preference_;
  std::vector<float> levels_;
};

struct Rays {
  std::array<std::optional<RayStep>, kRays> steps;
  int n_inside_picture = 0;
};

/// In     radius: about that of the rim, which says where rays end at the picture's border
Rays cast_rays(const RaySampler& sample,
               const RayRange& range,
               double radius,
               PreferredRadius preferred,
               double sign) {
  Rays rays;
  StepFinder finder(sample, range.from, range.to, preferred, sign);
  for (int i = 0; i < kRays; ++i) {
    const Eigen::Vector2d& e = direction(i);
    if (!sample(radius * e)) continue;
    ++rays.n_inside_picture;
    // Near the border the range is cut to what can be seen.
    double end = range.to;
    while (end > radius && !sample(end * e)) end -= 1;
    rays.steps[static_cast<std::size_t>(i)] = finder.best(e, end);
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
  circle.height = median(heights);
  circle.radius = median(radii);
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
    limit = std::max({1.0, 0.04 * circle.radius, 3 * kSigmasPerMedian * median(errors)});
  }
  return circle;
}

/// Level around a circle of radius r; the median, so that neighbours do not matter.
std::optional<double> ring_level_at(const RaySampler& sample, double r) {
  std::vector<float> levels;
  for (int i = 0; i < kRays; ++i) {
    if (const auto level = sample(r * direction(i))) levels.push_back(*level);
  }
  if (levels.empty()) return std::nullopt;
  return median(std::move(levels));
}

/// Radius of a ring's hole: the median over rays of the best step the other way.
double inner_radius_of(const RaySampler& sample, double radius, const ExpectedRim& expected) {
  const double guess = expected.inner_radius.value_or(0.55 * expected.radius);
  const double from = expected.inner_radius ? 0.6 * guess : 0.15 * radius;
  const double to = std::min(radius - 2, expected.inner_radius ? 1.4 * guess : radius - 3);
  std::vector<double> radii;
  StepFinder finder(sample, from, to, {guess}, -expected.sign());
  for (int i = 0; i < kRays; ++i) {
    const auto step = finder.best(direction(i), to);
    if (step) radii.push_back(step->radius);
  }
  return radii.size() < 8 ? guess : median(std::move(radii));
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
                                 double min_contrast,
                                 RimChoice choice) {
  constexpr int kPasses = 3;
  constexpr double kCentered_px = 0.02;
  Eigen::Vector2d at = center;
  double radius = expected.radius;
  const PreferredRadius preferred = preferred_radius(expected, choice);
  RimStart start;
  std::optional<RayCircle> circle;
  for (int pass = 0; pass < kPasses; ++pass) {
    const RaySampler sample(image, fit_frame, at);
    if (!sample.usable()) return std::nullopt;
    const RayRange range = ray_range(expected, radius, choice);
    const Rays rays = cast_rays(sample, range, radius, preferred, expected.sign());
    circle = fit_circle(rays);
    if (!circle || circle->height < min_contrast) return std::nullopt;
    if ((at + circle->shift - center).norm() > expected.radius) return std::nullopt;
    at += circle->shift;
    radius = circle->radius;
    start.support = static_cast<double>(circle->n_supporting) / std::max(1, rays.n_inside_picture);
    // A ray circle leaves out of a shift its square over the diameter.
    if (circle->shift.squaredNorm() < 2 * radius * kCentered_px) break;
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
  const auto around = ring_level_at(sample, radius + std::max(3.0, 0.1 * radius));
  const auto on = ring_level_at(sample, 0.5 * (std::max(p[kInnerRadius], 0.5 * radius) + radius));
  if (!around || !on) return std::nullopt;
  p[kLevel] = *around;
  p[kContrast] = *on - *around;
  start.is_of_its_size = choice == RimChoice::OfItsSize;
  start.inside = inside_share(sample, radius);
  start.at_border = start.inside < 1;
  return start;
}

}  // namespace panelcal::internal
