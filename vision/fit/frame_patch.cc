// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/frame_patch.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace panelcal::internal {
namespace {

/// Powers 0 to 3 of the four places in -1 .. 1 where the frame is asked.
Eigen::Matrix4d vandermonde() {
  Eigen::Matrix4d powers;
  for (int i = 0; i < 4; ++i) {
    const double t = -1 + 2.0 * i / 3;
    powers.row(i) << 1, t, t * t, t * t * t;
  }
  return powers;
}

}  // namespace

FramePatch::FramePatch(const FitFrame& frame, const Eigen::Vector2d& center_px, double half_px)
    : center_px_(center_px), is_plain_(!frame.mapping()), unit_px_(half_px) {
  for (auto& column : c_) {
    for (Eigen::Vector2d& c : column) c.setZero();
  }
  if (!frame.mapping()) {
    c_[0][0] = frame.from_image(center_px);
    c_[1][0] = {half_px, 0};
    c_[0][1] = {0, half_px};
    center_jacobian_.setIdentity();
    return;
  }
  const Eigen::Matrix4d coefficients_from_values = vandermonde().inverse();
  for (int axis = 0; axis < 2; ++axis) {
    Eigen::Matrix4d values;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const Eigen::Vector2d offset(-1 + 2.0 * i / 3, -1 + 2.0 * j / 3);
        values(i, j) = frame.from_image(center_px + half_px * offset)[axis];
      }
    }
    const Eigen::Matrix4d c =
        coefficients_from_values * values * coefficients_from_values.transpose();
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) c_[i][j][axis] = c(i, j);
    }
  }
  center_jacobian_ << c_[1][0] / half_px, c_[0][1] / half_px;
}

FramePatch::Row FramePatch::row(int y) const {
  Row row;
  row.x0_ = center_px_.x();
  row.per_px_ = 1 / unit_px_;
  const double d = (y - center_px_.y()) / unit_px_;
  for (int i = 0; i < 4; ++i) {
    row.c_[i] = c_[i][0] + d * (c_[i][1] + d * (c_[i][2] + d * c_[i][3]));
    row.e_[i] = c_[i][1] + d * (2 * c_[i][2] + 3 * d * c_[i][3]);
  }
  return row;
}

double FramePatch::bend(double distance_px) const {
  constexpr int kDirections = 8;
  double bend = 0;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * std::numbers::pi * k / kDirections;
    const Eigen::Vector2d offset = distance_px * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d d = offset / unit_px_;
    Eigen::Vector2d exact = Eigen::Vector2d::Zero();
    for (int i = 3; i >= 0; --i) {
      exact = exact * d.x() + c_[i][0] + d.y() * (c_[i][1] + d.y() * (c_[i][2] + d.y() * c_[i][3]));
    }
    bend = std::max(bend, (exact - c_[0][0] - center_jacobian_ * offset).norm());
  }
  return bend;
}

}  // namespace panelcal::internal
