// SPDX-License-Identifier: Apache-2.0
#include "panelcal/calib/correction_stack.h"

#include <utility>

namespace panelcal {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// d(mapped point) / d(coefficients), as in TransformEstimate.
Eigen::Matrix<double, 2, 6> point_jacobian(const Eigen::Vector2d& p_mm) {
  Eigen::Matrix<double, 2, 6> j;
  j << p_mm.x(), p_mm.y(), 0, 0, 1, 0, 0, 0, p_mm.x(), p_mm.y(), 0, 1;
  return j;
}

/// d(coefficients of outer * inner) / d(coefficients of inner): each column and the translation
/// of the inner map is multiplied by the outer linear part.
Matrix6d by_inner(const Eigen::Matrix2d& outer) {
  Matrix6d j = Matrix6d::Zero();
  for (int to = 0; to < 2; ++to) {
    for (int from = 0; from < 2; ++from) {
      j(2 * to, 2 * from) = outer(to, from);
      j(2 * to + 1, 2 * from + 1) = outer(to, from);
      j(4 + to, 4 + from) = outer(to, from);
    }
  }
  return j;
}

/// d(coefficients of outer * inner) / d(coefficients of outer).
template <class To, class From>
Matrix6d by_outer(const Transform<To, From>& inner) {
  Matrix6d j = Matrix6d::Zero();
  for (int row = 0; row < 2; ++row) {
    j.block<2, 2>(2 * row, 2 * row) = inner.linear().transpose();
    j.block<1, 2>(4 + row, 2 * row) = inner.translation().transpose();
    j(4 + row, 4 + row) = 1;
  }
  return j;
}

/// D of the header: how the nested coefficients answer to errors of the base ones.
Matrix6d answer_to_base(const NestedFit& nested, const BaseFit& base) {
  const Transform<frame::Nominal, frame::Base> nominal_from_base = base.map.map.inverse();
  Matrix6d answer = Matrix6d::Zero();
  for (std::size_t i = 0; i < nested.pairs.size(); ++i) {
    const Eigen::Vector2d nominal_mm = nominal_from_base(nested.pairs[i].nominal).in_mm();
    answer -= nested.gain.middleCols<2>(2 * static_cast<Eigen::Index>(i)) *
              nested.map.map.linear() * point_jacobian(nominal_mm);
  }
  return answer;
}

/// P1 + P2 D of the header.
Matrix6d whole_by_base(const BaseFit& base, const NestedFit* nested) {
  if (nested == nullptr) return Matrix6d::Identity();
  return by_inner(nested->map.map.linear()) +
         by_outer(base.map.map) * answer_to_base(*nested, base);
}

template <class To, class From>
void append_influences(const PanelFit<To, From>& fit,
                       const Matrix6d& whole_by_fit,
                       std::vector<CorrectionStack::TargetInfluence>& out) {
  for (std::size_t i = 0; i < fit.pairs.size(); ++i) {
    const TargetPair<To, From>& pair = fit.pairs[i];
    CorrectionStack::TargetInfluence target;
    target.by_measured =
        whole_by_fit * fit.gain.template middleCols<2>(2 * static_cast<Eigen::Index>(i));
    target.cov_mm2 = pair.measured.cov;
    target.by_camera = pair.by_camera;
    target.i_camera = pair.i_camera;
    target.n_arrivals = pair.n_arrivals;
    // What a slot does not show may hold anything, and must not come through a gain of zero.
    for (const int axis : {0, 1}) {
      if (axis == 0 ? observes_x(pair.axes) : observes_y(pair.axes)) continue;
      target.cov_mm2.row(axis).setZero();
      target.cov_mm2.col(axis).setZero();
      target.by_camera.row(axis).setZero();
    }
    out.push_back(target);
  }
}

/// T cov(camera) T^T of the header, of all cameras.
Matrix6d camera_covariance(const std::vector<CorrectionStack::TargetInfluence>& influences,
                           const MachineUncertainty& machine) {
  Matrix6d cov = Matrix6d::Zero();
  for (int i_camera = 0; i_camera < machine.n_cameras(); ++i_camera) {
    const Eigen::Matrix<double, 6, 5> by_camera = coefficients_by_camera(influences, i_camera);
    cov += by_camera * machine.camera_of(i_camera) * by_camera.transpose();
  }
  return cov;
}

}  // namespace

CorrectionStack::CorrectionStack() = default;

CorrectionStack::CorrectionStack(MachineUncertainty machine) : machine_(std::move(machine)) {
}

Eigen::Matrix<double, 6, 5> coefficients_by_camera(
    std::span<const CorrectionStack::TargetInfluence> influences, int i_camera) {
  Eigen::Matrix<double, 6, 5> sum = Eigen::Matrix<double, 6, 5>::Zero();
  for (const CorrectionStack::TargetInfluence& target : influences) {
    if (target.i_camera == i_camera) sum += target.by_measured * target.by_camera;
  }
  return sum;
}

void CorrectionStack::set_base(std::shared_ptr<const BaseFit> fit) {
  base_ = std::move(fit);
  nested_.reset();
  compose();
}

void CorrectionStack::set_nested(std::shared_ptr<const NestedFit> fit) {
  nested_ = std::move(fit);
  compose();
}

void CorrectionStack::clear_base() {
  set_base(nullptr);
}

void CorrectionStack::clear_nested() {
  set_nested(nullptr);
}

std::vector<CorrectionStack::TargetInfluence> CorrectionStack::influences() const {
  std::vector<TargetInfluence> out;
  if (base_) append_influences(*base_, whole_by_base(*base_, nested_.get()), out);
  if (nested_) append_influences(*nested_, by_outer(base_map_), out);
  return out;
}

Eigen::Matrix<double, 6, 6> CorrectionStack::choice_cov() const {
  Matrix6d cov = Matrix6d::Zero();
  if (base_) {
    const Matrix6d by_base = whole_by_base(*base_, nested_.get());
    cov += by_base * base_->choice_cov * by_base.transpose();
  }
  if (nested_) {
    const Matrix6d by_nested = by_outer(base_map_);
    cov += by_nested * nested_->choice_cov * by_nested.transpose();
  }
  return cov;
}

void CorrectionStack::compose() {
  base_map_ = base_ ? base_->map.map : Transform<frame::Base, frame::Nominal>();
  const Transform<frame::Actual, frame::Base> nested_map =
      nested_ ? nested_->map.map : Transform<frame::Actual, frame::Base>();
  whole_.map = nested_map * base_map_;
  whole_.cov.setZero();
  drilled_ = whole_;
  if (!base_ && !nested_) return;
  if (base_) {
    const Matrix6d by_base = whole_by_base(*base_, nested_.get());
    whole_.cov += by_base * base_->map.cov * by_base.transpose();
  }
  if (nested_) {
    const Matrix6d by_nested = by_outer(base_map_);
    whole_.cov += by_nested * nested_->map.cov * by_nested.transpose();
  }
  whole_.cov += camera_covariance(influences(), machine_);
  drilled_.cov = whole_.cov;
  drilled_.cov.bottomRightCorner<2, 2>() += machine_.shared_mm2() + machine_.of_hole_mm2();
}

}  // namespace panelcal
