// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "program/walk/survey.h"

namespace panelcal::plan {

/// Ways to go from target to target. Orders are indices into Survey::measurements.
struct VisitPlan {
  std::vector<Position<frame::Nominal>> places;
  Length programmed;  ///< length of the way in the program's order
  /// Every series where it is, its own targets in the best order, the same in all copies of a
  /// pattern: a program can have this by exchanging lines.
  std::vector<std::size_t> within_series;
  Length within_series_length;
  /// Anything that looks for nested targets after those of their base series.
  std::vector<std::size_t> free;
  Length free_length;
  bool is_exact = false;  ///< `free` is the shortest there is
};

VisitPlan plan_visits(const Survey& survey);

}  // namespace panelcal::plan
