// SPDX-License-Identifier: Apache-2.0
#include "tools/report/fits/fit_numbers.h"

#include <algorithm>
#include <cmath>

#include "tools/figures/text.h"
#include <fmt/format.h>

namespace panelcal::report {
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
FitNumbers numbers_of(const PanelFit<To, From>& fit) {
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

std::string rotation_words(const FitNumbers& n) {
  return fmt::format(
      "rotated by {} {}",
      with_sigma(std::abs(n.rotation_rad.value) * 1e3, n.rotation_rad.sigma * 1e3, "mrad", false),
      n.rotation_rad.value < 0 ? "clockwise" : "counter-clockwise");
}

std::string stretch_words(const FitNumbers& n) {
  const std::string x = with_sigma(n.stretch_x_ppm.value, n.stretch_x_ppm.sigma, "ppm");
  if (n.model == PanelModel::Similarity) return fmt::format("stretched by {} both ways", x);
  const std::string y = with_sigma(n.stretch_y_ppm.value, n.stretch_y_ppm.sigma, "ppm");
  return fmt::format("stretched by {} in x and {} in y", x, y);
}

/// In um below a millimetre, in mm above.
std::string shift_words(const FitNumbers& n) {
  const bool in_um = std::hypot(n.shift_x_mm.value, n.shift_y_mm.value) < 1;
  const double k = in_um ? 1e3 : 1;
  const std::string_view unit = in_um ? "&#181;m" : "mm";
  return fmt::format("shifted by {} in x and {} in y",
                     with_sigma(k * n.shift_x_mm.value, k * n.shift_x_mm.sigma, unit),
                     with_sigma(k * n.shift_y_mm.value, k * n.shift_y_mm.sigma, unit));
}

}  // namespace

std::optional<FitNumbers> fit_numbers(const SeriesResult& series) {
  if (series.base) return numbers_of(*series.base);
  if (series.nested) return numbers_of(*series.nested);
  return std::nullopt;
}

std::string chi_square_meaning(double chi_square, int degrees_of_freedom) {
  if (degrees_of_freedom <= 0) {
    return "no equation to spare: the fit goes through its targets, and nothing checks them";
  }
  const double p = chi_square_exceedance(chi_square, degrees_of_freedom);
  const std::string chance = p < 0.001 ? "p below 0.001" : fmt::format("p = {}", fixed(p, 3));
  const bool is_weak = degrees_of_freedom == 1;
  std::string_view words = "as expected from the measurement noise";
  if (!(p >= 0.01)) {
    words = is_weak ? "larger than the measurement noise explains; one spare equation cannot say "
                      "which target is off"
                    : "larger than the measurement noise explains";
  } else if (p < 0.05) {
    words = "rather large, but noise alone does this now and then";
  } else if (p > 0.999 && degrees_of_freedom >= 3) {
    words = "smaller than the stated noise: the sigmas are likely too large";
  } else if (is_weak) {
    words = "consistent with the measurement noise, though one spare equation is a weak check";
  }
  return fmt::format("{} ({})", words, chance);
}

std::string fit_sentence(const FitNumbers& n, CorrectionLevel level) {
  const std::string_view subject = level == CorrectionLevel::Base ? "Panel" : "Board";
  if (n.model == PanelModel::Offset) {
    return fmt::format("{} {}", subject, shift_words(n));
  }
  std::string out = fmt::format("{} {}", subject, rotation_words(n));
  if (n.model != PanelModel::Rigid) out += ", " + stretch_words(n);
  if (n.model == PanelModel::Affine) {
    out += ", sheared by " + with_sigma(n.shear_ppm.value, n.shear_ppm.sigma, "ppm");
  }
  if (n.is_mirrored) out += ", mirrored";
  return fmt::format("{}, {} at its fiducials' centre", out, shift_words(n));
}

}  // namespace panelcal::report
