// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/panel/fit.h"
#include <Eigen/Core>

namespace panelcal {

/// Limits a fit must keep before anything is drilled with it; an absent one is not checked.
struct GateLimits {
  std::optional<Length> residual;     ///< largest distance of a target from its fitted place; of a
                                      ///< slot, in the coordinate it shows
  std::optional<Angle> rotation;      ///< of the panel, either way
  std::optional<double> stretch_ppm;  ///< largest |scale - 1|, and |shear|, in 1e-6
  std::optional<Length> offset;       ///< of the targets' centroid
  /// Rate at which healthy series may be refused for their fit, by the chi-square test; absent:
  /// there is no such test. A series that another limit refuses is examined for the cause in any
  /// case.
  std::optional<double> false_alarm;
  int max_dropped = 0;  ///< targets of one series that may be left out as found at fault
  /// A map that exchanges left and right is refused; where it is not, rotation and stretch are
  /// those of the panel that was turned over.
  bool refuses_mirror = true;
  /// The panel lies turned by 0, 90, 180 or 270 degrees, counter-clockwise about work zero, and is
  /// meant to: rotation and offset count from there.
  int turned_deg = 0;
};

/// Limits of a machine that states none: 100 um, 3 degrees, 2,000 ppm, a false alarm in 1,000 jobs,
/// no mirror. A healthy panel keeps them by far; a target that was taken for another breaks one.
GateLimits default_gate_limits();

/// Those of default_gate_limits() that are off here: residual, rotation, stretch, false alarm,
/// mirror.
std::vector<std::string_view> gates_off(const GateLimits& limits);

/// "residual 100 um, rotation 52.3599 mrad, stretch 2000 ppm, false alarm 0.001; off: mirror"
std::string gates_text(const GateLimits& limits);

/// A place that lies turned by 0, 90, 180 or 270 degrees about (0, 0). A coordinate that is no
/// number, as of a slot, stays alone.
Eigen::Vector2d turned_by(const Eigen::Vector2d& place_mm, int turned_deg);

/// The limits of one of a job's series. A rate of false alarms is that of a healthy job: its series
/// share it evenly, so that all of them together are accused no more often (Bonferroni).
///
/// See    tests/calib/faults/finder_slow_test.cc
GateLimits share_false_alarm(GateLimits limits, std::size_t n_series);

/// One limit against one number.
struct GateVerdict {
  std::string_view gate;  ///< residual, rotation, stretch, offset
  double value = 0;       ///< in `unit`
  double limit = 0;
  std::string_view unit;  ///< um, mrad, ppm, mm
  bool accepted = true;
  std::optional<std::size_t> i_target;  ///< the worst target, for residuals

  /// "residual of target 2 is 61.3 um, limit 25.0 um"; people count targets from 1.
  std::string text() const;
};

/// True if no verdict refuses; also if there are none.
bool all_accepted(std::span<const GateVerdict> verdicts);

namespace internal {
std::vector<GateVerdict> check_gates_raw(const Eigen::Matrix2d& linear,
                                         const Eigen::Vector2d& mean_deviation_mm,
                                         std::span<const double> residual_lengths_mm,
                                         const GateLimits& limits);
}  // namespace internal

/// Holds every number of the fit against its limit. All verdicts are returned, also those passed.
/// A number that is not finite is refused.
///
/// Rotation and offset count from where the panel is meant to lie (GateLimits::turned_deg).
///
/// In the offset a slot's other coordinate counts as fitted. A mean over only those that show x
/// would belong to another place than that over those that show y, and rotation would pass for
/// offset.
template <class To, class From>
std::vector<GateVerdict> check_gates(const PanelFit<To, From>& fit, const GateLimits& limits) {
  Eigen::Vector2d deviation = Eigen::Vector2d::Zero();
  std::vector<double> residual_lengths_mm;
  for (std::size_t i = 0; i < fit.pairs.size(); ++i) {
    const TargetPair<To, From>& pair = fit.pairs[i];
    const Eigen::Vector2d fitted_mm = fit.map.map(pair.nominal).in_mm();
    Eigen::Vector2d place_mm = pair.measured.position.in_mm();
    if (!observes_x(pair.axes)) place_mm.x() = fitted_mm.x();
    if (!observes_y(pair.axes)) place_mm.y() = fitted_mm.y();
    deviation += place_mm - turned_by(pair.nominal.in_mm(), limits.turned_deg);
    residual_lengths_mm.push_back(fit.residuals[i].in_mm().norm());
  }
  if (!fit.pairs.empty()) deviation /= static_cast<double>(fit.pairs.size());
  return internal::check_gates_raw(fit.map.map.linear(), deviation, residual_lengths_mm, limits);
}

}  // namespace panelcal
