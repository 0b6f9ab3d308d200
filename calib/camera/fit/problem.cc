// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/fit/problem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/camera/circle_bias.h"
#include "calib/camera/fit/dot_projection.h"
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Eigenvalues of a normal matrix with ones on its diagonal: below this lies only a gauge.
constexpr double kCameraGauge = 1e-9;

/// Of a symmetric matrix whose null space is a gauge; adds its rank to `rank`. `before` are its
/// diagonal elements before anything was eliminated: next to them rounding is seen to be nothing.
MatrixXd pseudo_inverse(const MatrixXd& normal, const Eigen::VectorXd& before, int& rank) {
  Eigen::VectorXd unit = before;
  for (double& value : unit) value = value > 0 ? 1 / std::sqrt(value) : 0;
  const internal::Eigensystem modes =
      internal::eigensystem(unit.asDiagonal() * normal * unit.asDiagonal());
  Eigen::VectorXd inverse = modes.values;
  for (double& value : inverse) {
    rank += value > kCameraGauge;
    value = value > kCameraGauge ? 1 / value : 0;
  }
  const MatrixXd scaled = unit.asDiagonal() * modes.vectors;
  return propagated_diagonal(scaled, inverse);
}

}  // namespace

std::optional<DotProjection> project_dot(const CameraModel& camera,
                                         const PlatePose& pose,
                                         const Eigen::Vector2d& dot_mm,
                                         const Eigen::Vector2d& axis_at_mm,
                                         const Position<frame::Image>& near) {
  const double c = std::cos(pose.angle_rad);
  const double s = std::sin(pose.angle_rad);
  Eigen::Matrix2d turn;
  turn << c, -s, s, c;
  const Eigen::Vector2d turned_mm = turn * dot_mm;
  const Eigen::Vector2d place_mm = turned_mm + pose.shift_mm - axis_at_mm;
  const auto place = position_mm<frame::Optical>(place_mm);
  auto at = camera.image_near(place, near);
  if (!at) at = camera.image_of(place);
  if (!at) return std::nullopt;
  DotProjection out;
  out.at = *at;
  const Eigen::Matrix2d by_place = camera.jacobian(*at).inverse();
  out.by_camera = -by_place * camera.by_parameters(*at);
  out.by_pose << by_place * Eigen::Vector2d(-turned_mm.y(), turned_mm.x()), by_place;
  out.by_dot = by_place * turn;
  return out;
}

Eigen::Matrix2d whitening_of(const Eigen::Matrix2d& cov) {
  return plane_root(cov).inverse();
}

CameraProblem::CameraProblem(const CameraData& data,
                             std::vector<std::size_t> used,
                             double huber_sigmas,
                             const CameraModel::Parameters& start)
    : data_(data), used_(std::move(used)), huber_sigmas_(huber_sigmas) {
  double radius_px = 1;
  for (const CameraObservation& seen : data.seen) {
    radius_px = std::max(radius_px, (seen.seen.position.in_px() - start.axis_px).norm());
  }
  const double squared = radius_px * radius_px;
  unit_ << start.scale_mm_per_px, 1, 1, 1, 1 / squared, 1 / (squared * squared), 1 / radius_px,
      1 / radius_px;
  bias_px_.assign(used_.size(), Eigen::Vector2d::Zero());
}

CameraInformation CameraProblem::information(const CameraState& state) const {
  const CameraModel camera(state.camera);
  const auto n = static_cast<Index>(kCameraParameters + 3 * state.poses.size());
  MatrixXd normal = MatrixXd::Zero(n, n);
  std::vector<Eigen::Matrix2d> of_dot(state.dots_mm.size(), Eigen::Matrix2d::Zero());
  std::vector<MatrixXd> with_dot(state.dots_mm.size());
  for (const std::size_t i : used_) {
    const CameraObservation& seen = data_.seen[i];
    const PlateView& view = data_.views[seen.i_view];
    const auto at = project_dot(camera,
                                state.poses[view.i_pose],
                                state.dots_mm[seen.i_dot],
                                view.axis_at.in_mm(),
                                seen.seen.position);
    if (!at) continue;
    Eigen::Matrix2d white = whitening_of(seen.seen.cov);
    const double sigmas = (white * residual_px(state, seen)).norm();
    // Of a residual in the linear part of the loss the derivative counts by that much less.
    if (huber_sigmas_ > 0 && sigmas > huber_sigmas_) white *= std::sqrt(huber_sigmas_ / sigmas);
    MatrixXd row = MatrixXd::Zero(2, n);
    row.leftCols<kCameraParameters>() = white * at->by_camera * unit_.asDiagonal();
    row.middleCols<3>(static_cast<Index>(kCameraParameters + 3 * view.i_pose)) =
        white * at->by_pose;
    normal += row.transpose() * row;
    if (data_.dots[seen.i_dot].is_certified) continue;
    const Eigen::Matrix2d by_dot = white * at->by_dot;
    of_dot[seen.i_dot] += by_dot.transpose() * by_dot;
    MatrixXd& cross = with_dot[seen.i_dot];
    if (cross.size() == 0) cross = MatrixXd::Zero(n, 2);
    cross += row.transpose() * by_dot;
  }
  CameraInformation out;
  const auto in_units = [&](const MatrixXd& inner) {
    return CameraModelCovariance(unit_.cwiseInverse().asDiagonal() * inner *
                                 unit_.cwiseInverse().asDiagonal());
  };
  const Index n_poses = n - kCameraParameters;
  const Eigen::VectorXd before = normal.diagonal().tail(n_poses);
  out.before = in_units(normal.topLeftCorner<kCameraParameters, kCameraParameters>());
  for (std::size_t j = 0; j < of_dot.size(); ++j) {
    if (with_dot[j].size() == 0) continue;
    normal -= with_dot[j] * of_dot[j].inverse() * with_dot[j].transpose();
    out.n_determined += 2;
  }
  const MatrixXd poses =
      pseudo_inverse(normal.bottomRightCorner(n_poses, n_poses), before, out.n_determined);
  const MatrixXd cross = normal.topRightCorner(kCameraParameters, n_poses);
  out.normal = in_units(normal.topLeftCorner<kCameraParameters, kCameraParameters>() -
                        cross * poses * cross.transpose());
  return out;
}

Eigen::Vector2d CameraProblem::residual_px(const CameraState& state,
                                           const CameraObservation& seen) const {
  const CameraModel camera(state.camera);
  const PlateView& view = data_.views[seen.i_view];
  const auto at = project_dot(camera,
                              state.poses[view.i_pose],
                              state.dots_mm[seen.i_dot],
                              view.axis_at.in_mm(),
                              seen.seen.position);
  if (!at) return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  const Eigen::Vector2d bias_px =
      circle_bias(camera, at->at, data_.dots[seen.i_dot].radius).in_px();
  return seen.seen.position.in_px() - bias_px - at->at.in_px();
}

double CameraProblem::chi_square(const CameraState& state) const {
  double sum = 0;
  for (const std::size_t i : used_) {
    const CameraObservation& seen = data_.seen[i];
    const double sigmas = (whitening_of(seen.seen.cov) * residual_px(state, seen)).norm();
    const bool is_linear = huber_sigmas_ > 0 && sigmas > huber_sigmas_;
    sum += is_linear ? huber_sigmas_ * (2 * sigmas - huber_sigmas_) : sigmas * sigmas;
  }
  return sum;
}

}  // namespace panelcal::internal
