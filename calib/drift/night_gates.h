// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "calib/drift/forecast.h"
#include "calib/drift/model.h"
#include "calib/drift/series.h"
#include <Eigen/Core>

namespace panelcal {

/// One limit against tonight.
struct NightGate {
  std::string name;  ///< numbers, uncertainty, holes, outliers, structure, temperature, change
  bool passed = true;
  std::string text;  ///< with the number and its limit
};

/// The result of tonight's calibration, with the figures of its fit.
struct NightResult {
  DriftPoint point;
  std::string used = "holes";  ///< data of the fit: holes, views, pictures
  int n_used = 0;              ///< their number
  int n_outliers = 0;          ///< that it left out
  /// The chance that healthy residuals show as much structure (a trend over the coupon), by the
  /// fit's F test; absent where there were too few for one.
  std::optional<double> structure_chance;
  /// Limits that only the calibration itself can hold its result against.
  std::vector<NightGate> further;
};

/// The limits of a night; lengths in the series' unit, here mm.
struct NightLimits {
  double sigma = 0.003;  ///< largest standard deviation of the result, in any direction
  int min_used = 5;
  int max_outliers = 1;
  double structure_chance = 0.001;   ///< refused below
  double nights_per_refusal = 2000;  ///< healthy nights to one refused for its change; 20 to 1e5
  double change = 0.050;             ///< largest change against what is in force, at any sigma
  std::optional<double> min_temperature_c;
  std::optional<double> max_temperature_c;
  ForecastLimits old;                  ///< limits of the one in force, if it is to stay
  Time until_next = seconds(86400.0);  ///< for how long

  /// Fails  calibration-invalid: the message names field, value and bound
  Expected<void> validate() const;
};

enum class NightVerdict : std::uint8_t {
  Install,  ///< tonight's result
  KeepOld,  ///< tonight's is refused; the one in force may be used until the next night
  Hold,     ///< neither may be used: do not drill
};

struct NightDecision {
  NightVerdict verdict = NightVerdict::Hold;
  std::vector<NightGate> gates;      ///< all that were checked
  std::vector<std::string> reasons;  ///< the refused ones, and why the old one may stay or not
  std::optional<DrillForecast> old;  ///< of the one in force, where that was asked

  /// "install", "keep the old one: ..." or "hold: ..."
  std::string summary() const;
};

std::string_view name(NightVerdict verdict);

/// Decides what a night's result is used for. Pure: the same arguments give the same decision.
///
/// Installed is what passes every gate. The change is held against the forecast from the nights
/// before, in its standard deviations; with fewer nights than history.min_nights, and for a fresh
/// start, only against what is in force. A refused result leaves the old calibration in force if
/// the forecast allows it until the next night, and if tonight does not speak against it: a change
/// that fails its gate is either a moved machine or a bad measurement, and the data do not
/// show which. A person looks, and marks the next night as a fresh start.
///
/// In     history: nights before tonight, the refused ones left out (DriftPoint::is_left_out);
///        in_force: what holes are drilled with now, if anything is
/// Fails  calibration-invalid: limits, options or history. A bad result is no failure, it is
/// refused. See    tests/calib/drift/night_gates_test.cc
Expected<NightDecision> decide_night(const NightResult& result,
                                     const std::optional<Eigen::VectorXd>& in_force,
                                     const DriftSeries& history,
                                     const DriftOptions& options,
                                     const NightLimits& limits);

}  // namespace panelcal
