// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/spindle/fit.h"
#include "machine/calibrate/spindle/calibration.h"
#include "machine/config/machine_config.h"
#include "machine/devices/calibration_devices.h"
#include "machine/devices/camera.h"
#include "machine/devices/spindle.h"
#include "machine/devices/stage.h"
#include "machine/look/picture_locator.h"
#include "program/walk/probing.h"

namespace panelcal {

/// One calibration of the spindle-camera offset. Nothing is installed.
struct SpindleCameraRun {
  int i_row = 0;                                 ///< first row of the coupon that it used, from 0
  std::vector<Position<frame::Machine>> places;  ///< places to which the spindle was sent to drill
  CouponSights sights;                           ///< with the looks that showed no hole
  SpindleCameraFit fit;                          ///< with the holes that were left out
};

/// Calibrates the offset of [spindle] on the next free rows of [coupon]: looks whether the first of
/// them is empty, takes them, drills, looks, fits.
///
/// All that machine.toml can tell is checked before anything moves. Rows that were taken are used
/// up whatever happens then. A present offset that is wrong by a pitch, so that each hole would be
/// taken for its neighbour, is found out: earlier holes are seen before there is one to see, or an
/// edge of the lattice is not seen at all.
///
/// Fails  config-value (no [coupon], no [camera], no rows left, no [machine] drill_command,
///        no look that comes as the drill does); vision-tool-undefined; travel-exceeded;
///        device-stage; device-frame; device-write; calibration-refused (by the fit: its words, and
///        what was not seen; a hole that is there already; an edge that is not seen); what
///        used_rows and the prompt report
/// Cost   for each hole one stop to drill and a stop and a picture from each approach
/// See    tests/machine/calibrate/spindle/camera_run_test.cc
Expected<SpindleCameraRun> calibrate_spindle_camera(const MachineConfig& config,
                                                    const CalibrationDevices& devices);

/// The same at places that the program chose (G39 with coordinates: places_from). No row of the
/// coupon's state file is taken, and i_row is 0.
Expected<SpindleCameraRun> calibrate_spindle_camera_at(
    const MachineConfig& config,
    const CalibrationDevices& devices,
    std::vector<Position<frame::Machine>> places);

/// In lines: the fit's report, and which holes were not seen from where, and why.
std::string report_text(const SpindleCameraRun& run);

}  // namespace panelcal
