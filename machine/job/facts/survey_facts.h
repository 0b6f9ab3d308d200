// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "machine/job/facts/input.h"
#include "program/walk/survey.h"
#include <Eigen/Core>

namespace panelcal::facts {

enum class Verdict : std::uint8_t { Drill, Warned, Hold, Forced };

enum class TargetState : std::uint8_t {
  Good,
  Dropped,  ///< left out of its fit: found, by [gates] max_dropped, or skipped by a person
  Suspect,  ///< found, but its series was refused
  Refused,  ///< not found, or the worst of a series whose residual gate failed
};

constexpr std::string_view name(TargetState state) {
  switch (state) {
    case TargetState::Dropped:
      return "left_out";
    case TargetState::Suspect:
      return "suspect";
    case TargetState::Refused:
      return "refused";
    case TargetState::Good:
      break;
  }
  return "good";
}

/// One measured target with what its series made of it.
struct TargetFact {
  const Measurement* measurement = nullptr;
  const SeriesResult* series = nullptr;        ///< null for a measured hole (G38, G48)
  std::optional<std::size_t> i_series;         ///< the same as an index into Survey::series
  std::optional<Eigen::Vector2d> residual_mm;  ///< measured minus fitted
  TargetState state = TargetState::Good;
};

struct WorstGate {
  const SeriesResult* series = nullptr;
  const GateVerdict* gate = nullptr;
  double ratio = 0;  ///< value / limit; infinite where the value is no number
};

/// All chi squares added up: one number that tells more than many with one degree of freedom.
struct PooledChiSquare {
  double chi_square = 0;
  int degrees_of_freedom = 0;
};

/// The survey, never null.
const Survey& survey_of(const JobFactsInput& input);

Verdict verdict_of(const JobFactsInput& input);
double gate_ratio(const GateVerdict& gate);
/// The gate with the largest ratio over all series; a refused one goes before any accepted one.
/// Empty if no gate is set.
std::optional<WorstGate> worst_gate(const Survey& survey);
PooledChiSquare pooled_chi_square(const Survey& survey);

/// The meaning of a chi square for the noise, as a word of the schema, with no more certainty than
/// it has: "unchecked" (no equation to spare), "as_expected", "weak" (as expected, but one spare
/// equation checks little), "rather_large", "too_large", "too_large_weak", "too_small".
std::string_view chi_square_meaning(double chi_square, int degrees_of_freedom);

/// In the order of Survey::measurements.
std::vector<TargetFact> target_facts(const Survey& survey);

std::size_t n_found(const Survey& survey);
/// Targets that were found and left out of their fits.
std::size_t n_dropped(const Survey& survey);

/// "[0,1]"; empty outside of copies.
std::string board_text(std::span<const int> path);
/// "G46 target #9 in line 31, board [0,1], nominal (110.695, 15.000) mm".
std::string target_name(const MeasurementRequest& request);
/// "Panel, line 20", "Board [0,1], line 27", "Nested, line 27".
std::string series_name(const SeriesResult& series);

/// The grounds of the verdict, and the next step: one sentence each.
std::string verdict_sentence(const JobFactsInput& input);
std::string next_step(const JobFactsInput& input);

}  // namespace panelcal::facts
