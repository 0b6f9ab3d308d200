// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "program/model/operation.h"
#include "program/model/placement.h"
#include <Eigen/Core>

namespace panelcal {

/// A map between places in work coordinates.
using WorkMap = Transform<frame::Nominal, frame::Nominal>;

/// Map that PatternEnd applies to a place of its pattern.
WorkMap work_map(const Placement& copy);

/// Mirrors and swap of copy_orientation that make up a linear part; absent if it is not one of the
/// eight that the axes allow.
std::optional<CopyRun> copy_run(const Eigen::Matrix2d& linear);

/// The offset command of SIEB & MEYER with this linear part: "M50", "M60M70"; empty if none has it.
///
/// Source SIEB & MEYER CNC 8x.00 Command Set, 5.5 (worked examples)
std::string_view offset_command(const Eigen::Matrix2d& linear);

/// A copy in whole steps of a written number, so that sums of offsets do not drift.
struct SteppedCopy {
  CopyRun orientation;
  std::int64_t x = 0;
  std::int64_t y = 0;
};

/// Equal steps from copy to copy. Turned and mirrored copies stand alone: the manual shows no row
/// of them.
struct EqualCopies {
  CopyRun orientation;
  std::int64_t count = 1;
  std::int64_t step_x = 0;
  std::int64_t step_y = 0;
};

/// Rows of at most `most` copies whose steps, added up from zero, lead through all of them.
std::vector<EqualCopies> rows_of(std::span<const SteppedCopy> copies, std::int64_t most);

}  // namespace panelcal
