// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/job_decision.h"

#include <fmt/format.h>

namespace panelcal {

std::string_view name(JobDecision decision) {
  switch (decision) {
    case JobDecision::Drill:
      return "drill";
    case JobDecision::DrillWithWarning:
      return "drill, with a warning";
    case JobDecision::Hold:
      return "hold";
    case JobDecision::NotJudged:
      break;
  }
  return "not judged";
}

// Written so that a NaN holds the job.
JobDecision decide(const JudgedPlaces& places) {
  if (places.n_judged == 0) return JobDecision::NotJudged;
  if (places.n_held > 0 || !(places.expected_broken < kExpectedToHold)) return JobDecision::Hold;
  const bool is_sure =
      places.n_warned == 0 && places.n_unjudged == 0 && places.expected_broken < kExpectedToWarn;
  return is_sure ? JobDecision::Drill : JobDecision::DrillWithWarning;
}

std::string risk_text(double risk) {
  return risk < 1e-12 ? "below 1e-12" : fmt::format("{:.2g}", risk);
}

std::string count_of(std::int64_t n, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", n, n == 1 ? one : many);
}

}  // namespace panelcal
