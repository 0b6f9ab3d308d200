// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

// What became of a job, as the store keeps it. No part of it depends on when, by how many threads
// or in which order jobs were done.
namespace panelcal::batch {

enum class JobState : std::uint8_t {
  Drilled,  ///< the corrected program is there
  Held,     ///< measured, and refused by a gate or a tolerance: exit code 1 of `run`
  Failed,   ///< exit codes 2 and 3 of `run`
};

/// "drilled", "held", "failed".
std::string_view name(JobState state);

/// A value of a row: missing, a whole number, a number or a text. A number that is not finite is
/// stored as missing.
using StoredValue = std::variant<std::monostate, std::int64_t, double, std::string>;
using StoredRow = std::vector<StoredValue>;

/// The tables of rows about jobs, each beginning with the job's number (docs/formats/store.md).
enum class JobTable : std::uint8_t {
  Job,
  Target,
  Fit,
  HoleSummary,
  Diagnostic,
  PictureQuality,
};
inline constexpr std::size_t kJobTables = 6;

struct JobOutcome {
  std::int64_t number = 0;
  JobState state = JobState::Failed;
  int exit_code = 0;  ///< that `run` has for such a job
  std::int64_t n_pictures = 0;
  std::array<std::vector<StoredRow>, kJobTables> rows;

  std::vector<StoredRow>& of(JobTable table) { return rows[static_cast<std::size_t>(table)]; }
};

}  // namespace panelcal::batch
