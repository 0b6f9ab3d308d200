// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "calib/base/estimate.h"
#include "calib/base/frames.h"
#include "calib/base/machine_uncertainty.h"
#include <Eigen/Core>

namespace panelcal {

/// The coordinates that a measurement determines: both of a hole, one of a slot (SIEB & MEYER G32
/// and G33 in measurement mode 5).
enum class ObservedAxes : std::uint8_t { Both, X, Y };

constexpr bool observes_x(ObservedAxes axes) {
  return axes != ObservedAxes::Y;
}

constexpr bool observes_y(ObservedAxes axes) {
  return axes != ObservedAxes::X;
}

/// A target: where the program says, where it was seen, and how well that is known.
template <class To, class From>
struct TargetPair {
  Position<From> nominal;
  PositionEstimate<To> measured;  ///< of which only `axes` count
  ObservedAxes axes = ObservedAxes::Both;
  /// Not seen by the fit: what `measured` shares with other targets, see CorrectionStack.
  CameraJacobian by_camera = CameraJacobian::Zero();
  int i_camera = 0;    ///< index of the camera's calibration, as MachineUncertainty counts
  int n_arrivals = 1;  ///< of the stage, of which `measured` is the mean
};

}  // namespace panelcal

namespace panelcal::internal {

struct RawPair {
  Eigen::Vector2d from_mm;
  Eigen::Vector2d to_mm;
  Eigen::Matrix2d cov_mm2;
  ObservedAxes axes = ObservedAxes::Both;
};

template <class To, class From>
std::vector<RawPair> raw_pairs(std::span<const TargetPair<To, From>> pairs) {
  std::vector<RawPair> raw;
  raw.reserve(pairs.size());
  for (const auto& pair : pairs) {
    raw.push_back(
        {pair.nominal.in_mm(), pair.measured.position.in_mm(), pair.measured.cov, pair.axes});
  }
  return raw;
}

}  // namespace panelcal::internal
