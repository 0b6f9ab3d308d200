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

}  // namespace

CorrectionStack::CorrectionStack() = default;

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

void CorrectionStack::compose() {
  base_map_ = base_ ? base_->map.map : Transform<frame::Base, frame::Nominal>();
  const Transform<frame::Actual, frame::Base> nested_map =
      nested_ ? nested_->map.map : Transform<frame::Actual, frame::Base>();
  whole_.map = nested_map * base_map_;
  whole_.cov.setZero();
  if (base_) {
    Matrix6d whole_by_base = by_inner(nested_map.linear());
    if (nested_) whole_by_base += by_outer(base_map_) * answer_to_base(*nested_, *base_);
    whole_.cov += whole_by_base * base_->map.cov * whole_by_base.transpose();
  }
  if (nested_) {
    const Matrix6d whole_by_nested = by_outer(base_map_);
    whole_.cov += whole_by_nested * nested_->map.cov * whole_by_nested.transpose();
  }
}

}  // namespace panelcal
