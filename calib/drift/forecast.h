// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "calib/drift/model.h"
#include <Eigen/Core>

namespace panelcal {

/// The limits of the calibration in force.
struct ForecastLimits {
  /// Of its error's length, or of more than two axes of the largest; in the series' unit (here mm).
  double tolerance = 0.010;
  double probability = 0.001;            ///< with which the error may be larger
  Time horizon = seconds(30 * 86400.0);  ///< beyond which nothing is said
  /// The time for which the one in force may be used after the last night that measured it, if no
  /// later night does: a forecast of old nights does not know what has blinded the camera.
  Time trusted = seconds(7 * 86400.0);
  std::optional<double> temperature_c;  ///< expected; a noted one makes the forecast surer

  /// Fails  calibration-invalid: the message names field, value and bound
  Expected<void> validate() const;
};

/// May I drill now, and until when?
enum class DrillAnswer : std::uint8_t {
  NotEnoughHistory,  ///< too few nights to tell
  No,
  Until,
  BeyondHorizon,  ///< yes, and for longer than is predicted
};

struct DrillForecast {
  DrillAnswer answer = DrillAnswer::NotEnoughHistory;
  double chance_now = 1;  ///< that the error is larger than the tolerance
  Eigen::VectorXd error;  ///< true value minus the one in force, as predicted for now
  Eigen::MatrixXd cov;    ///< of that
  std::chrono::sys_seconds now{};
  std::chrono::sys_seconds until{};  ///< for Until: to the minute, rounded down
  /// Of the last night that measured; only where limit_to_trust was asked.
  std::optional<std::chrono::sys_seconds> last_measured;
  bool is_limited_by_trust =
      false;  ///< the answer and `until` are those of ForecastLimits::trusted
};

/// The chance that the length of (value predicted - center) exceeds a radius; of more than two axes
/// the chance that any of them does so by itself, or rather more (the sum of their chances:
/// Bonferroni). Of the mixtures five parts each are kept, so that an uncertain sigma counts in the
/// tail.
double chance_beyond(const DriftPrediction& prediction,
                     const Eigen::VectorXd& center,
                     double radius);

/// The time until which the value in force is right within the tolerance, with the probability that
/// the limits ask for.
///
/// In     in_force: in the model's axes; now: not before the last night learned
/// Fails  calibration-invalid: limits, number of axes, time; in_force not finite
/// See    tests/calib/drift/forecast_test.cc, forecast_slow_test.cc (how often it keeps its word)
Expected<DrillForecast> may_drill(const DriftModel& model,
                                  const Eigen::VectorXd& in_force,
                                  std::chrono::sys_seconds now,
                                  const ForecastLimits& limits);

/// Of a night that measured nothing it can keep: cuts the forecast off where the last one that did
/// is no longer trusted. A model without nights has no forecast to cut off.
void limit_to_trust(const DriftModel& model, const ForecastLimits& limits, DrillForecast& forecast);

/// "yes, until 2026-11-24T03:10:00Z: ..." or why not; `unit` is the series'.
std::string words_of(const DrillForecast& forecast,
                     const ForecastLimits& limits,
                     const std::string& unit);

}  // namespace panelcal
