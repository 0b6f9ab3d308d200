// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "calib/faults/constellation_target.h"
#include "calib/panel/gates.h"
#include <Eigen/Core>

namespace panelcal {

struct ConstellationOptions {
  GateLimits limits;  ///< rotation and stretch of healthy panels; residual; false_alarm
  /// A combination whose every score is below the best of its picture by this much is refuted by
  /// scores alone: as LocateOptions::ambiguity_margin for one picture.
  double score_margin = 0.15;
};

/// The state of a target in a combination.
enum class Presence : std::uint8_t {
  Matched,   ///< it is one of the candidates
  Doubtful,  ///< something stands in its place that does not count
  Blank,     ///< its picture shows the place, and nothing there
  Unseen,    ///< its picture does not show the place, or it is not known whether it does
};

/// "found", "covered", "missing", "not seen".
std::string_view name(Presence presence);

/// One candidate or none for each target, all on one panel.
struct Combination {
  std::vector<std::optional<std::size_t>> choice;  ///< index into the target's candidates
  std::vector<Presence> presence;
  std::vector<Eigen::Vector2d> predicted_mm;           ///< place of each target by the panel's map
  Eigen::Vector2d shift_mm = Eigen::Vector2d::Zero();  ///< mean of predicted minus expected
  double rotation_rad = 0;
  double log_weight = 0;   ///< evidence, natural logarithm
  double probability = 0;  ///< among all combinations, and that the pictures show none of them
  bool is_complete() const;
};

/// The consistent combinations of a series.
struct Constellation {
  std::vector<Combination> ranked;  ///< the likeliest first, at most 16
  /// Probability that the targets lie where no picture shows them, within the searched radius.
  double outside = 0;
  double false_alarm = 0;     ///< the chance of a wrong assignment that is accepted
  bool is_exhaustive = true;  ///< false: there were too many combinations to try all

  /// The first combination has all targets, and all else together is less likely than
  /// `false_alarm`.
  bool is_decided() const;
};

/// Assigns the candidates of all targets of a series jointly.
///
/// A combination gives each target one candidate or none. Its evidence is
///
///   log w = - sum_matched max(0, d_i^2 - 6) / 2 + sum_missing log f_i + [incomplete] log 0.05 - g
///
/// with d_i the distance, in sigmas, of a candidate from where the panel's map has it: shift free,
/// rotation, scales and shear as the limits say (a limit is two sigma), the candidate's covariance
/// and the residual of healthy panels. f_i is the chance of what the picture shows where the map
/// has a missing target: 1 outside of the view, which speaks neither for nor against it; little
/// where something stands that does not count; next to none where there is nothing. 0.05 is the
/// chance of a set of other pads that stands in for the targets. Scores count by g, the least gap
/// to the best of a picture.
///
/// A match does not count as evidence: equal pads in equal surroundings match wherever the panel
/// lies. What refutes a shifted combination is a place that is seen and has no pad. So a series
/// whose targets all have the same neighbours stays undecided.
///
/// The search is exhaustive and deterministic: depth first over targets, the farthest from those
/// before it next; a branch is cut as soon as its candidates are no longer jointly compatible.
///
/// In     targets: 2 or more; mm, mm^2
/// Out    combinations by evidence, with probabilities
/// Cost   about candidates^2 maps times targets; 70 us for three targets in rows of pads
/// Source Neira and Tardos 2001 (joint compatibility); Reid 1979 (assignment hypotheses with
///        missed detections); Grimson and Lozano-Perez 1987 (interpretation tree with a null
///        branch)
/// See    tests/calib/faults/constellation_test.cc; docs/formulation.md, Assignment
Constellation assign_jointly(std::span<const ConstellationTarget> targets,
                             const ConstellationOptions& options);

}  // namespace panelcal
