// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace panelcal {

/// The result of one night's calibration.
struct DriftPoint {
  std::chrono::sys_seconds time{};
  Eigen::VectorXd value;                ///< one number an axis, in the series' unit
  Eigen::MatrixXd cov;                  ///< of value, as the calibration states it
  std::optional<double> temperature_c;  ///< of the machine
  /// Something was changed knowingly since the night before (a camera mounted anew, a person who
  /// accepted what had moved): where the value was says nothing about where it is.
  bool is_fresh_start = false;
  bool is_left_out = false;  ///< refused that night: not learned from, not judged
};

/// A calibrated quantity over the nights, in order of time.
struct DriftSeries {
  std::vector<std::string> names;  ///< of the axes: {"x", "y"}
  std::string unit;                ///< of the values: "mm" is shown in um
  std::vector<DriftPoint> points;
};

}  // namespace panelcal
