// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/diagnostic.h"
#include "machine/job/summary/place_table.h"
#include "machine/job/summary/truth_comparison.h"
#include "machine/job/summary/worst_hole.h"
#include "program/judge/depth_verdict.h"
#include "program/judge/job_verdict.h"
#include "program/judge/tally.h"
#include "program/walk/survey.h"
#include "vision/show/target_picture.h"
#include <Eigen/Core>

namespace panelcal {

/// One picture that a target was looked for in.
struct SeenPicture {
  int i_view = 0;
  MeasurementStatus status = MeasurementStatus::NotFound;
  std::string reason;                      ///< of another status than Found
  std::vector<Eigen::Vector2d> frame_mm;   ///< the picture's corners in work coordinates, in order
  std::optional<Eigen::Vector2d> seen_mm;  ///< the best candidate's place, if there was one
  TargetPicture picture;                   ///< without bytes: not kept
};

/// Everything that the facts of one job are made of. Texts may hold any bytes.
struct JobFactsInput {
  std::string program_file;
  std::string machine_name;
  std::string source;             ///< source of the measurements, in words
  std::string output_file;        ///< empty if nothing was written; "-" for standard output
  std::string output_words = {};  ///< for sentences; empty: its name
  bool forced = false;            ///< written although a gate or a tolerance refused it
  const Survey* survey = nullptr;
  const Tally* tally = nullptr;        ///< of the corrected program; null if it was not executed
  const PlaceTable* places = nullptr;  ///< likewise
  const TruthComparison* truth = nullptr;  ///< null without --truth
  const JobVerdict* verdict = nullptr;     ///< null if [tolerance] asks for no positions
  const DepthVerdict* depth = nullptr;     ///< null if it asks for no depths
  std::string surface_use;  ///< the part of --surface in the depths; empty without it
  /// Of the verdict's worst place, by which `run --explain` knows it; empty: its line says enough.
  std::optional<std::int64_t> worst_number;
  /// That all targets are larger or smaller than stated by one factor (CommonScale); or empty.
  std::string common_scale;
  std::string unstated;                                       ///< as JobResult::unstated
  std::optional<HoleBudget> worst_hole;                       ///< of the job, held or not
  std::map<std::int64_t, std::vector<SeenPicture>> pictures;  ///< by seq: all that were looked at
  std::span<const Diagnostic> diagnostics;
  std::vector<std::pair<std::string, std::string>> provenance;  ///< origin of this: key, value
};

struct JobResult;

/// The facts that a result has by itself; it outlives them.
JobFactsInput facts_input(const JobResult& result);

}  // namespace panelcal
