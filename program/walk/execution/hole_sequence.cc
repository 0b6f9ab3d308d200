// SPDX-License-Identifier: Apache-2.0
#include "program/walk/execution/hole_sequence.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace panelcal {
namespace {

/// Exact at both ends.
Eigen::Vector2d between(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double fraction) {
  return (1 - fraction) * a + fraction * b;
}

double ratio(std::int64_t numerator, std::int64_t denominator) {
  return static_cast<double>(numerator) / static_cast<double>(denominator);
}

/// The greatest power of two not above n. n >= 1.
std::int64_t bit_floor(std::int64_t n) {
  return static_cast<std::int64_t>(std::bit_floor(static_cast<std::uint64_t>(n)));
}

/// Height above the wall of the material between two holes of a row; infinite if the holes do not
/// meet.
double cusp_mm(double spacing_mm, double tool_diameter_mm) {
  const double radius_mm = 0.5 * tool_diameter_mm;
  const double half_mm = 0.5 * spacing_mm;
  if (half_mm > radius_mm) return INFINITY;
  // r - sqrt(r^2 - h^2) without cancellation.
  return half_mm * half_mm / (radius_mm + std::sqrt((radius_mm - half_mm) * (radius_mm + half_mm)));
}

}  // namespace

HoleSequence HoleSequence::rows(const Eigen::Vector2d& first_from_mm,
                                const Eigen::Vector2d& first_to_mm,
                                const Eigen::Vector2d& second_from_mm,
                                const Eigen::Vector2d& second_to_mm,
                                std::int64_t n_pitches) {
  HoleSequence out(Shape::Rows, n_pitches, 0);
  out.mm_ = {first_from_mm, first_to_mm, second_from_mm, second_to_mm};
  return out;
}

HoleSequence HoleSequence::outline(const Eigen::Vector2d& a_mm,
                                   const Eigen::Vector2d& b_mm,
                                   const Eigen::Vector2d& c_mm,
                                   std::int64_t n_ab,
                                   std::int64_t n_bc) {
  HoleSequence out(Shape::Outline, n_ab + n_bc, n_ab);
  out.mm_ = {a_mm, b_mm, c_mm, a_mm + (c_mm - b_mm)};
  return out;
}

HoleSequence HoleSequence::ring(const Eigen::Vector2d& center_mm,
                                const Eigen::Vector2d& first_mm,
                                std::int64_t n_holes) {
  HoleSequence out(Shape::Ring, n_holes, 0);
  out.mm_ = {center_mm, first_mm, center_mm, first_mm};
  return out;
}

HoleSequence HoleSequence::ring_passes(const Eigen::Vector2d& center_mm,
                                       const Eigen::Vector2d& first_mm,
                                       std::int64_t n_holes) {
  HoleSequence out = ring(center_mm, first_mm, n_holes);
  out.shape_ = Shape::RingPasses;
  return out;
}

HoleSequence HoleSequence::passes(const Eigen::Vector2d& start_mm,
                                  const Eigen::Vector2d& end_mm,
                                  std::int64_t n_first,
                                  std::int64_t n_steps) {
  HoleSequence out(Shape::Passes, n_steps, n_first);
  out.mm_ = {start_mm, end_mm, start_mm, end_mm};
  return out;
}

std::int64_t HoleSequence::size() const {
  switch (shape_) {
    case Shape::Rows:
      return 2 * (n_ + 1);
    case Shape::Outline:
      return 2 * n_;
    case Shape::Ring:
    case Shape::RingPasses:
      return n_;
    case Shape::Passes:
      return n_ + 1;
  }
  return 0;
}

Eigen::Vector2d HoleSequence::operator[](std::int64_t i) const {
  switch (shape_) {
    case Shape::Rows:
      return on_row(i);
    case Shape::Outline:
      return on_outline(i);
    case Shape::Ring:
      return on_ring(i);
    case Shape::RingPasses:
      return in_ring_pass(i);
    case Shape::Passes:
      return in_pass(i);
  }
  return mm_[0];
}

