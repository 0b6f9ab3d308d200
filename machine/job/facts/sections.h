// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "calib/base/json/facts.h"
#include "machine/job/facts/input.h"
#include "machine/job/facts/survey_facts.h"

// Not installed: the parts of a job's document, as share/schema/job.schema.json describes them.
namespace panelcal::facts {

Json board_json(std::span<const int> path);
/// Every target with its pictures, in the order of the measuring.
Json targets_json(const JobFactsInput& input, std::span<const TargetFact> targets);
/// Every series with its fit, gates, models and causes.
Json series_json(const Survey& survey);
/// Of all series together; null where no equation is to spare.
Json pooled_chi_square_json(const Survey& survey);
/// Null without [tolerance] of positions.
Json tolerance_json(const JobFactsInput& input);
/// Null without [tolerance] of depths.
Json depth_json(const DepthVerdict* verdict);
/// Null without a hole.
Json budget_json(const std::optional<HoleBudget>& hole);
/// Null without truth.
Json truth_json(const TruthComparison* truth);
Json focus_json(const Survey& survey);
Json calibrations_json(const Survey& survey);
/// Null for a job that probes nothing and follows no map.
Json surface_json(const Survey& survey, const std::string& use);
/// Every tool that worked, with its counts.
Json tools_json(const Tally& tally);
/// Counts by tool, largest shift and sigma, and every place; null for a refused job.
Json places_json(const JobFactsInput& input);
Json messages_json(std::span<const Diagnostic> diagnostics);

}  // namespace panelcal::facts
