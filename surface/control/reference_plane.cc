// SPDX-License-Identifier: Apache-2.0
#include "surface/control/reference_plane.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace panelcal {
namespace {

/// Machine coordinates step by 0.1 um at best: probes nearer than this are one and the same.
constexpr double kCoincident_mm = 1e-6;
/// Least ratio of the probes' spreads across and along, below which they lie on one line.
constexpr double kCollinear = 1e-6;

bool is_collinear(std::span<const ProbedHeight> probes, const Eigen::Vector2d& center_mm) {
  double xx = 0, xy = 0, yy = 0;
  for (const ProbedHeight& probe : probes) {
    const Eigen::Vector2d d = probe.position.in_mm() - center_mm;
    xx += d.x() * d.x();
    xy += d.x() * d.y();
    yy += d.y() * d.y();
  }
  const double largest = 0.5 * (xx + yy) + std::hypot(0.5 * (xx - yy), xy);
  const double n = static_cast<double>(probes.size());
  if (!(largest > n * kCoincident_mm * kCoincident_mm)) return true;
  const double smallest = std::max(0.0, xx * yy - xy * xy) / largest;
  return !(smallest > kCollinear * kCollinear * largest);
}

double weight_per_mm2(const ProbedHeight& probe) {
  const double sigma_mm = probe.measured.sigma.in_mm();
  return 1 / (sigma_mm * sigma_mm);
}

bool is_good_probe(const ProbedHeight& probe) {
  const double weight = weight_per_mm2(probe);
  return probe.measured.sigma > Length() && std::isfinite(weight) && weight > 0 &&
         std::isfinite(probe.measured.height.in_mm()) && probe.position.in_mm().allFinite();
}

Eigen::Vector2d mean_mm(std::span<const ProbedHeight> probes) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const ProbedHeight& probe : probes) sum += probe.position.in_mm();
  return sum / static_cast<double>(probes.size());
}

}  // namespace

ReferencePlane::ReferencePlane(std::span<const ProbedHeight> probes) {
  double weight_sum = 0;
  for (const ProbedHeight& probe : probes) weight_sum += weight_per_mm2(probe);
  for (const ProbedHeight& probe : probes) {
    const double share = weight_per_mm2(probe) / weight_sum;
    center_mm_ += share * probe.position.in_mm();
    height_mm_ += share * probe.measured.height.in_mm();
  }
  height_variance_mm2_ = 1 / weight_sum;

  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const ProbedHeight& probe : probes) {
    const Eigen::Vector2d d_mm = probe.position.in_mm() - center_mm_;
    const double z_mm = probe.measured.height.in_mm() - height_mm_;
    normal += weight_per_mm2(probe) * d_mm * d_mm.transpose();
    right += weight_per_mm2(probe) * z_mm * d_mm;
  }
  const double determinant = normal(0, 0) * normal(1, 1) - normal(0, 1) * normal(1, 0);
  slope_cov_ << normal(1, 1), -normal(0, 1), -normal(1, 0), normal(0, 0);
  slope_cov_ /= determinant;
  slope_ = slope_cov_ * right;

  for (const ProbedHeight& probe : probes) {
    const Length residual = probe.measured.height - height_at(probe.position).height;
    residuals_.push_back(residual);
    chi_square_ += weight_per_mm2(probe) * residual.in_mm() * residual.in_mm();
  }
}

HeightEstimate ReferencePlane::height_at(const Position<frame::Machine>& p) const {
  const Eigen::Vector2d d_mm = p.in_mm() - center_mm_;
  const double variance_mm2 = height_variance_mm2_ + d_mm.dot(slope_cov_ * d_mm);
  return {mm(height_mm_ + slope_.dot(d_mm)), mm(std::sqrt(variance_mm2))};
}

ReferencePlaneResult fit_reference_plane(std::span<const ProbedHeight> probes) {
  if (probes.size() < 3) return {std::nullopt, PlaneFailure::TooFewProbes};
  if (!std::all_of(probes.begin(), probes.end(), is_good_probe)) {
    return {std::nullopt, PlaneFailure::BadSigma};
  }
  if (is_collinear(probes, mean_mm(probes))) return {std::nullopt, PlaneFailure::Collinear};
  ReferencePlane plane(probes);
  const HeightEstimate check = plane.height_at(position_mm<frame::Machine>(mean_mm(probes)));
  // Weights so different that all but two probes count for nothing.
  const Eigen::Matrix2d& cov = plane.slope_covariance();
  const bool good = std::isfinite(check.height.in_mm()) && std::isfinite(check.sigma.in_mm()) &&
                    plane.slope().allFinite() && cov.allFinite() && cov(0, 0) > 0 && cov(1, 1) > 0;
  if (!good) return {std::nullopt, PlaneFailure::Collinear};
  return {std::move(plane), PlaneFailure::TooFewProbes};
}

}  // namespace panelcal
