// SPDX-License-Identifier: Apache-2.0
#include "vision/suggest/outline_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>

#include <opencv2/imgproc.hpp>

namespace panelcal::internal {
namespace {

/// Outlines follow pixels: their points are so far from a smooth rim, rms.
constexpr double kStep_px = 0.35;
constexpr double kMaxRoughness = 0.025;  ///< rms deviation from a shape over its size
/// Points farther from a circle than this share of its radius do not belong to it.
constexpr double kCircleReach = 0.06;
constexpr double kMinOnCircle = 0.75;
constexpr int kOutlineSectors = 36;
constexpr double kMaxAspect = 1.12;
constexpr double kMinBar = 0.08;  ///< of a cross's bars over their length
constexpr double kMaxBar = 0.6;

struct OutlineCircle {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double radius = 0;

  double deviation(const Eigen::Vector2d& u) const { return (u - center).norm() - radius; }
  double reach() const { return std::max(1.0, kCircleReach * radius); }
};

/// The circle through points, least squares of the distances' squares (Kasa 1976).
OutlineCircle circle_through(std::span<const Eigen::Vector2d> points, const OutlineCircle* near) {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& u : points) origin += u / static_cast<double>(points.size());
  cv::Matx33d left = cv::Matx33d::zeros();
  cv::Vec3d right(0, 0, 0);
  for (const Eigen::Vector2d& u : points) {
    if (near != nullptr && std::abs(near->deviation(u)) > near->reach()) continue;
    const Eigen::Vector2d v = u - origin;
    const cv::Vec3d row(2 * v.x(), 2 * v.y(), 1);
    left += row * row.t();
    right += row * v.squaredNorm();
  }
  cv::Vec3d solution;
  if (!cv::solve(left, right, solution, cv::DECOMP_CHOLESKY)) return {};
  const Eigen::Vector2d center(solution[0], solution[1]);
  return {origin + center, std::sqrt(std::max(0.0, solution[2] + center.squaredNorm()))};
}

double quality_of(double rms_px, double size_px, double part) {
  const double limit_px = kMaxRoughness * size_px + kStep_px;
  return rms_px > limit_px ? 0 : part * (1 - 0.5 * rms_px / limit_px);
}

std::ptrdiff_t count_on(std::span<const Eigen::Vector2d> points, const OutlineCircle& circle) {
  if (!(circle.radius > 0)) return 0;
  return std::ranges::count_if(points, [&](const Eigen::Vector2d& u) {
    return std::abs(circle.deviation(u)) <= circle.reach();
  });
}

/// The circle on which the most points lie, of those through a quarter of the outline and through
/// all of it: a track may make up half of a pad's outline.
OutlineCircle first_circle(std::span<const Eigen::Vector2d> points) {
  OutlineCircle best = circle_through(points, nullptr);
  std::ptrdiff_t n_best = count_on(points, best);
  constexpr double kPlainPart = 0.95;
  if (static_cast<double>(n_best) >= kPlainPart * static_cast<double>(points.size())) return best;
  constexpr std::size_t kArcs = 12;
  const std::size_t n_arc = points.size() / 4;
  for (std::size_t i = 0; i < kArcs; ++i) {
    const std::size_t begin = (points.size() - n_arc) * i / (kArcs - 1);
    const OutlineCircle circle = circle_through(points.subspan(begin, n_arc), nullptr);
    const std::ptrdiff_t n = count_on(points, circle);
    if (n <= n_best) continue;
    best = circle;
    n_best = n;
  }
  return best;
}

std::optional<OutlineShape> as_disc(std::span<const Eigen::Vector2d> points) {
  OutlineCircle circle = first_circle(points);
  for (int i = 0; i < 6 && circle.radius > 0; ++i) circle = circle_through(points, &circle);
  if (!(circle.radius > 0)) return std::nullopt;
  std::array<bool, kOutlineSectors> is_seen{};
  double sum_px2 = 0;
  int n = 0;
  for (const Eigen::Vector2d& u : points) {
    const double deviation = circle.deviation(u);
    if (std::abs(deviation) > circle.reach()) continue;
    const Eigen::Vector2d v = u - circle.center;
    const double turn = std::atan2(v.y(), v.x()) / (2 * std::numbers::pi) + 0.5;
    is_seen[static_cast<std::size_t>(turn * kOutlineSectors) % kOutlineSectors] = true;
    sum_px2 += deviation * deviation;
    ++n;
  }
  const double part = static_cast<double>(std::ranges::count(is_seen, true)) / kOutlineSectors;
  if (part < kMinOnCircle) return std::nullopt;
  const double quality = quality_of(std::sqrt(sum_px2 / n), circle.radius, part);
  if (quality == 0) return std::nullopt;
  return OutlineShape{Shape::Disc, circle.center, 2 * circle.radius, 0, 0, quality};
}

/// An angle brought into (-45, 45] degrees: what a quarter turn does not change.
double within_eighth(double angle_rad) {
  const double quarter = std::numbers::pi / 2;
  return angle_rad - quarter * std::ceil(angle_rad / quarter - 0.5);
}

/// Squares on their tips are diamonds, whose angle counts from there.
void name_square(OutlineShape& square) {
  constexpr double kSixteenth = std::numbers::pi / 8;
  if (std::abs(square.angle_rad) <= kSixteenth) return;
  square.shape = Shape::Diamond;
  square.angle_rad = within_eighth(square.angle_rad + std::numbers::pi / 4);
}

std::optional<OutlineShape> as_square(std::span<const Eigen::Vector2d> points, double area_px2) {
  std::vector<cv::Point2f> corners;
  for (const Eigen::Vector2d& u : points) {
    corners.emplace_back(static_cast<float>(u.x()), static_cast<float>(u.y()));
  }
  const cv::RotatedRect box = cv::minAreaRect(corners);
  const double longer = std::max(box.size.width, box.size.height);
  const double shorter = std::min(box.size.width, box.size.height);
  if (!(shorter > 0) || longer > kMaxAspect * shorter) return std::nullopt;
  const double side = std::sqrt(area_px2);
  const double angle = box.angle * std::numbers::pi / 180;
  const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
  const Eigen::Vector2d across(-along.y(), along.x());
  const Eigen::Vector2d center(box.center.x, box.center.y);
  double sum_px2 = 0;
  for (const Eigen::Vector2d& u : points) {
    const Eigen::Vector2d v = u - center;
    const double far = std::max(std::abs(v.dot(along)) / box.size.width,
                                std::abs(v.dot(across)) / box.size.height);
    const double deviation = (2 * far - 1) * side / 2;
    sum_px2 += deviation * deviation;
  }
  const double rms = std::sqrt(sum_px2 / static_cast<double>(points.size()));
  const double quality = quality_of(rms, side / 2, 1);
  if (quality == 0) return std::nullopt;
  OutlineShape square{Shape::Square, center, side, 0, within_eighth(angle), quality};
  name_square(square);
  return square;
}

/// The direction of one of four arms: farther points count more.
double arms_angle(std::span<const Eigen::Vector2d> points, const Eigen::Vector2d& center) {
  std::complex<double> sum = 0;
  for (const Eigen::Vector2d& u : points) {
    const std::complex<double> v(u.x() - center.x(), u.y() - center.y());
    sum += v * v * v * v;
  }
  return std::arg(sum) / 4;
}

std::optional<OutlineShape> as_cross(std::span<const Eigen::Vector2d> points, double area_px2) {
  std::vector<cv::Point2f> contour;
  for (const Eigen::Vector2d& u : points) {
    contour.emplace_back(static_cast<float>(u.x()), static_cast<float>(u.y()));
  }
  const cv::Moments moments = cv::moments(contour);
  if (!(moments.m00 > 0)) return std::nullopt;
  const Eigen::Vector2d center(moments.m10 / moments.m00, moments.m01 / moments.m00);
  const double angle = arms_angle(points, center);
  const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
  const Eigen::Vector2d across(-along.y(), along.x());
  std::array<double, 4> ends{};
  for (const Eigen::Vector2d& u : points) {
    const double x = (u - center).dot(along);
    const double y = (u - center).dot(across);
    const std::array<double, 4> reached = {x, y, -x, -y};
    for (std::size_t i = 0; i < 4; ++i) ends[i] = std::max(ends[i], reached[i]);
  }
  const double length = (ends[0] + ends[1] + ends[2] + ends[3]) / 2;
  const auto [least, greatest] = std::ranges::minmax(ends);
  if (greatest > kMaxAspect * least || area_px2 >= length * length) return std::nullopt;
  const double width = length - std::sqrt(length * length - area_px2);
  if (width < kMinBar * length || width > kMaxBar * length) return std::nullopt;
  double sum_px2 = 0;
  for (const Eigen::Vector2d& u : points) {
    const double x = std::abs((u - center).dot(along));
    const double y = std::abs((u - center).dot(across));
    const double deviation =
        std::min(std::abs(std::max(x, y) - length / 2), std::abs(std::min(x, y) - width / 2));
    sum_px2 += deviation * deviation;
  }
  const double rms = std::sqrt(sum_px2 / static_cast<double>(points.size()));
  const double quality = quality_of(rms, length / 2, 1);
  if (quality == 0) return std::nullopt;
  return OutlineShape{Shape::Cross, center, length, width, within_eighth(angle), quality};
}

}  // namespace

std::optional<OutlineShape> shape_of(std::span<const Eigen::Vector2d> outline_px, double area_px2) {
  constexpr std::size_t kMinPoints = 16;
  if (outline_px.size() < kMinPoints) return std::nullopt;
  std::optional<OutlineShape> best;
  for (const auto& shape :
       {as_disc(outline_px), as_square(outline_px, area_px2), as_cross(outline_px, area_px2)}) {
    if (shape && (!best || shape->quality > best->quality)) best = shape;
  }
  return best;
}

}  // namespace panelcal::internal
