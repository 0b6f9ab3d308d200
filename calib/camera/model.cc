// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/model.h"

#include <array>
#include <cmath>

#include <Eigen/LU>

namespace panelcal {
namespace {

constexpr std::array<std::string_view, kCameraParameters> kNames = {
    "scale", "rotation", "tilt x", "tilt y", "k1", "k2", "p1", "p2"};
constexpr std::array<std::string_view, kCameraParameters> kUnits = {
    "mm/px", "rad", "1", "1", "1/px^2", "1/px^4", "1/px", "1/px"};

/// Newton's method doubles its digits per step; a lens or tilt that needs more bends beyond use.
constexpr int kMaxModelIterations = 50;
constexpr double kConverged_px = 1e-10;
/// A step across the picture at once may jump over a fold into another branch of the lens.
constexpr double kLongestStep_px = 500;

}  // namespace

std::string_view name(CameraParameter parameter) {
  return kNames[static_cast<std::size_t>(parameter)];
}

std::string_view unit(CameraParameter parameter) {
  return kUnits[static_cast<std::size_t>(parameter)];
}

/// A pixel on its way to the panel.
struct CameraModel::Ray {
  Eigen::Vector2d d_px;
  Eigen::Vector2d w_px;
  double root;   ///< sqrt(1 + |q|^2)
  double along;  ///< q . w
  double depth;  ///< of the panel there, in units of that on the axis: the inverse of this
  Eigen::Vector2d p_mm;
};

CameraModel::CameraModel(const Parameters& parameters) : parameters_(parameters) {
  const double c = std::cos(parameters.rotation_rad);
  const double s = std::sin(parameters.rotation_rad);
  turn_ << c, s, s, -c;
}

CameraModel::CameraModel(const CameraMapping::Parameters& simple)
    : CameraModel(Parameters{.scale_mm_per_px = simple.scale_mm_per_px,
                             .rotation_rad = simple.rotation_rad,
                             .k1_per_px2 = simple.k1_per_px2,
                             .axis_px = simple.axis_px}) {
}

bool CameraModel::is_valid(const Parameters& p) {
  const bool is_finite = std::isfinite(p.rotation_rad) && p.tilt.allFinite() &&
                         std::isfinite(p.k1_per_px2) && std::isfinite(p.k2_per_px4) &&
                         std::isfinite(p.p1_per_px) && std::isfinite(p.p2_per_px) &&
                         p.axis_px.allFinite() && std::isfinite(p.scale_mm_per_px);
  return is_finite && p.scale_mm_per_px > 0 && p.focal_px > 0;
}

std::optional<CameraMapping::Parameters> CameraModel::as_mapping() const {
  const Parameters& p = parameters_;
  if (!p.tilt.isZero(0) || p.k2_per_px4 != 0 || p.p1_per_px != 0 || p.p2_per_px != 0) {
    return std::nullopt;
  }
  return CameraMapping::Parameters{.scale_mm_per_px = p.scale_mm_per_px,
                                   .rotation_rad = p.rotation_rad,
                                   .axis_px = p.axis_px,
                                   .k1_per_px2 = p.k1_per_px2};
}

CameraModel::Ray CameraModel::ray(const Eigen::Vector2d& u_px) const {
  const Parameters& m = parameters_;
  Ray ray;
  ray.d_px = u_px - m.axis_px;
  const double x = ray.d_px.x();
  const double y = ray.d_px.y();
  const double rr = ray.d_px.squaredNorm();
  const Eigen::Vector2d tangential(2 * m.p1_per_px * x * y + m.p2_per_px * (rr + 2 * x * x),
                                   m.p1_per_px * (rr + 2 * y * y) + 2 * m.p2_per_px * x * y);
  const double bend = 1 + rr * (m.k1_per_px2 + rr * m.k2_per_px4);
  ray.w_px = turn_ * (ray.d_px * bend + tangential);
  ray.root = std::sqrt(1 + m.tilt.squaredNorm());
  ray.along = m.tilt.dot(ray.w_px);
  ray.depth = 1 - ray.along / m.focal_px;
  ray.p_mm = m.scale_mm_per_px * (ray.w_px + m.tilt * (ray.along / (1 + ray.root))) / ray.depth;
  return ray;
}

/// dd'/dd.
Eigen::Matrix2d CameraModel::straightening(const Eigen::Vector2d& d_px) const {
  const Parameters& m = parameters_;
  const double x = d_px.x();
  const double y = d_px.y();
  const double rr = d_px.squaredNorm();
  const double bend = 1 + rr * (m.k1_per_px2 + rr * m.k2_per_px4);
  const double slope = 2 * m.k1_per_px2 + 4 * rr * m.k2_per_px4;
  Eigen::Matrix2d tangential;
  tangential << 2 * m.p1_per_px * y + 6 * m.p2_per_px * x,
      2 * m.p1_per_px * x + 2 * m.p2_per_px * y, 2 * m.p1_per_px * x + 2 * m.p2_per_px * y,
      6 * m.p1_per_px * y + 2 * m.p2_per_px * x;
  return bend * Eigen::Matrix2d::Identity() + slope * d_px * d_px.transpose() + tangential;
}

Position<frame::Optical> CameraModel::operator()(const Position<frame::Image>& u) const {
  return position_mm<frame::Optical>(ray(u.in_px()).p_mm);
}

namespace {

/// dK/dw.
Eigen::Matrix2d by_ray(const CameraModel::Parameters& m,
                       double root,
                       double depth,
                       const Eigen::Vector2d& p_mm) {
  const Eigen::Matrix2d stretched =
      Eigen::Matrix2d::Identity() + m.tilt * m.tilt.transpose() / (1 + root);
  return (m.scale_mm_per_px * stretched + p_mm * m.tilt.transpose() / m.focal_px) / depth;
}

}  // namespace

Eigen::Matrix2d CameraModel::jacobian(const Position<frame::Image>& u) const {
  const Ray at = ray(u.in_px());
  return by_ray(parameters_, at.root, at.depth, at.p_mm) * turn_ * straightening(at.d_px);
}

PositionEstimate<frame::Optical> CameraModel::operator()(
    const PositionEstimate<frame::Image>& u) const {
  return {(*this)(u.position), propagate(jacobian(u.position), u.cov)};
}

CameraModelJacobian CameraModel::by_parameters(const Position<frame::Image>& u) const {
  const Parameters& m = parameters_;
  const Ray at = ray(u.in_px());
  const double x = at.d_px.x();
  const double y = at.d_px.y();
  const double rr = at.d_px.squaredNorm();
  const Eigen::Matrix2d by_w = by_ray(m, at.root, at.depth, at.p_mm);
  const Eigen::Matrix2d by_straight = by_w * turn_;
  const Eigen::Matrix2d across =
      at.along * Eigen::Matrix2d::Identity() + m.tilt * at.w_px.transpose() -
      m.tilt * (at.along / (at.root * (1 + at.root))) * m.tilt.transpose();

  CameraModelJacobian j;
  j.col(0) = at.p_mm / m.scale_mm_per_px;
  j.col(1) = by_w * Eigen::Vector2d(-at.w_px.y(), at.w_px.x());
  j.middleCols<2>(2) =
      (m.scale_mm_per_px / (1 + at.root) * across + at.p_mm * at.w_px.transpose() / m.focal_px) /
      at.depth;
  j.col(4) = by_straight * at.d_px * rr;
  j.col(5) = by_straight * at.d_px * (rr * rr);
  j.col(6) = by_straight * Eigen::Vector2d(2 * x * y, rr + 2 * y * y);
  j.col(7) = by_straight * Eigen::Vector2d(rr + 2 * x * x, 2 * x * y);
  return j;
}

bool CameraModel::sees(const Position<frame::Image>& u) const {
  if (!u.in_px().allFinite()) return false;
  const Ray at = ray(u.in_px());
  // The picture's y points down, so the lens alone must not mirror.
  return at.depth > 0 && straightening(at.d_px).determinant() > 0 && at.p_mm.allFinite();
}

std::optional<Position<frame::Image>> CameraModel::image_of(
    const Position<frame::Optical>& p) const {
  return image_near(p, position_px<frame::Image>(parameters_.axis_px));
}

std::optional<Position<frame::Image>> CameraModel::image_near(
    const Position<frame::Optical>& p, const Position<frame::Image>& start) const {
  if (!p.in_mm().allFinite() || !sees(start)) return std::nullopt;
  Position<frame::Image> u = start;
  for (int i = 0; i < kMaxModelIterations; ++i) {
    const Eigen::Vector2d missing_mm = p.in_mm() - (*this)(u).in_mm();
    Eigen::Vector2d step_px = jacobian(u).inverse() * missing_mm;
    const double length_px = step_px.norm();
    if (length_px > kLongestStep_px) step_px *= kLongestStep_px / length_px;
    u = u + displacement_px<frame::Image>(step_px);
    if (!sees(u)) return std::nullopt;
    if (length_px < kConverged_px * (1 + u.in_px().norm())) return u;
  }
  return std::nullopt;
}

CameraCovariance simple_covariance(const CameraModelCovariance& cov) {
  constexpr std::array kFrom = {0, 1, 4};
  constexpr std::array kTo = {0, 1, 4};
  CameraCovariance simple = CameraCovariance::Zero();
  for (std::size_t i = 0; i < kFrom.size(); ++i) {
    for (std::size_t j = 0; j < kFrom.size(); ++j) {
      simple(kTo[i], kTo[j]) = cov(kFrom[i], kFrom[j]);
    }
  }
  return simple;
}

}  // namespace panelcal
