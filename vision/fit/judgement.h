// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "vision/fit/frame.h"

// Not installed.
namespace panelcal::internal {

/// The standing of a fitted candidate, the best first.
enum class Verdict {
  Good,
  Unfit,     ///< surely there, but not the target asked for: wrong size, at the border
  Unlikely,  ///< too faint or too little like the target to be called one
};

/// A verdict and what speaks against the candidate.
struct Judgement {
  Verdict verdict = Verdict::Good;
  std::string reason;  ///< empty of a good one
};

inline Judgement unfit(std::string reason) {
  return {Verdict::Unfit, std::move(reason)};
}
inline Judgement unlikely(std::string reason) {
  return {Verdict::Unlikely, std::move(reason)};
}

/// The objections that shapes share; empty where there is none.
using Problem = std::optional<std::string>;

inline constexpr const char* kUnlikeTarget = "it does not look like the target";

/// In     contrast: grey levels, above 0 for a target of the polarity asked for; least: likewise
Problem contrast_problem(double contrast, double least);
Problem score_problem(double score, double least);
/// A turn against the angle asked for counts only beyond three sigmas of its own.
Problem turn_problem(double turn_rad, double sigma_rad, double tolerance_rad);
/// Lengths in frame units; a deviation beyond the tolerance by less than `slack` does not count.
Problem size_problem(const FitFrame& fit_frame,
                     std::string_view what,
                     double seen,
                     double asked,
                     double tolerance,
                     double slack = 0);

}  // namespace panelcal::internal
