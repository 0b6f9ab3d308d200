// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/drift/model.h"
#include "calib/drift/series.h"
#include <Eigen/Core>

namespace panelcal {

enum class ChangeKind : std::uint8_t {
  None,
  Step,   ///< from one night to the next
  Slope,  ///< steadily from a night on
};

/// A change in a series, and its date.
struct ChangeFound {
  ChangeKind kind = ChangeKind::None;
  double probability = 1;        ///< of this kind, of the three
  std::size_t i_night = 0;       ///< the likeliest first night after the change, in series.points
  double night_probability = 0;  ///< of that very night, given the kind
  std::size_t i_first = 0;       ///< the change is between these nights
  std::size_t i_last = 0;        ///< with a probability of 90 %
  Eigen::VectorXd size;          ///< the step, or the slope a day; in the series' unit
  Eigen::VectorXd size_sigma;
  std::vector<std::size_t> axes;  ///< axes that changed: those of more than three sigma
};

/// Prior probability of a change: one kind in a series with this probability, equally on every
/// night; a step as large as 3 to 300 nightly sigma, a slope that many a month.
inline constexpr double kChangeBefore = 0.1;

/// Compares "no change" with a step or a slope that begins on any night, axis by axis against the
/// model's usual drift.
///
///   value_t = level_t + ... + size shape_t;   shape_t = [t >= k], or (days since k)+
///
/// For each k the Kalman filter runs over the shape as well as over the value, which gives the
/// likeliest size and its variance (augmented filter; de Jong 1991), and the size is integrated out
/// over a normal prior of a grid of widths. Nights left out are skipped, and points before the last
/// fresh start are not looked at.
///
/// Fails  as DriftModel; calibration-invalid: fewer nights than options.min_nights
/// Cost   O(nights^2)
/// See    tests/calib/drift/change_point_test.cc
Expected<ChangeFound> find_change(const DriftSeries& series, const DriftOptions& options);

/// "x moved by +23.1 um (sigma 0.9 um) between the nights of 2026-11-03 and 2026-11-04".
std::string words_of(const ChangeFound& change, const DriftSeries& series);

}  // namespace panelcal
