// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "calib/base/diagnostic.h"
#include "calib/base/frames.h"

namespace panelcal {

/// The decision on a job by [tolerance].
enum class JobDecision : std::uint8_t {
  NotJudged,         ///< no place has both a tolerance and a predicted error
  Drill,             ///< every place is as sure as asked
  DrillWithWarning,  ///< a place is above warn_above or not judged, or some may break in sum
  Hold,              ///< a place is above hold_above, or one or more are expected to break
};

/// "drill", "drill, with a warning", "hold", "not judged".
std::string_view name(JobDecision decision);

/// Risks that cannot hurt one by one add up over a million holes: the chance that any place breaks
/// is at most their sum.
inline constexpr double kExpectedToWarn = 0.1;
inline constexpr double kExpectedToHold = 1;

/// Places of a job by their risks.
struct JudgedPlaces {
  std::int64_t n_judged = 0;
  std::int64_t n_unjudged = 0;  ///< with a tolerance, and nothing to hold it against
  std::int64_t n_warned = 0;    ///< above warn_above, those above hold_above included
  std::int64_t n_held = 0;
  double expected_broken = 0;  ///< the sum of the risks
};
JobDecision decide(const JudgedPlaces& places);

/// A probability in two digits, "below 1e-12" where the figure no longer matters.
std::string risk_text(double risk);

/// "at nominal (1.000, 2.000) mm, copy [0,3]".
std::string place_text(const Position<frame::Nominal>& nominal, std::span<const int> path);
/// "14", "pattern.exc:14" of a line in another file than the program.
std::string line_text(std::string_view file, int line);

/// tolerance-hold or tolerance-warning of risks that only hurt in sum; empty if they do not.
///
/// In     file: the program; things: "places"
///        has_said: a tool has been warned of already, so that only what holds the job is new
std::optional<Diagnostic> sum_problem(const JudgedPlaces& places,
                                      bool has_said,
                                      const std::string& file,
                                      std::string_view things);

/// "1 place", "7 places".
std::string count_of(std::int64_t n, std::string_view one, std::string_view many);

}  // namespace panelcal
