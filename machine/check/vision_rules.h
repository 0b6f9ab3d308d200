// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/diagnostic.h"
#include "machine/check/stated_keys.h"
#include "machine/config/settings/machine.h"

namespace panelcal {

/// Holds [vision] against the camera:
///
///   [[vision.tool]] size  not larger than the picture of any calibration of [camera], and at least
///                         the 6 px that the detectors measure (templates and tags have a limit of
///                         their own)
///   search_radius_mm      at least a pixel
///
/// Out    log: config-value, at the key of each
/// See    tests/machine/check/vision_rules_test.cc
void check_vision_rules(const MachineConfig& config, const StatedKeys& keys, DiagnosticLog& log);

/// Holds series of [vision] rotate targets, where it is stated, against the model: 6 to 128 targets
/// for `smooth`, 3 or more for `affine`.
///
/// A program may set the size of its series itself ($uvis,alg; all of SIEB & MEYER): where there is
/// one, its own series count.
///
/// Out    log: config-value, at the key
void check_stated_series(const MachineConfig& config, const StatedKeys& keys, DiagnosticLog& log);

}  // namespace panelcal
