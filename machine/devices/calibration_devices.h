// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "calib/base/clock.h"
#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "machine/devices/camera.h"
#include "machine/devices/picture_observer.h"
#include "machine/devices/spindle.h"
#include "machine/devices/stage.h"
#include "program/walk/probing.h"

namespace panelcal {

/// Tells the operator something and returns when it is done; fails if no person is there to do it.
using Prompt = std::function<Expected<void>(std::string_view)>;

/// By whom and when rows of the coupon are taken, for the ledger.
struct TakenBy {
  Clock clock;  ///< on the wall; must be there where machine.toml names a ledger
  std::string asked_by;
  std::string software;
  /// That the ledger knows all rows that are drilled, asked before others are taken; empty: it was
  /// asked before, as nights do.
  std::function<Expected<void>()> check_ledger = {};
};

/// The devices of a calibration; see DeviceSet for their owner.
struct CalibrationDevices {
  Stage& stage;
  Spindle& spindle;
  CameraDevice& camera;
  std::function<void(Time)> wait;  ///< empty: no waiting
  Prompt prompt;  ///< empty: there is no person to ask, and no coupon that needs it is drilled
  PictureObserver observer = {};
  /// A clock that never goes back, for what is timed; empty: nothing can be.
  std::function<Time()> now = {};
  ProbeSource* probe = nullptr;  ///< null: the machine cannot probe
  TakenBy taken_by = {};
};

}  // namespace panelcal
