// SPDX-License-Identifier: Apache-2.0
#include "machine/job/facts/fit_numbers.h"

#include <algorithm>
#include <cmath>

#include "calib/base/statistics/chi_square.h"
#include "calib/panel/fit.h"

namespace panelcal::facts {
namespace {

using Row6d = Eigen::Matrix<double, 1, 6>;

/// Rows: d [rotation rad, scale_x, scale_y, shear] / d [l00 l01 l10 l11 tx ty].
///
/// From L = R U follows R^T dL = d(rotation) [0 -1; 1 0] U + dU, one entry after the other.
Eigen::Matrix<double, 4, 6> deformation_jacobian(const PanelDeformation& d) {
  const double c = std::cos(d.rotation_rad);
  const double s = std::sin(d.rotation_rad);
  Row6d m00, m01, m10, m11;  // R^T dL
  m00 << c, 0, s, 0, 0, 0;
  m01 << 0, c, 0, s, 0, 0;
  m10 << -s, 0, c, 0, 0, 0;
  m11 << 0, -s, 0, c, 0, 0;
  Eigen::Matrix<double, 4, 6> j;
  j.row(0) = m10 / d.scale_x;
  j.row(1) = m00;
  j.row(2) = m11 - d.shear * j.row(0);
  j.row(3) = m01 + d.scale_y * j.row(0);
  return j;
}

double sigma_of_variance(double variance) {
  return std::sqrt(std::max(0.0, variance));
}

template <class To, class From>
FitNumbers fit_numbers_of(const PanelFit<To, From>& fit) {
  const PanelDeformation d = deformation_of(fit.map.map.linear());
  const Eigen::Matrix<double, 4, 6> j = deformation_jacobian(d);
  const Eigen::Matrix4d cov = j * fit.map.cov * j.transpose();
  FitNumbers out;
  out.model = fit.model;
  out.is_mirrored = d.scale_y < 0;
  out.rotation_rad = {d.rotation_rad, sigma_of_variance(cov(0, 0))};
  out.stretch_x_ppm = {(d.scale_x - 1) * 1e6, sigma_of_variance(cov(1, 1)) * 1e6};
  out.stretch_y_ppm = {(std::abs(d.scale_y) - 1) * 1e6, sigma_of_variance(cov(2, 2)) * 1e6};
  out.shear_ppm = {d.shear * 1e6, sigma_of_variance(cov(3, 3)) * 1e6};
  for (const auto& pair : fit.pairs) out.centroid_mm += pair.nominal.in_mm();
  if (!fit.pairs.empty()) out.centroid_mm /= static_cast<double>(fit.pairs.size());
  const PositionEstimate<To> moved = fit.map(position_mm<From>(out.centroid_mm));
  const Eigen::Vector2d shift_mm = moved.position.in_mm() - out.centroid_mm;
  out.shift_x_mm = {shift_mm.x(), sigma_of_variance(moved.cov(0, 0))};
  out.shift_y_mm = {shift_mm.y(), sigma_of_variance(moved.cov(1, 1))};
  out.chi_square = fit.chi_square;
  out.degrees_of_freedom = fit.degrees_of_freedom;
  return out;
}

}  // namespace

std::optional<FitNumbers> fit_numbers(const SeriesResult& series) {
  if (series.base) return fit_numbers_of(*series.base);
  if (series.nested) return fit_numbers_of(*series.nested);
  return std::nullopt;
}

std::string_view chi_square_meaning(double chi_square, int degrees_of_freedom) {
  if (degrees_of_freedom <= 0) return "unchecked";
  const double p = chi_square_exceedance(chi_square, degrees_of_freedom);
  const bool is_weak = degrees_of_freedom == 1;
  // Written so that a NaN is too large.
  if (!(p >= 0.01)) return is_weak ? "too_large_weak" : "too_large";
  if (p < 0.05) return "rather_large";
  if (p > 0.999 && degrees_of_freedom >= 3) return "too_small";
  return is_weak ? "weak" : "as_expected";
}

}  // namespace panelcal::facts
