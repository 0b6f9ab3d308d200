// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/camera/lamp_level.h"
#include "calib/drift/settle.h"
#include "machine/config/machine_config.h"
#include "machine/config/settings/vision_options.h"
#include "machine/devices/calibration_devices.h"
#include "program/model/measurement.h"

// Trials at one place with a mark: focus, lamp, how long to wait after a move.
namespace panelcal {

/// Looks for the height at which the camera is sharpest; see autofocus.
///
/// Fails  config-value (no focus command; the range is empty); travel-exceeded; device errors
/// See    tests/machine/look/place_trials_test.cc
Expected<FocusResult> calibrate_focus(const MachineConfig& config,
                                      const CalibrationDevices& devices,
                                      const Position<frame::Machine>& place,
                                      int tool,
                                      const FocusRange& range);

/// `n` levels from `low` to `high`, evenly.
///
/// Precondition: n >= 2
std::vector<double> lamp_levels(double low, double high, int n);

/// Lamp levels that were tried, and the best.
struct LightRun {
  std::vector<LampSample> samples;  ///< in the order of the levels
  std::optional<LampLevel> best;
  std::string reason;  ///< of a missing value
};

/// Tries lamp levels on a mark, which is looked for anew at each.
///
/// A level at which it is not found has no contrast. Clipped pixels are counted over the whole
/// picture. Afterwards the lamp stands at the best level, if there is one.
///
/// In     levels: 3 or more, in ascending order
/// Fails  config-value (no lamp command; too few levels, or not ascending);
///        vision-tool-undefined; travel-exceeded; device errors
Expected<LightRun> calibrate_light(const MachineConfig& config,
                                   const CalibrationDevices& devices,
                                   const Position<frame::Machine>& place,
                                   int tool,
                                   const std::vector<double>& levels);

/// Options of a trial of the settle time.
struct SettleTrial {
  int tool = 1;
  Length way = mm(10);        ///< of the moves before, along both axes, from below and from above
  Length limit = um(1);       ///< of the error that a picture may still see
  Time longest = seconds(1);  ///< after which a picture is taken at last
  int n_delays = 12;          ///< of a round
  /// Rounds: the first over all of `longest`, the others where the first saw the mark move.
  int n_moves = 3;
};

/// Course of the machine as it comes to rest at a place.
struct SettleRun {
  std::vector<SettleView> views;
  int n_missed = 0;  ///< pictures that showed no mark
  std::optional<SettleTime> settle;
  std::string reason;  ///< of a missing value
};

/// Moves away and back again and again, and takes a picture after another delay each time
/// (calib/drift/settle_delays.h).
///
/// A picture counts at the time it was asked for, by the devices' clock. To the detector's
/// covariance comes [uncertainty] stage_repeatability_um.
///
/// Fails  config-value (no [camera]; no way to wait, no clock; a trial outside its bounds);
///        vision-tool-undefined; travel-exceeded, before anything moves; device errors
Expected<SettleRun> calibrate_settle(const MachineConfig& config,
                                     const CalibrationDevices& devices,
                                     const Position<frame::Machine>& place,
                                     const SettleTrial& trial);

}  // namespace panelcal
