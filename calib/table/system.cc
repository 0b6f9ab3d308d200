// SPDX-License-Identifier: Apache-2.0
#include "calib/table/system.h"

#include <cmath>
#include <complex>

#include "calib/base/statistics/linear_algebra.h"
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Eigenvalues of a normal matrix with ones on its diagonal: below this lies only a gauge.
constexpr double kTableGauge = 1e-9;

Eigen::Matrix2d rotation(double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  Eigen::Matrix2d r;
  r << c, -s, s, c;
  return r;
}

Eigen::Vector2d error_of(const TableBasis& basis,
                         const VectorXd& table_mm,
                         const Eigen::Vector2d& commanded_mm) {
  const LocalWeights local = local_of(basis.grid, commanded_mm);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < 16; ++k) {
    sum += local.weight[k] * table_mm.segment<2>(2 * local.index[k]);
  }
  return sum;
}

}  // namespace

TableState table_start(const TableData& data, const TableBasis& basis) {
  TableState state;
  state.table_mm = VectorXd::Zero(basis.size());
  state.dots_mm.assign(data.dots.size(), Eigen::Vector2d::Zero());
  struct Sums {
    double n = 0;
    std::complex<double> plate, machine, products;
  };
  std::vector<Sums> sums;
  for (const TableObservation& seen : data.seen) {
    const PlateView& view = data.views[seen.i_view];
    if (view.i_pose >= sums.size()) sums.resize(view.i_pose + 1);
    const Eigen::Vector2d at = view.axis_at.in_mm() + seen.seen.position.in_mm();
    const Eigen::Vector2d& dot = data.dots[seen.i_dot].place.in_mm();
    const std::complex<double> from(dot.x(), dot.y());
    const std::complex<double> to(at.x(), at.y());
    Sums& s = sums[view.i_pose];
    s.n += 1;
    s.plate += from;
    s.machine += to;
    s.products += std::conj(from) * to;
  }
  for (const Sums& s : sums) {
    PlatePose pose;
    if (s.n > 0) {
      const std::complex<double> moment = s.products - std::conj(s.plate) * s.machine / s.n;
      pose.angle_rad = std::abs(moment) > 0 ? std::arg(moment) : 0;
      const std::complex<double> shift =
          (s.machine - std::polar(1.0, pose.angle_rad) * s.plate) / s.n;
      pose.shift_mm = {shift.real(), shift.imag()};
    }
    state.poses.push_back(pose);
  }
  return state;
}

Eigen::Vector2d table_residual_mm(const TableData& data,
                                  const TableBasis& basis,
                                  const TableState& state,
                                  const TableObservation& seen) {
  const PlateView& view = data.views[seen.i_view];
  const PlatePose& pose = state.poses[view.i_pose];
  const Eigen::Vector2d dot_mm = data.dots[seen.i_dot].place.in_mm() + state.dots_mm[seen.i_dot];
  const Eigen::Vector2d& commanded_mm = view.axis_at.in_mm();
  return commanded_mm + error_of(basis, state.table_mm, commanded_mm) + seen.seen.position.in_mm() -
         rotation(pose.angle_rad) * dot_mm - pose.shift_mm;
}

TableSystem::TableSystem(const TableData& data,
                         std::span<const std::size_t> used,
                         const TableBasis& basis,
                         const TableState& about)
    : about_(about), n_table_(basis.size()) {
  const Index n = n_table_ + 3 * static_cast<Index>(about.poses.size());
  normal_ = MatrixXd::Zero(n, n);
  right_side_ = VectorXd::Zero(n);
  dots_.resize(data.dots.size());
  for (const std::size_t i : used) add(data, data.seen[i], basis);
  // Only the lower half was filled where the table is concerned with itself.
  normal_.triangularView<Eigen::StrictlyUpper>() = normal_.transpose();
  before_ = normal_.diagonal().tail(n - n_table_);
  eliminate_dots();
  eliminate_poses();
}