Eigen::Vector2d HoleSequence::on_row(std::int64_t i) const {
  return i <= n_ ? between(mm_[0], mm_[1], ratio(i, n_))
                 : between(mm_[2], mm_[3], ratio(i - n_ - 1, n_));
}

Eigen::Vector2d HoleSequence::on_outline(std::int64_t i) const {
  const std::size_t half = i < n_ ? 0 : 2;
  const std::int64_t k = i < n_ ? i : i - n_;
  if (k < n_first_) return between(mm_[half], mm_[half + 1], ratio(k, n_first_));
  return between(mm_[half + 1], mm_[(half + 2) % 4], ratio(k - n_first_, n_ - n_first_));
}

Eigen::Vector2d HoleSequence::on_ring(std::int64_t i) const {
  const double angle_rad = 2 * std::numbers::pi * ratio(i, n_);
  double cosine = std::cos(angle_rad);
  double sine = std::sin(angle_rad);
  if (4 * i % n_ == 0) {  // quarter turns to the last digit
    cosine = std::round(cosine);
    sine = std::round(sine);
  }
  const double x_mm = mm_[1].x();
  const double y_mm = mm_[1].y();
  return mm_[0] + Eigen::Vector2d(cosine * x_mm - sine * y_mm, sine * x_mm + cosine * y_mm);
}

Eigen::Vector2d HoleSequence::in_ring_pass(std::int64_t i) const {
  if (i == 0) return on_ring(0);
  // The passes have 1, 1, 2, 4 ... holes, so there are p before the one of p.
  const std::int64_t p = bit_floor(i);
  return on_ring((2 * (i - p) + 1) * (n_ / (2 * p)));
}

Eigen::Vector2d HoleSequence::in_pass(std::int64_t i) const {
  if (n_ == 0) return mm_[0];
  if (i <= n_first_) return between(mm_[0], mm_[1], ratio(i, n_first_));
  // The passes behind the first have n_first, 2 n_first, 4 n_first ... holes, so there are
  // n_first (p - 1) of these before the one of n_first p.
  const std::int64_t k = i - n_first_ - 1;
  const std::int64_t p = bit_floor(k / n_first_ + 1);
  const std::int64_t k_in_pass = k - n_first_ * (p - 1);
  return between(mm_[0], mm_[1], ratio(2 * k_in_pass + 1, 2 * n_first_ * p));
}

std::optional<std::int64_t> slot_steps(double length_mm,
                                       double n_first,
                                       double tool_diameter_mm,
                                       double max_cusp_mm) {
  double n_steps = n_first;
  while (n_steps < kMaxHoles && cusp_mm(length_mm / n_steps, tool_diameter_mm) >= max_cusp_mm) {
    n_steps *= 2;
  }
  if (!(n_steps < kMaxHoles)) return std::nullopt;
  return static_cast<std::int64_t>(n_steps);
}

std::optional<std::int64_t> ring_holes(double path_radius_mm,
                                       double tool_diameter_mm,
                                       double max_cusp_mm) {
  // The tip of the cusp between neighbours is at the distance a = d / 2 from both and at q from the
  // circle's centre; halfway between them is the angle b:  a^2 = q^2 + r^2 - 2 q r cos b.  With
  // q = r + a - c this is  4 q r sin^2(b / 2) = a^2 - (q - r)^2 = c (2 a - c).
  const double tool_radius_mm = 0.5 * tool_diameter_mm;
  const double cusp_limit_mm = std::min(max_cusp_mm, tool_radius_mm);  // neighbours meet at least
  const double tip_mm = path_radius_mm + tool_radius_mm - cusp_limit_mm;
  const double sine = std::sqrt(cusp_limit_mm) *
                      std::sqrt((tool_diameter_mm - cusp_limit_mm) / (4 * tip_mm)) /
                      std::sqrt(path_radius_mm);
  const double n_holes = std::floor(std::numbers::pi / (2 * std::asin(sine))) + 1;
  if (!(n_holes <= kMaxHoles)) return std::nullopt;
  return static_cast<std::int64_t>(n_holes);
}

}  // namespace panelcal
