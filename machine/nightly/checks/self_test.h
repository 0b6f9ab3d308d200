// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "calib/base/expected.h"
#include "machine/nightly/record/night_history.h"
#include "machine/nightly/record/night_job.h"
#include "machine/nightly/record/night_record.h"

namespace panelcal {

/// Checks that the disk has room for what a night writes.
SelfTestCheck check_disk(const std::filesystem::path& ledger, double min_mb);

/// Scatter, contrast and blur of the mark.
inline constexpr int kMarkQualities = 3;

/// The result of five looks at the mark of [nightly].
struct MarkLooks {
  /// Scatter of the looks; contrast and blur of the mark.
  QualityNight quality;
  /// Checks that it was found every time, and of the overexposed part of the picture.
  std::vector<SelfTestCheck> checks;
};

/// Looks at the mark, coming each time anew from the same side.
///
/// Fails  config-value (no [camera]); vision-tool-undefined; travel-exceeded, before anything
/// moves;
///        device-stage; device-frame; picture-mismatch
/// See    tests/machine/nightly/checks/self_test_test.cc
Expected<MarkLooks> test_mark(const MachineConfig& config,
                              const NightlyConfig& nightly,
                              const CalibrationDevices& devices);

/// The temperature that [nightly] names a file or a program for.
///
/// Out    empty: none is named
/// Fails  file-unreadable; device-stage; config-value (no number from -50 to 100)
Expected<std::optional<double>> read_temperature(const NightlyConfig& nightly);

}  // namespace panelcal
