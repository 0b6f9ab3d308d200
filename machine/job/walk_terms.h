// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "program/walk/reading_terms.h"

namespace panelcal {

/// Time, limits and name of a program that is walked through: what every such command sets.
struct WalkTerms {
  std::string program;  ///< its path as on the command line; `-` is standard input; empty: none
  std::string clock;    ///< the time on the wall, as wall_time() takes it; empty: `now`
  std::chrono::sys_seconds now{};  ///< UTC
  std::int64_t max_operations = kUsualMaxOperations;
  std::optional<ReadingTerms> reading = {};  ///< absent: as the machine has them
  /// The spindle-camera offset drifts until then. Not where nothing is measured or corrected.
  bool ages_offset = true;
  std::string command = "panelcal";  ///< as diagnostics about the clock name who asks
};

/// Sets them in a machine: age of the spindle-camera offset, texts of the day and of the program's
/// name, limit of operations, terms of reading.
///
/// Out    the time on the wall
/// Fails  usage (clock); config-value (the offset was found after that time)
/// See    tests/machine/job/walk_terms_test.cc
Expected<std::string> set_walk_terms(const WalkTerms& terms, MachineConfig& machine);

}  // namespace panelcal
