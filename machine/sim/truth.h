// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "machine/config/machine_config.h"
#include "machine/sim/sim_table.h"
#include "program/model/measurement.h"

namespace panelcal {

/// True places of everything on a simulated panel.
///
///   actual = panel(board_path(nominal)),   both relative to work zero
///
/// Instances are the step-and-repeat paths at which the program measures targets; what is drilled
/// at the same path lies on the same board. All other paths lie on the panel itself.
struct Truth {
  struct Target {
    std::int64_t seq = 0;
    Position<frame::Nominal> nominal;
    Position<frame::Actual> actual;
    /// Of a single ring: from its middle, which is `actual`, to that of its hole.
    std::optional<Displacement<frame::Actual>> hole_offset = std::nullopt;
  };

  std::uint64_t seed = 0;
  Transform<frame::Actual, frame::Nominal> panel;
  std::map<InstancePath, Transform<frame::Actual, frame::Nominal>> instances;  ///< whole maps
  std::vector<Target> targets;
  /// Errors of the stage that drills into it; absent: none.
  std::optional<SimTable> table;

  /// The map at a path; a path that is not listed is on the panel.
  const Transform<frame::Actual, frame::Nominal>& actual_from_nominal(
      std::span<const int> path) const;
};

/// Draws the hidden truth: a function of the seed, and for each board of the seq of its first
/// target. The empty path is the panel itself and does not scatter.
Truth make_truth(const SimConfig& sim, std::span<const MeasurementRequest> requests);

/// Larger files are refused unread.
inline constexpr std::size_t kMaxTruthBytes = std::size_t{1} << 28;

/// The content of truth.json; numbers in the fewest digits that read back exactly.
std::string truth_text(const Truth& truth);

/// Fails  device-write
Expected<void> write_truth_json(const std::filesystem::path& path, const Truth& truth);

/// Reads truth.json of version 1, strictly.
///
/// Fails  file-unreadable; json-syntax; truth-invalid
/// See    tests/machine/sim/truth_test.cc
Expected<Truth> read_truth_json(const std::filesystem::path& path);

/// The same from text; `file` stands in the diagnostics.
Expected<Truth> parse_truth(std::string_view text, const std::string& file);

}  // namespace panelcal
