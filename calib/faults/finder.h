// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "calib/faults/examined_target.h"
#include "calib/faults/known_pads.h"
#include "calib/faults/series_fault.h"
#include "calib/panel/fit.h"
#include "calib/panel/gates.h"

namespace panelcal {

/// A target with what may speak for or against it.
template <class To, class From>
struct ExaminedTarget {
  TargetPair<To, From> pair;
  std::optional<double> score;  ///< of its picture, 0 to 1
  std::string name;             ///< name for people: "G36 target 3 in line 12"
  /// The pair's without what the machine adds; absent: it adds nothing.
  std::optional<Eigen::Matrix2d> picture_cov_mm2 = std::nullopt;
};

struct FaultContext {
  GateLimits limits;  ///< false_alarm decides; the others say what healthy panels do
  /// Something refuses the series already: say why, whatever the test says.
  bool is_refused = false;
  const KnownPads* pads = nullptr;  ///< places in From; null: unknown
};

namespace internal {
std::optional<SeriesFault> find_fault_raw(std::span<const ExaminedTarget> targets,
                                          PanelModel model,
                                          const FaultContext& context);
}  // namespace internal

/// Tests whether the targets of a series fit each other, and if they do not, what the matter is.
///
/// The test is that of chi square of the fit: healthy targets fail it with the probability
/// limits.false_alarm. Only then, or if the series is refused already, causes are looked for: each
/// is a story of how the measurements came about, weighed by the likelihood of what was measured
/// with everything integrated out that the story leaves open (MacKay 2003, chapter 28):
///
///   one target shifted by an unknown amount (mean shift; Beckman and Cook 1983), its picture bad
///   or not; one target another pad of the program; the panel turned, mirrored, or of another
///   scale, its targets seen themselves or whatever lay where the camera looked; several targets
///   elsewhere; a fit outside the limits; a softer panel; more noise than stated; chance
///
/// Probabilities are among these and rest on rough priors: 0.99 means that the measurements
/// contradict everything else on the list, not that nothing else can happen.
///
/// In     targets: mm, mm^2; slots count in their coordinate
/// Out    nothing if the test does not reject; else a fault with at least one suspicion
/// Cost   one fit for the test; with a fault some 10 n, with many pads up to some 10^5. Where noise
///        or limits allow too many ways to take pads for targets, none is weighed and no target is
///        named (SeriesFault::weighs_taken_pads)
/// Source Baarda 1968 (data snooping); MacKay 2003; docs/formulation.md
/// See    tests/calib/faults/finder_test.cc, tests/bench/outlier_bench.cc
template <class To, class From>
std::optional<SeriesFault> find_fault(std::span<const ExaminedTarget<To, From>> targets,
                                      PanelModel model,
                                      const FaultContext& context) {
  std::vector<internal::ExaminedTarget> raw;
  raw.reserve(targets.size());
  for (const auto& target : targets) {
    raw.push_back({target.pair.nominal.in_mm(),
                   target.pair.measured.position.in_mm(),
                   target.pair.measured.cov,
                   target.pair.axes,
                   target.score,
                   target.name,
                   target.picture_cov_mm2});
  }
  return internal::find_fault_raw(raw, model, context);
}

}  // namespace panelcal
