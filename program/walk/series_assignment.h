// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/faults/constellation.h"
#include "calib/panel/gates.h"
#include "program/model/measurement.h"

namespace panelcal {

/// Candidate of its picture that each target of a series is.
struct SeriesAssignment {
  Constellation found;
  std::vector<std::size_t> n_candidates;  ///< that count, of each target

  /// The likeliest combination is beyond doubt; it may still lack targets.
  bool is_certain() const;
  /// A sentence with both of the likeliest combinations: how far each is shifted, which targets it
  /// has where, how much less likely the second is.
  std::string text() const;
};

/// Assigns the candidates of a series' pictures jointly, if any picture has a choice.
///
/// In     measurements: of one series, in work coordinates; limits: of its level
/// Out    empty for a single target, for slots, and where every picture has one candidate at most
/// See    tests/program/walk/series_assignment_test.cc
std::optional<SeriesAssignment> assign_series(std::span<const Measurement> measurements,
                                              const GateLimits& limits);

/// Sets what the assignment says of each target: found, at its candidate; not found, where others
/// have it and its picture shows nothing; ambiguous, if the data cannot tell.
void settle(const SeriesAssignment& assignment, std::span<Measurement> measurements);

}  // namespace panelcal
