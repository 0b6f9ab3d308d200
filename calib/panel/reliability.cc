// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/reliability.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "calib/base/statistics/chi_square.h"
#include "calib/panel/model.h"
#include "calib/panel/system.h"

namespace panelcal::internal {
namespace {

constexpr int kUnseenDirections = 12;  ///< over half a turn
/// A direction in which less than this of an error shows is one that does not show.
constexpr double kInvisible = 1e-9;

/// Rotation, stretches and shear of the panel, as the gates see them.
using GatedNumbers = std::array<double, 4>;

GatedNumbers gated_numbers(const Eigen::Matrix2d& linear, const GateLimits& limits) {
  Eigen::Matrix2d from_meant;
  for (int column = 0; column < 2; ++column) {
    from_meant.col(column) = turned_by(linear.col(column), 360 - limits.turned_deg);
  }
  const PanelDeformation d = deformation_of(from_meant);
  return {d.rotation_rad, d.scale_x - 1, std::abs(d.scale_y) - 1, d.shear};
}

/// The way that something can go that begins at `value` and changes by `rate` may go in either
/// direction.
void limit_by(double value, double rate, double limit, double& forward, double& back) {
  if (!(std::abs(rate) > 0)) return;
  forward = std::min(forward, (limit - std::copysign(1, rate) * value) / std::abs(rate));
  back = std::min(back, (limit + std::copysign(1, rate) * value) / std::abs(rate));
}

class UnseenSearch {
 public:
  UnseenSearch(std::span<const RawPair> pairs,
               const Eigen::Matrix2d& linear,
               const Eigen::Matrix<double, 6, Eigen::Dynamic>& gain,
               double noncentrality,
               const GateLimits& limits)
      : pairs_(pairs),
        linear_(linear),
        gain_(gain),
        noncentrality_(noncentrality),
        limits_(limits),
        gated_(gated_numbers(linear, limits)) {}

  void add_target(std::size_t i, std::vector<UnseenError>& out) const {
    for (const Eigen::Vector2d& direction : directions(i)) {
      const double length_mm = largest_mm(i, direction);
      const bool is_unlimited = !(length_mm < kUnlimitedError_mm);
      out.push_back({i, (is_unlimited ? kUnlimitedError_mm : length_mm) * direction, is_unlimited});
    }
  }

 private:
  Eigen::Matrix2d response(std::size_t j, std::size_t i) const {
    Eigen::Matrix2d r =
        -design(pairs_[j].from_mm) * gain_.middleCols<2>(2 * static_cast<Eigen::Index>(i));
    if (i == j) r += Eigen::Matrix2d::Identity();
    for (const int axis : {0, 1}) {
      const bool is_seen = axis == 0 ? observes_x(pairs_[j].axes) : observes_y(pairs_[j].axes);
      if (!is_seen) r.row(axis).setZero();
    }
    return r;
  }

  /// Q of the header, of the coordinates that the target shows.
  Eigen::Matrix2d information(std::size_t i) const {
    const auto whitening = internal::whitening(pairs_[i]);
    if (!whitening) return Eigen::Matrix2d::Zero();
    const Eigen::Matrix2d q = whitening->transpose() * *whitening * response(i, i);
    return 0.5 * (q + q.transpose());
  }

