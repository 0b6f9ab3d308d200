// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/problem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "calib/base/linear_algebra.h"
#include "calib/camera/circle_bias.h"
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <ceres/ceres.h>

namespace panelcal::internal {
namespace {

using Camera = Eigen::Matrix<double, kCameraParameters, 1>;
using Eigen::Index;
using Eigen::MatrixXd;

/// The bias of circle centres depends on the camera so weakly that a second round already agrees
/// with the first to a millionth of it.
constexpr int kCameraRounds = 4;
constexpr double kSameBias_px = 1e-6;
/// Eigenvalues of a normal matrix with ones on its diagonal: below this lies only a gauge.
constexpr double kCameraGauge = 1e-9;

Camera coefficients(const CameraModel::Parameters& p) {
  Camera c;
  c << p.scale_mm_per_px, p.rotation_rad, p.tilt.x(), p.tilt.y(), p.k1_per_px2, p.k2_per_px4,
      p.p1_per_px, p.p2_per_px;
  return c;
}

CameraModel::Parameters with(CameraModel::Parameters p, const Camera& c) {
  p.scale_mm_per_px = c[0];
  p.rotation_rad = c[1];
  p.tilt = c.segment<2>(2);
  p.k1_per_px2 = c[4];
  p.k2_per_px4 = c[5];
  p.p1_per_px = c[6];
  p.p2_per_px = c[7];
  return p;
}

/// One dot in one view: where it is seen, with derivatives.
struct Projection {
  Position<frame::Image> at;
  Eigen::Matrix<double, 2, kCameraParameters> by_camera;
  Eigen::Matrix<double, 2, 3> by_pose;
  Eigen::Matrix2d by_dot;
};

std::optional<Projection> project_dot(const CameraModel& camera,
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
  Projection out;
  out.at = *at;
  const Eigen::Matrix2d by_place = camera.jacobian(*at).inverse();
  out.by_camera = -by_place * camera.by_parameters(*at);
  out.by_pose << by_place * Eigen::Vector2d(-turned_mm.y(), turned_mm.x()), by_place;
  out.by_dot = by_place * turn;
  return out;
}

Eigen::Matrix2d whitening_of(const Eigen::Matrix2d& cov) {
  const Eigen::Matrix2d lower = cov.llt().matrixL();
  return lower.inverse();
}

template <int kColumns>
void put(const Eigen::Matrix<double, 2, kColumns>& jacobian, double* out) {
  using ByRows = Eigen::Matrix<double, 2, kColumns, Eigen::RowMajor>;
  if (out != nullptr) Eigen::Map<ByRows>{out} = jacobian;
}

/// Parameters: camera in the units given, pose (rad, mm, mm), dot (mm). Residuals: sigmas.
class SeenDot final : public ceres::SizedCostFunction<2, kCameraParameters, 3, 2> {
 public:
  SeenDot(const CameraModel::Parameters& fixed,
          const Camera& unit,
          const PlateView& view,
          const CameraObservation& seen,
          const Eigen::Vector2d& bias_px)
      : fixed_(fixed),
        unit_(unit),
        axis_at_mm_(view.axis_at.in_mm()),
        seen_px_(seen.seen.position.in_px() - bias_px),
        whitening_(whitening_of(seen.seen.cov)) {}

  bool Evaluate(const double* const* in, double* out, double** jacobians) const override {
    const Camera inner = Eigen::Map<const Camera>(in[0]);
    const CameraModel::Parameters parameters = with(fixed_, inner.cwiseProduct(unit_));
    if (!CameraModel::is_valid(parameters)) return false;
    const PlatePose pose{in[1][0], {in[1][1], in[1][2]}};
    const auto at = project_dot(CameraModel(parameters),
                                pose,
                                Eigen::Map<const Eigen::Vector2d>(in[2]),
                                axis_at_mm_,
                                position_px<frame::Image>(seen_px_));
    if (!at) return false;
    Eigen::Map<Eigen::Vector2d> residual(out);
    residual = whitening_ * (seen_px_ - at->at.in_px());
    if (jacobians == nullptr) return true;
    put<kCameraParameters>(-whitening_ * at->by_camera * unit_.asDiagonal(), jacobians[0]);
    put<3>(-whitening_ * at->by_pose, jacobians[1]);
    put<2>(-whitening_ * at->by_dot, jacobians[2]);
    return true;
  }

 private:
  CameraModel::Parameters fixed_;
  Camera unit_;
  Eigen::Vector2d axis_at_mm_;
  Eigen::Vector2d seen_px_;
  Eigen::Matrix2d whitening_;
};

ceres::Solver::Options solver_options() {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 100;
  // Nothing but the damping keeps the gauge of poses and dots, and without a limit it fades away.
  options.max_trust_region_radius = 1e10;
  // The defaults stop short of what a covariance is compared with.
  options.function_tolerance = 1e-14;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-12;
  return options;
}

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
  return scaled * inverse.asDiagonal() * scaled.transpose();
}

}  // namespace

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

bool CameraProblem::solve(std::span<const CameraParameter> free, CameraState& state) {
  std::vector<int> held;
  for (int i = 0; i < kCameraParameters; ++i) {
    const bool is_free = std::ranges::find(free, static_cast<CameraParameter>(i)) != free.end();
    if (!is_free) held.push_back(i);
  }
  for (int round = 0; round < kCameraRounds; ++round) {
    const CameraModel now(state.camera);
    double moved_px = 0;
    for (std::size_t i = 0; i < used_.size(); ++i) {
      const CameraObservation& seen = data_.seen[used_[i]];
      const Eigen::Vector2d bias_px =
          circle_bias(now, seen.seen.position, data_.dots[seen.i_dot].radius).in_px();
      if (!bias_px.allFinite()) return false;
      moved_px = std::max(moved_px, (bias_px - bias_px_[i]).norm());
      bias_px_[i] = bias_px;
    }
    if (round > 0 && moved_px < kSameBias_px) return true;

    Camera inner = coefficients(state.camera).cwiseQuotient(unit_);
    std::vector<Eigen::Vector3d> poses;
    for (const PlatePose& pose : state.poses) {
      poses.emplace_back(pose.angle_rad, pose.shift_mm.x(), pose.shift_mm.y());
    }
    ceres::Problem problem;
    for (std::size_t i = 0; i < used_.size(); ++i) {
      const CameraObservation& seen = data_.seen[used_[i]];
      const PlateView& view = data_.views[seen.i_view];
      double* dot = state.dots_mm[seen.i_dot].data();
      problem.AddResidualBlock(new SeenDot(state.camera, unit_, view, seen, bias_px_[i]),
                               huber_sigmas_ > 0 ? new ceres::HuberLoss(huber_sigmas_) : nullptr,
                               inner.data(),
                               poses[view.i_pose].data(),
                               dot);
      if (data_.dots[seen.i_dot].is_certified) problem.SetParameterBlockConstant(dot);
    }
    if (held.size() == kCameraParameters) {
      problem.SetParameterBlockConstant(inner.data());
    } else if (!held.empty()) {
      problem.SetManifold(inner.data(), new ceres::SubsetManifold(kCameraParameters, held));
    }
    ceres::Solver::Summary summary;
    ceres::Solve(solver_options(), &problem, &summary);
    if (!summary.IsSolutionUsable()) return false;
    state.camera = with(state.camera, inner.cwiseProduct(unit_));
    for (std::size_t k = 0; k < poses.size(); ++k) {
      state.poses[k] = {poses[k][0], poses[k].tail<2>()};
    }
    if (!CameraModel::is_valid(state.camera)) return false;
  }
  return true;
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
