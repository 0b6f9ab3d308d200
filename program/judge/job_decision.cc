// SPDX-License-Identifier: Apache-2.0
#include "program/judge/job_decision.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

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

std::string place_text(const Position<frame::Nominal>& nominal, std::span<const int> path) {
  const Eigen::Vector2d& at_mm = nominal.in_mm();
  const std::string copy = path.empty() ? "" : fmt::format(", copy [{}]", fmt::join(path, ","));
  return fmt::format("at nominal ({:.3f}, {:.3f}) mm{}", at_mm.x(), at_mm.y(), copy);
}

std::string line_text(std::string_view file, int line) {
  return file.empty() ? std::to_string(line) : fmt::format("{}:{}", file, line);
}

std::optional<Diagnostic> sum_problem(const JudgedPlaces& places,
                                      bool has_said,
                                      const std::string& file,
                                      std::string_view things) {
  const bool is_held = !(places.expected_broken < kExpectedToHold);
  const bool is_known = is_held ? places.n_held > 0 : has_said;
  if (places.expected_broken < kExpectedToWarn || is_known) return std::nullopt;
  return Diagnostic{is_held ? Code::ToleranceHold : Code::ToleranceWarning,
                    {file, 0, 0},
                    fmt::format("{} of {} {} are expected to break their tolerance",
                                risk_text(places.expected_broken),
                                places.n_judged,
                                things),
                    fmt::format("fewer than {:g}", is_held ? kExpectedToHold : kExpectedToWarn)};
}

std::string count_of(std::int64_t n, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", n, n == 1 ? one : many);
}

}  // namespace panelcal
