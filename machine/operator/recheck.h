// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "calib/base/expected.h"
#include "calib/base/machine_uncertainty.h"
#include "program/model/measurement.h"
#include "program/walk/survey.h"

namespace panelcal::internal {

/// A panel that lies still is taken for a moved one this seldom.
inline constexpr double kMovedChance = 1e-3;

/// The two targets by which a moved panel shows best: the two farthest apart of those that the
/// camera has found in both coordinates. Nothing where there are fewer than two.
///
/// Cost   O(n^2); of more than 2000 targets the first 2000 count
std::optional<std::pair<std::size_t, std::size_t>> farthest_pair(
    std::span<const Measurement> measured);

/// The result of looking at two measured targets again.
struct Recheck {
  bool agrees = false;
  std::string words;
};

/// Looks again at two targets, and compares:
///
///   chi^2 = sum d' (C_old + C_new + 2 C_stage)^-1 d,   4 degrees of freedom, level kMovedChance
///
/// The table errs alike at both looks, since they are at one place.
///
/// In     nominal: of the check of the same program; source: as it was opened for the job
/// Fails  what the source reports; a target that is not found again is no failure: it has moved
/// See    tests/machine/operator/recheck_test.cc
Expected<Recheck> look_again(const Measurement& first,
                             const Measurement& second,
                             const Survey& nominal,
                             const MachineUncertainty& machine,
                             MeasurementSource& source);

}  // namespace panelcal::internal