  /// Unit vectors that lie evenly on the ellipse u' Q u = 1, however long it is.
  std::vector<Eigen::Vector2d> directions(std::size_t i) const {
    std::vector<Eigen::Vector2d> out;
    if (pairs_[i].axes == ObservedAxes::X) return {Eigen::Vector2d::UnitX()};
    if (pairs_[i].axes == ObservedAxes::Y) return {Eigen::Vector2d::UnitY()};
    const Eigen::Matrix2d q = information(i);
    const double mean = q.trace() / 2;
    const double half = std::hypot((q(0, 0) - q(1, 1)) / 2, q(0, 1));
    const double angle = std::atan2(2 * q(0, 1), q(0, 0) - q(1, 1)) / 2;
    const Eigen::Vector2d strong(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d weak(-strong.y(), strong.x());
    const double floor = kInvisible * std::max(mean + half, std::numeric_limits<double>::min());
    const double ratio = std::sqrt(std::max(mean - half, floor) / std::max(mean + half, floor));
    for (int k = 0; k < kUnseenDirections; ++k) {
      const double phi = std::numbers::pi * k / kUnseenDirections;
      out.push_back((ratio * std::cos(phi) * strong + std::sin(phi) * weak).normalized());
    }
    return out;
  }

  double largest_mm(std::size_t i, const Eigen::Vector2d& direction) const {
    double forward = std::numeric_limits<double>::infinity();
    double back = forward;
    const Eigen::Matrix2d q = information(i);
    const double shown = direction.dot(q * direction);
    if (shown > kInvisible * q.trace()) forward = back = std::sqrt(noncentrality_ / shown);
    if (limits_.residual) {
      for (std::size_t j = 0; j < pairs_.size(); ++j) {
        const double rate = (response(j, i) * direction).norm();
        limit_by(0, rate > kInvisible ? rate : 0, limits_.residual->in_mm(), forward, back);
      }
    }
    limit_by_deformation(i, direction, forward, back);
    if (limits_.offset) {
      const auto n = static_cast<double>(pairs_.size());
      limit_by(0, 1 / n, limits_.offset->in_mm(), forward, back);
    }
    return std::max(forward, back);
  }

  void limit_by_deformation(std::size_t i,
                            const Eigen::Vector2d& direction,
                            double& forward,
                            double& back) const {
    constexpr double kStep_mm = 1e-3;
    const Eigen::Matrix<double, 6, 1> rate =
        gain_.middleCols<2>(2 * static_cast<Eigen::Index>(i)) * direction;
    Eigen::Matrix2d moved;
    moved << rate[0], rate[1], rate[2], rate[3];
    const GatedNumbers then = gated_numbers(linear_ + kStep_mm * moved, limits_);
    for (std::size_t k = 0; k < gated_.size(); ++k) {
      const std::optional<double> limit =
          k == 0 ? limits_.rotation ? std::optional(limits_.rotation->in_rad()) : std::nullopt
          : limits_.stretch_ppm ? std::optional(*limits_.stretch_ppm * 1e-6)
                                : std::nullopt;
      const double change = (then[k] - gated_[k]) / kStep_mm;
      // Rounding is no change.
      if (limit) limit_by(gated_[k], std::abs(change) > 1e-10 ? change : 0, *limit, forward, back);
    }
  }

  std::span<const RawPair> pairs_;
  const Eigen::Matrix2d& linear_;
  const Eigen::Matrix<double, 6, Eigen::Dynamic>& gain_;
  double noncentrality_;
  const GateLimits& limits_;
  GatedNumbers gated_;
};

}  // namespace

Reliability reliability_raw(std::span<const RawPair> pairs,
                            const Eigen::Matrix2d& linear,
                            const Eigen::Matrix<double, 6, Eigen::Dynamic>& gain,
                            double chi_square,
                            int degrees_of_freedom,
                            const GateLimits& limits) {
  Reliability out;
  out.degrees_of_freedom = degrees_of_freedom;
  out.noise_ratio2 = std::numeric_limits<double>::infinity();
  double noncentrality = std::numeric_limits<double>::infinity();
  if (degrees_of_freedom > 0) {
    // Targets that agree better than healthy ones do on average hide no less by it.
    const double seen = std::max<double>(chi_square, degrees_of_freedom);
    noncentrality = largest_noncentrality(seen, degrees_of_freedom, kUnseenChance);
  }
  if (degrees_of_freedom >= kLeastSpareEquations) {
    const double least = chi_square_limit(1 - kUnseenChance, degrees_of_freedom);
    out.noise_ratio2 = std::max(1.0, chi_square / least);
  }
  const UnseenSearch search(pairs, linear, gain, noncentrality, limits);
  for (std::size_t i = 0; i < pairs.size(); ++i) search.add_target(i, out.unseen);
  return out;
}

}  // namespace panelcal::internal
