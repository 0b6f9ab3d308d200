// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/stack.h"

#include <utility>

#include "calib/panel/system.h"

namespace panelcal {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

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
              nested.map.map.linear() * internal::design(nominal_mm);
  }
  return answer;
}

/// P1 + P2 D of the header.
Matrix6d whole_by_base(const BaseFit& base, const NestedFit* nested) {
  if (nested == nullptr) return Matrix6d::Identity();
  return by_inner(nested->map.map.linear()) +
         by_outer(base.map.map) * answer_to_base(*nested, base);
}

/// A coordinate that a slot does not show may hold anything, and must not come through a gain of
/// zero.
template <class Target>
void keep_what_shows(ObservedAxes axes, Target& target) {
  for (const int axis : {0, 1}) {
    if (axis == 0 ? observes_x(axes) : observes_y(axes)) continue;
    target.cov_mm2.row(axis).setZero();
    target.cov_mm2.col(axis).setZero();
    target.by_camera.row(axis).setZero();
  }
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
    keep_what_shows(pair.axes, target);
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

CorrectionStack::CorrectionStack(MachineUncertainty machine)
    : machine_(std::move(machine)), machines_offset_(machine_.offset()) {
}

Eigen::Matrix<double, 6, 5> coefficients_by_camera(
    std::span<const CorrectionStack::TargetInfluence> influences, int i_camera) {
  Eigen::Matrix<double, 6, 5> sum = Eigen::Matrix<double, 6, 5>::Zero();
  for (const CorrectionStack::TargetInfluence& target : influences) {
    if (target.i_camera == i_camera) sum += target.by_measured * target.by_camera;
  }
  return sum;
}

void CorrectionStack::set_base(std::shared_ptr<const BaseFit> fit,
                               const std::optional<OffsetUncertainty>& offset) {
  base_ = std::move(fit);
  base_offset_ = offset.value_or(machines_offset_);
  nested_.reset();
  compose();
}

void CorrectionStack::set_nested(std::shared_ptr<const NestedFit> fit,
                                 const std::optional<OffsetUncertainty>& offset) {
  nested_ = std::move(fit);
  nested_offset_ = offset.value_or(machines_offset_);
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

Matrix6d CorrectionStack::of_whole(const Matrix6d& base_cov, const Matrix6d& nested_cov) const {
  Matrix6d cov = Matrix6d::Zero();
  if (base_) {
    const Matrix6d by_base = whole_by_base(*base_, nested_.get());
    cov += by_base * base_cov * by_base.transpose();
  }
  if (nested_) {
    const Matrix6d by_nested = by_outer(base_map_);
    cov += by_nested * nested_cov * by_nested.transpose();
  }
  return cov;
}

Matrix6d CorrectionStack::choice_cov() const {
  const Matrix6d none = Matrix6d::Zero();
  return of_whole(base_ ? base_->choice_cov : none, nested_ ? nested_->choice_cov : none);
}

Matrix6d CorrectionStack::misfit_cov() const {
  const Matrix6d none = Matrix6d::Zero();
  return of_whole(base_ ? base_->misfit_cov : none, nested_ ? nested_->misfit_cov : none);
}

std::vector<CorrectionStack::PlaceInfluence> CorrectionStack::influences_at(
    const Position<frame::Nominal>& nominal) const {
  const internal::RawSmooth& raw = smooth_->panel->raw();
  const internal::SmoothBasis basis = raw.basis_at(nominal.in_mm());
  std::vector<PlaceInfluence> out;
  for (std::size_t i = 0; i < base_->pairs.size(); ++i) {
    const auto& pair = base_->pairs[i];
    PlaceInfluence target{.by_measured = raw.by_target(basis, i),
                          .cov_mm2 = pair.measured.cov,
                          .by_camera = pair.by_camera,
                          .i_camera = pair.i_camera,
                          .n_arrivals = pair.n_arrivals};
    keep_what_shows(pair.axes, target);
    out.push_back(target);
  }
  return out;
}

PositionEstimate<frame::Actual> CorrectionStack::drilled_smooth(
    const Position<frame::Nominal>& nominal) const {
  const internal::RawSmooth& raw = smooth_->panel->raw();
  const internal::SmoothBasis basis = raw.basis_at(nominal.in_mm());
  return {position_mm<frame::Actual>(raw.place_mm(basis)), smooth_->drilled(basis)};
}

/// Everything that is the same at all places belongs to the basis' constant; what the cameras'
/// calibrations share goes through the weights.
void CorrectionStack::compose_smooth() {
  smooth_.reset();
  if (!base_ || !base_->smooth || nested_) return;
  const internal::RawSmooth& raw = base_->smooth->raw();
  Eigen::MatrixXd of_weights =
      Eigen::MatrixXd::Zero(raw.by_measured.rows(), raw.by_measured.rows());
  for (int i_camera = 0; i_camera < machine_.n_cameras(); ++i_camera) {
    Eigen::MatrixXd by_camera = Eigen::MatrixXd::Zero(raw.by_measured.cols(), 5);
    for (std::size_t i = 0; i < base_->pairs.size(); ++i) {
      const auto& pair = base_->pairs[i];
      if (pair.i_camera != i_camera) continue;
      const auto row = 2 * static_cast<Eigen::Index>(i);
      if (observes_x(pair.axes)) by_camera.row(row) = pair.by_camera.row(0);
      if (observes_y(pair.axes)) by_camera.row(row + 1) = pair.by_camera.row(1);
    }
    const Eigen::MatrixXd through = raw.by_measured * by_camera;
    of_weights += through * machine_.camera_of(i_camera) * through.transpose();
  }
  const Eigen::Index constant = of_weights.rows() - 6;
  of_weights.block<2, 2>(constant, constant) += machine_.shared_mm2() + machine_.of_hole_mm2();
  SmoothBase smooth{base_->smooth, internal::CovarianceForm::of_weights(of_weights)};
  smooth.drilled += raw.cov;
  smooth_ = std::make_shared<const SmoothBase>(std::move(smooth));
}

void CorrectionStack::compose() {
  machine_.set_offset(nested_ ? nested_offset_ : base_ ? base_offset_ : machines_offset_);
  compose_smooth();
  base_map_ = base_ ? base_->map.map : Transform<frame::Base, frame::Nominal>();
  const Transform<frame::Actual, frame::Base> nested_map =
      nested_ ? nested_->map.map : Transform<frame::Actual, frame::Base>();
  whole_.map = nested_map * base_map_;
  whole_.cov.setZero();
  drilled_ = whole_;
  if (!base_ && !nested_) return;
  const Matrix6d none = Matrix6d::Zero();
  whole_.cov = of_whole(base_ ? base_->map.cov : none, nested_ ? nested_->map.cov : none);
  whole_.cov += camera_covariance(influences(), machine_);
  drilled_.cov = whole_.cov;
  drilled_.cov.bottomRightCorner<2, 2>() += machine_.shared_mm2() + machine_.of_hole_mm2();
}

}  // namespace panelcal
