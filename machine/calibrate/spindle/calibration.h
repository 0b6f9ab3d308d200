// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/spindle/fit.h"
#include "machine/calibrate/spindle/coupon.h"
#include "machine/config/machine_config.h"
#include "machine/devices/calibration_devices.h"
#include "machine/devices/camera.h"
#include "machine/devices/spindle.h"
#include "machine/devices/stage.h"
#include "machine/look/picture_locator.h"

namespace panelcal {

/// Checks before anything moves that everything is there that a calibration at these places needs.
///
/// Fails  config-value (no [camera]); vision-tool-undefined; not-supported (an algorithm);
///        travel-exceeded
Expected<void> check_coupon_job(const MachineConfig& config,
                                const Coupon& coupon,
                                std::span<const Position<frame::Machine>> places);

/// Drills the holes of one calibration.
///
/// Entry material is asked for before and its removal after, where the coupon has it (CNC-7 manual,
/// G39: "you will be instructed to install and remove the entry material at the appropriate
/// places"). Every place is come to from the coupon's drilling approach.
///
/// In     places: as places_of_row or places_from give them, of rows that were taken (take_rows)
/// Fails  device-stage; travel-exceeded, before anything moves; what `prompt` reports
Expected<void> drill_coupon(const MachineConfig& config,
                            const Coupon& coupon,
                            std::span<const Position<frame::Machine>> places,
                            Stage& stage,
                            Spindle& spindle,
                            const Prompt& prompt);

/// A look that showed no hole.
struct MissedLook {
  std::size_t i_place = 0;
  int i_look = 0;
  std::string reason;
};

/// The looks at the coupon.
struct CouponSights {
  std::vector<CouponHole> holes;     ///< those that were seen at all: the input of the fit
  std::vector<std::size_t> i_place;  ///< of each of them
  std::vector<MissedLook> missed;
};

/// The looking side: devices, and how to wait for the machine to come to rest.
struct CouponLooker {
  Stage& stage;
  CameraDevice& camera;
  std::function<void(Time)> wait;  ///< called with [machine] settle_s
  PictureObserver observer = {};
};

/// Looks at the holes from every approach of the coupon, with the machine's present offset.
///
/// All holes from the first approach, then all from the second and so on: what drifts meanwhile
/// becomes scatter between the looks at a hole, and is not overlooked. The present offset only says
/// where to look; no error of it is in the result.
///
/// In     places: where the spindle was sent to drill
/// Fails  config-value (no [camera]); vision-tool-undefined; travel-exceeded, before anything
///        moves; device-stage; device-frame; picture-mismatch
/// See    tests/machine/calibrate/spindle/calibration_test.cc
Expected<CouponSights> look_at_coupon(const MachineConfig& config,
                                      const Coupon& coupon,
                                      std::span<const Position<frame::Machine>> places,
                                      const CouponLooker& looker);

/// The options of the fit that machine.toml states: expected scatter of [uncertainty].
SpindleCameraFitOptions fit_options(const MachineConfig& config);

}  // namespace panelcal
