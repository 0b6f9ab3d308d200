// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "calib/panel/target_pair.h"
#include <Eigen/Core>

namespace panelcal::internal {

struct ExaminedTarget {
  Eigen::Vector2d from_mm;
  Eigen::Vector2d to_mm;
  Eigen::Matrix2d cov_mm2;
  ObservedAxes axes = ObservedAxes::Both;
  std::optional<double> score;
  std::string name;
  std::optional<Eigen::Matrix2d> picture_cov_mm2 = std::nullopt;
};

}  // namespace panelcal::internal
