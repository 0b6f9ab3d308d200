// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/diagnostic.h"
#include "machine/check/stated_keys.h"
#include "machine/config/settings/machine.h"

namespace panelcal {

/// Holds the files that nights write against those that they read:
///
///   [nightly.surface] file  no other file of machine.toml, not in a folder of pictures, and what
///                           stands there is a map
///   [nightly.table] file    the same, but for [table] calibration, and a table's calibration
///   [nightly] reports       a folder, or nothing yet; no folder of pictures
///
/// Out    log: config-value, at the key of each
/// See    tests/machine/check/file_rules_test.cc
void check_file_rules(const MachineConfig& config, const StatedKeys& keys, DiagnosticLog& log);

}  // namespace panelcal
