// SPDX-License-Identifier: Apache-2.0
#include "machine/job/facts/survey_facts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/base/number_text.h"
#include "calib/base/statistics/chi_square.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::facts {
namespace {

bool has_errors(const JobFactsInput& input) {
  return std::ranges::any_of(input.diagnostics,
                             [](const Diagnostic& d) { return d.severity() == Severity::Error; });
}

/// True if a residual gate refuses this target of the series.
bool is_worst(const SeriesResult& series, std::size_t i_target) {
  return std::ranges::any_of(series.gates, [&](const GateVerdict& gate) {
    return !gate.accepted && gate.i_target == i_target;
  });
}

bool is_warned(const JobVerdict* verdict) {
  return verdict != nullptr && verdict->decision() == JobDecision::DrillWithWarning;
}

/// Also of depths with a tolerance whose error is unknown.
bool is_warned(const DepthVerdict* verdict) {
  return verdict != nullptr &&
         (verdict->decision() == JobDecision::DrillWithWarning || verdict->places().n_unjudged > 0);
}

}  // namespace

const Survey& survey_of(const JobFactsInput& input) {
  static const Survey kEmpty;
  return input.survey != nullptr ? *input.survey : kEmpty;
}

Verdict verdict_of(const JobFactsInput& input) {
  if (input.output_file.empty()) return Verdict::Hold;
  if (input.forced) return Verdict::Forced;
  if (!survey_of(input).is_accepted() || has_errors(input)) return Verdict::Hold;
  return is_warned(input.verdict) || is_warned(input.depth) ? Verdict::Warned : Verdict::Drill;
}

double gate_ratio(const GateVerdict& gate) {
  if (gate.value == 0 && gate.limit >= 0) return 0;
  const double ratio = gate.value / gate.limit;
  return ratio >= 0 ? ratio : std::numeric_limits<double>::infinity();
}

std::optional<WorstGate> worst_gate(const Survey& survey) {
  std::optional<WorstGate> worst;
  for (const SeriesResult& series : survey.series) {
    for (const GateVerdict& gate : series.gates) {
      const double ratio = gate_ratio(gate);
      if (worst && !worst->gate->accepted && gate.accepted) continue;
      const bool is_first_refused = worst && worst->gate->accepted && !gate.accepted;
      if (!worst || is_first_refused || ratio > worst->ratio) {
        worst = WorstGate{&series, &gate, ratio};
      }
    }
  }
  return worst;
}

PooledChiSquare pooled_chi_square(const Survey& survey) {
  PooledChiSquare pooled;
  for (const SeriesResult& series : survey.series) {
    if (series.degrees_of_freedom <= 0) continue;
    pooled.chi_square += series.chi_square;
    pooled.degrees_of_freedom += series.degrees_of_freedom;
  }
  return pooled;
}

std::string_view chi_square_meaning(double chi_square, int degrees_of_freedom) {
  if (degrees_of_freedom <= 0) return "unchecked";
  const double p = chi_square_exceedance(chi_square, degrees_of_freedom);
  const bool is_weak = degrees_of_freedom == 1;
  // Written so that a NaN is too large.
  if (!(p >= 0.01)) return is_weak ? "too_large_weak" : "too_large";
  if (p < 0.05) return "rather_large";
  if (p > 0.999 && degrees_of_freedom >= 3) return "too_small";
  return is_weak ? "weak" : "as_expected";
}

std::vector<TargetFact> target_facts(const Survey& survey) {
  std::vector<TargetFact> facts(survey.measurements.size());
  for (std::size_t i = 0; i < facts.size(); ++i) facts[i].measurement = &survey.measurements[i];
  for (std::size_t i_series = 0; i_series < survey.series.size(); ++i_series) {
    const SeriesResult& series = survey.series[i_series];
    for (const std::size_t i : series.measurements) {
      if (i >= facts.size()) continue;
      facts[i].series = &series;
      facts[i].i_series = i_series;
      if (series.is_left_out) {
        facts[i].state = TargetState::Dropped;
      } else if (!series.is_accepted()) {
        facts[i].state = TargetState::Suspect;
      }
    }
    for (const std::size_t i : series.dropped) {
      if (i < facts.size()) facts[i].state = TargetState::Dropped;
    }
    for (std::size_t k = 0; k < series.points.size(); ++k) {
      if (series.points[k] >= facts.size()) continue;
      TargetFact& fact = facts[series.points[k]];
      if (k < series.residuals_mm.size()) fact.residual_mm = series.residuals_mm[k];
      if (is_worst(series, k)) fact.state = TargetState::Refused;
    }
  }
  for (TargetFact& fact : facts) {
    if (fact.measurement->status == MeasurementStatus::Found) continue;
    fact.state = is_left_out(*fact.measurement) ? TargetState::Dropped : TargetState::Refused;
  }
  return facts;
}

std::size_t n_found(const Survey& survey) {
  return static_cast<std::size_t>(
      std::ranges::count(survey.measurements, MeasurementStatus::Found, &Measurement::status));
}

std::size_t n_dropped(const Survey& survey) {
  std::size_t n = 0;
  for (const SeriesResult& series : survey.series) n += series.dropped.size();
  return n;
}

std::string board_text(std::span<const int> path) {
  return path.empty() ? std::string() : fmt::format("[{}]", fmt::join(path, ","));
}

std::string target_name(const MeasurementRequest& request) {
  const std::string path = board_text(request.path);
  const Eigen::Vector2d nominal_mm = request.nominal.in_mm();
  return fmt::format("{} target #{} in line {}{}, nominal ({}, {}) mm",
                     request.command,
                     request.seq,
                     request.line,
                     path.empty() ? "" : ", board " + path,
                     internal::fixed(nominal_mm.x(), 3),
                     internal::fixed(nominal_mm.y(), 3));
}

std::string series_name(const SeriesResult& series) {
  const std::string path = board_text(series.path);
  const bool is_base = series.level == CorrectionLevel::Base;
  std::string name = is_base ? "Panel" : path.empty() ? "Nested" : "Board";
  if (!path.empty()) name += " " + path;
  return fmt::format("{}, line {}", name, series.line);
}

}  // namespace panelcal::facts
