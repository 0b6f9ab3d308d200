// SPDX-License-Identifier: Apache-2.0
// The only unit that knows Ceres. The program loads it when a camera is fitted (see tools/modules).
#include <algorithm>
#include <optional>
#include <vector>

#include "calib/camera/circle_bias.h"
#include "calib/camera/fit/dot_projection.h"
#include "calib/camera/fit/problem.h"
#include <ceres/ceres.h>

namespace panelcal::internal {
namespace {

using CameraVector = Eigen::Matrix<double, kCameraParameters, 1>;

/// The bias of circle centres depends on the camera so weakly that a second round already agrees
/// with the first to a millionth of it.
constexpr int kCameraRounds = 4;
constexpr double kSameBias_px = 1e-6;

CameraVector coefficients(const CameraModel::Parameters& p) {
  CameraVector c;
  c << p.scale_mm_per_px, p.rotation_rad, p.tilt.x(), p.tilt.y(), p.k1_per_px2, p.k2_per_px4,
      p.p1_per_px, p.p2_per_px;
  return c;
}

CameraModel::Parameters with(CameraModel::Parameters p, const CameraVector& c) {
  p.scale_mm_per_px = c[0];
  p.rotation_rad = c[1];
  p.tilt = c.segment<2>(2);
  p.k1_per_px2 = c[4];
  p.k2_per_px4 = c[5];
  p.p1_per_px = c[6];
  p.p2_per_px = c[7];
  return p;
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
          const CameraVector& unit,
          const PlateView& view,
          const CameraObservation& seen,
          const Eigen::Vector2d& bias_px)
      : fixed_(fixed),
        unit_(unit),
        axis_at_mm_(view.axis_at.in_mm()),
        seen_px_(seen.seen.position.in_px() - bias_px),
        whitening_(whitening_of(seen.seen.cov)) {}

  bool Evaluate(const double* const* in, double* out, double** jacobians) const override {
    const CameraVector inner = Eigen::Map<const CameraVector>(in[0]);
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
  CameraVector unit_;
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

}  // namespace

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

    CameraVector inner = coefficients(state.camera).cwiseQuotient(unit_);
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

}  // namespace panelcal::internal
