// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/panel_fit.h"

#include <algorithm>
#include <cmath>

#include "calib/base/number_text.h"
#include <fmt/format.h>

namespace panelcal {
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

/// "a smooth model would predict left-out targets to 8.10 um instead of 17.30 um"
std::string smooth_gain(const ModelScore& smooth, const ModelScore& best) {
  return fmt::format("a smooth model would predict left-out targets to {} um instead of {} um",
                     internal::fixed(*smooth.left_out_mm * 1e3, 2),
                     internal::fixed(*best.left_out_mm * 1e3, 2));
}

/// Lines; empty where the model is not left to the targets.
std::string choice_text(const PanelFitSummary& summary) {
  const ModelScore* best = chosen(summary.compared);
  if (!summary.chose_model || best == nullptr) return {};
  const ModelScore* other = nullptr;
  for (const ModelScore& score : summary.compared) {
    if (!score.is_eligible || score.is_chosen) continue;
    if (other == nullptr || score.criterion < other->criterion) other = &score;
  }
  std::string out = fmt::format("  model \"{}\"", name(*best));
  if (other == nullptr) {
    out += ", the only one that the targets can check";
  } else {
    const double difference = other->criterion - best->criterion;
    out += fmt::format(", criterion {:.2f}; \"{}\" has {:.2f}, {}",
                       best->criterion,
                       name(*other),
                       other->criterion,
                       difference > 0 ? "which is worse" : "too little better to be softer for");
  }
  if (best->left_out_mm) {
    out += fmt::format("; left-out rms {:.2f} um", *best->left_out_mm * 1e3);
  }
  out += "\n";
  if (const ModelScore* smooth = recommended_smooth(summary.compared)) {
    out += "  " + smooth_gain(*smooth, *best) + "\n";
  }
  return out;
}

}  // namespace

bool internal::is_wrong_way_round(const Eigen::Matrix2d& linear, const GateLimits& limits) {
  const double determinant = linear(0, 0) * linear(1, 1) - linear(0, 1) * linear(1, 0);
  return limits.refuses_mirror ? determinant <= 0 : determinant == 0;
}

void internal::put_deformation(PanelFitSummary& summary) {
  const PanelDeformation d = deformation_of(summary.linear);
  const Eigen::Matrix<double, 4, 6> j = deformation_jacobian(d);
  const Eigen::Matrix4d cov = j * summary.cov * j.transpose();
  summary.is_mirrored = d.scale_y < 0;
  summary.rotation_rad = {d.rotation_rad, sigma_of_variance(cov(0, 0))};
  summary.stretch_x_ppm = {(d.scale_x - 1) * 1e6, sigma_of_variance(cov(1, 1)) * 1e6};
  summary.stretch_y_ppm = {(std::abs(d.scale_y) - 1) * 1e6, sigma_of_variance(cov(2, 2)) * 1e6};
  summary.shear_ppm = {d.shear * 1e6, sigma_of_variance(cov(3, 3)) * 1e6};
}

void internal::put_shift(const Eigen::Vector2d& moved_mm,
                         const Eigen::Matrix2d& cov_mm2,
                         PanelFitSummary& summary) {
  const Eigen::Vector2d shift_mm = moved_mm - summary.centroid_mm;
  summary.shift_x_mm = {shift_mm.x(), sigma_of_variance(cov_mm2(0, 0))};
  summary.shift_y_mm = {shift_mm.y(), sigma_of_variance(cov_mm2(1, 1))};
}

double PanelFitSummary::worst_residual_um() const {
  double worst_mm = 0;
  for (const Eigen::Vector2d& one : residuals_mm) worst_mm = std::max(worst_mm, one.norm());
  return worst_mm * 1e3;
}

std::string PanelFitSummary::model_text() const {
  if (!smooth_parameters) return std::string(name(model));
  return fmt::format("smooth, {:.1f} effective parameters", *smooth_parameters);
}

std::string PanelFitSummary::brief() const {
  // Of a panel that was turned over the scale in y is negative.
  const PanelDeformation panel = deformation_of(linear);
  return fmt::format(
      "turned {:+.4f} mrad, stretched {:+.1f} ppm in x and {:+.1f} ppm in y, worst residual {:.3f} "
      "um",
      panel.rotation_rad * 1e3,
      (panel.scale_x - 1) * 1e6,
      (panel.scale_y - 1) * 1e6,
      worst_residual_um());
}

std::string PanelFitSummary::full(std::string_view subject) const {
  std::string out = fmt::format("{}: {}\n", subject, brief());
  if (is_smooth()) out += fmt::format("{}: {}\n", subject, model_text());
  return out + choice_text(*this);
}

}  // namespace panelcal