/// One look: with r its residual for a table of zeros and the state's poses and dots,
/// r + E - (pose's derivative) - R error = noise.
void TableSystem::add(const TableData& data,
                      const TableObservation& seen,
                      const TableBasis& basis) {
  const PlateView& view = data.views[seen.i_view];
  const PlateDot& dot = data.dots[seen.i_dot];
  const Eigen::Matrix2d weight = seen.seen.cov.inverse();
  const Eigen::Matrix2d turn = rotation(about_.poses[view.i_pose].angle_rad);
  const Eigen::Vector2d turned_mm = turn * dot.place.in_mm();
  const Eigen::Vector2d r_mm = view.axis_at.in_mm() + seen.seen.position.in_mm() - turned_mm -
                               about_.poses[view.i_pose].shift_mm;
  Eigen::Matrix<double, 2, 3> by_pose;
  by_pose << turned_mm.y(), -1, 0, -turned_mm.x(), 0, -1;
  sum_of_squares_ += r_mm.dot(weight * r_mm);

  const LocalWeights local = local_of(basis.grid, view.axis_at.in_mm());
  const Index at_pose = n_table_ + 3 * static_cast<Index>(view.i_pose);
  for (std::size_t a = 0; a < 16; ++a) {
    const Index i = 2 * local.index[a];
    right_side_.segment<2>(i) -= local.weight[a] * weight * r_mm;
    for (std::size_t b = 0; b < 16; ++b) {
      const Index j = 2 * local.index[b];
      if (j > i) continue;
      normal_.block<2, 2>(i, j) += local.weight[a] * local.weight[b] * weight;
    }
    normal_.block<3, 2>(at_pose, i) += local.weight[a] * by_pose.transpose() * weight;
  }
  normal_.block<3, 3>(at_pose, at_pose) += by_pose.transpose() * weight * by_pose;
  right_side_.segment<3>(at_pose) -= by_pose.transpose() * weight * r_mm;

  if (dot.is_certified) return;
  Dot& free = dots_[seen.i_dot];
  if (free.cross.size() == 0) free.cross = MatrixXd::Zero(normal_.rows(), 2);
  free.normal += turn.transpose() * weight * turn;
  free.right_side += turn.transpose() * weight * r_mm;
  for (std::size_t a = 0; a < 16; ++a) {
    free.cross.middleRows<2>(2 * local.index[a]) -= local.weight[a] * weight * turn;
  }
  free.cross.middleRows<3>(at_pose) -= by_pose.transpose() * weight * turn;
}

void TableSystem::eliminate_dots() {
  for (const Dot& dot : dots_) {
    if (dot.cross.size() == 0) continue;
    const Eigen::Matrix2d inverse = dot.normal.inverse();
    const MatrixXd gain = dot.cross * inverse;
    right_side_ -= gain * dot.right_side;
    sum_of_squares_ -= dot.right_side.dot(inverse * dot.right_side);
    n_eliminated_ += 2;
    // A dot is seen from a few places, and each touches 32 coefficients of hundreds.
    std::vector<Index> touched;
    for (Index i = 0; i < gain.rows(); ++i) {
      if (!dot.cross.row(i).isZero(0)) touched.push_back(i);
    }
    for (const Index i : touched) {
      for (const Index j : touched) normal_(i, j) -= gain.row(i).dot(dot.cross.row(j));
    }
  }
}

void TableSystem::eliminate_poses() {
  const Index n = normal_.rows() - n_table_;
  VectorXd unit = before_;
  for (double& value : unit) value = value > 0 ? 1 / std::sqrt(value) : 0;
  const MatrixXd scaled = unit.asDiagonal() * normal_.bottomRightCorner(n, n) * unit.asDiagonal();
  const Eigensystem modes = eigensystem(scaled);
  VectorXd inverse = modes.values;
  for (double& value : inverse) {
    n_eliminated_ += value > kTableGauge;
    value = value > kTableGauge ? 1 / value : 0;
  }
  const MatrixXd vectors = unit.asDiagonal() * modes.vectors;
  const MatrixXd back = vectors * inverse.asDiagonal() * vectors.transpose();
  const MatrixXd cross = normal_.bottomLeftCorner(n, n_table_);
  const VectorXd poses = right_side_.tail(n);
  pose_gain_ = back * cross;
  pose_offset_ = back * poses;
  sum_of_squares_ -= poses.dot(pose_offset_);
  normal_ = MatrixXd(normal_.topLeftCorner(n_table_, n_table_) - cross.transpose() * pose_gain_);
  right_side_ = VectorXd(right_side_.head(n_table_) - cross.transpose() * pose_offset_);
}

TableState TableSystem::complete(const VectorXd& table_mm) const {
  TableState state = about_;
  state.table_mm = table_mm;
  VectorXd both(n_table_ + pose_offset_.size());
  both << table_mm, pose_offset_ - pose_gain_ * table_mm;
  for (std::size_t k = 0; k < state.poses.size(); ++k) {
    const Eigen::Vector3d step = both.segment<3>(n_table_ + 3 * static_cast<Index>(k));
    state.poses[k].angle_rad += step[0];
    state.poses[k].shift_mm += step.tail<2>();
  }
  for (std::size_t j = 0; j < dots_.size(); ++j) {
    const Dot& dot = dots_[j];
    if (dot.cross.size() == 0) continue;
    state.dots_mm[j] = dot.normal.inverse() * (dot.right_side - dot.cross.transpose() * both);
  }
  return state;
}

}  // namespace panelcal::internal
