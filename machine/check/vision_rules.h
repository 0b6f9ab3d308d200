// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/diagnostic.h"
#include "machine/check/stated_keys.h"
#include "machine/config/settings/machine.h"
#include "program/walk/survey.h"

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

/// Holds series of [vision] rotate targets, where it is stated, against the model and the gates:
///
///   model                6 to 128 targets for `smooth`, 3 or more for `stretch` and `affine`
///   [gates] max_dropped  two targets or more are left, since one has no equation to spare
///
/// A program may set the size of its series itself ($uvis,alg; all of SIEB & MEYER): where there is
/// one, its own series count.
///
/// Out    log: config-value, at the key
void check_stated_series(const MachineConfig& config, const StatedKeys& keys, DiagnosticLog& log);

/// Holds [gates] max_dropped and that of [gates.nested] against the largest series that the program
/// has, base and nested.
///
/// In     nominal: the survey of the perfect panel
/// Out    log: config-value, at the key in machine.toml
void check_dropped_targets(const MachineConfig& config,
                           const StatedKeys& keys,
                           const Survey& nominal,
                           DiagnosticLog& log);

}  // namespace panelcal
