// SPDX-License-Identifier: Apache-2.0
#include "machine/look/view_mean.h"

#include <algorithm>
#include <cmath>

#include "calib/base/statistics/linear_algebra.h"
#include <Eigen/Core>

namespace panelcal::internal {
namespace {

/// The coordinates that a view sees, as rows.
Eigen::MatrixXd seen_rows(const ViewDeviation& view) {
  if (!view.blind) return Eigen::Matrix2d::Identity();
  return Eigen::RowVector2d(-view.blind->y(), view.blind->x());
}

Eigen::Vector2d mean_mm(std::span<const PositionEstimate<frame::Actual>> places) {
  // About the first one, so that no digits are lost far from work zero.
  Eigen::Vector2d sum_mm = Eigen::Vector2d::Zero();
  for (const auto& place : places) {
    sum_mm += (place.position - places.front().position).in_mm();
  }
  return places.front().position.in_mm() + sum_mm / static_cast<double>(places.size());
}

}  // namespace

double chi_square_limit(int n_free) {
  constexpr double kQuantile = 2.3263;  // 99 % of a normal distribution
  const double spread = 2.0 / (9.0 * n_free);
  return n_free * std::pow(1 - spread + kQuantile * std::sqrt(spread), 3);
}

std::optional<ViewMean> mean_of_views(std::span<const ViewDeviation> views) {
  double reach_mm = 0;
  Eigen::Index n_rows = 0;
  Eigen::Matrix2d seen = Eigen::Matrix2d::Zero();
  for (const ViewDeviation& view : views) {
    const Eigen::MatrixXd rows = seen_rows(view);
    seen += rows.transpose() * rows;
    n_rows += rows.rows();
    reach_mm = std::max(reach_mm, view.offset_mm.norm());
  }
  // Half of one view's worth: slots that are almost parallel do not cross anywhere for sure.
  constexpr double kLeastSeen = 0.5;
  const double trace = seen.trace();
  // Not by the determinant: equal eigenvalues would round to the root of a negative number.
  const double least_seen = 0.5 * (trace - std::hypot(seen(0, 0) - seen(1, 1), 2 * seen(0, 1)));
  if (views.empty() || !(least_seen >= kLeastSeen)) return std::nullopt;

  Eigen::MatrixXd design(n_rows, 3);  // t, and theta in mm at the farthest view
  Eigen::VectorXd deviation_mm(n_rows);
  Eigen::MatrixXd cov_mm2 = Eigen::MatrixXd::Zero(n_rows, n_rows);
  Eigen::MatrixXd by_camera(n_rows, 5);
  Eigen::Index i = 0;
  for (const ViewDeviation& view : views) {
    const Eigen::MatrixXd rows = seen_rows(view);
    const Eigen::Vector2d turned(-view.offset_mm.y(), view.offset_mm.x());
    const auto n = rows.rows();
    design.block(i, 0, n, 2) = rows;
    design.block(i, 2, n, 1) = rows * turned / std::max(reach_mm, 1e-9);
    deviation_mm.segment(i, n) = rows * view.deviation_mm;
    cov_mm2.block(i, i, n, n) = rows * view.cov_mm2 * rows.transpose();
    by_camera.middleRows(i, n) = rows * view.by_camera;
    i += n;
  }
  // Slots across a turn do not see it: then theta is left at zero.
  const auto [inverse, rank] = pseudo_inverse(design, 1e-6);
  const Eigen::VectorXd solution = inverse * deviation_mm;
  const Eigen::VectorXd residual_mm = deviation_mm - design * solution;
  const Eigen::MatrixXd cov_of_solution = propagated(inverse, cov_mm2);

  ViewMean mean;
  mean.deviation_mm = solution.head<2>();
  mean.cov_mm2 = cov_of_solution.topLeftCorner<2, 2>();
  mean.by_camera = inverse.topRows<2>() * by_camera;
  mean.rotation_rad = solution(2) / std::max(reach_mm, 1e-9);
  double chi_square = 0;
  i = 0;
  for (const ViewDeviation& view : views) {
    const auto n = view.blind ? 1 : 2;
    const Eigen::VectorXd r_mm = residual_mm.segment(i, n);
    const Eigen::MatrixXd c_mm2 = cov_mm2.block(i, i, n, n);
    chi_square += r_mm.dot(solve_symmetric(c_mm2, r_mm));
    const double length_mm = r_mm.norm();
    mean.residual_mm.push_back(length_mm);
    mean.sigma_mm.push_back(length_mm > 0 ? std::sqrt(r_mm.dot(c_mm2 * r_mm)) / length_mm
                                          : std::sqrt(c_mm2.trace() / n));
    i += n;
  }
  const int n_free = static_cast<int>(n_rows - rank);
  if (n_free > 0 && chi_square > chi_square_limit(n_free)) mean.cov_mm2 *= chi_square / n_free;
  return mean;
}

Displacement<frame::Actual> scatter_of(std::span<const PositionEstimate<frame::Actual>> places) {
  const Eigen::Vector2d middle_mm = mean_mm(places);
  Eigen::Vector2d sum_mm2 = Eigen::Vector2d::Zero();
  for (const auto& place : places) {
    sum_mm2 += (place.position.in_mm() - middle_mm).cwiseAbs2();
  }
  const Eigen::Vector2d sigma_mm = (sum_mm2 / (static_cast<double>(places.size()) - 1)).cwiseSqrt();
  return displacement_mm<frame::Actual>(sigma_mm);
}

Eigen::Matrix2d excess_scatter(std::span<const PositionEstimate<frame::Actual>> places,
                               int n_coordinates) {
  const Eigen::Vector2d middle_mm = mean_mm(places);
  const auto n = static_cast<double>(places.size());
  Eigen::Matrix2d cov_mm2 = Eigen::Matrix2d::Zero();
  for (const auto& place : places) cov_mm2 += place.cov / n;
  double chi_square = 0;
  for (const auto& place : places) {
    const Eigen::Vector2d apart_mm = place.position.in_mm() - middle_mm;
    chi_square += apart_mm.dot(solve_plane_symmetric(cov_mm2, apart_mm));
  }
  const int n_free = n_coordinates * (static_cast<int>(places.size()) - 1);
  if (!(chi_square > chi_square_limit(n_free))) return Eigen::Matrix2d::Zero();
  return (chi_square / n_free - 1) / n * cov_mm2;
}

}  // namespace panelcal::internal
