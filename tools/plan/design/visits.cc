// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/design/visits.h"

#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "calib/advice/visit_runs.h"
#include "calib/advice/visiting_order.h"

namespace panelcal::plan {
namespace {

/// Index of the series that each measurement belongs to; none for holes at their own target.
std::vector<std::optional<std::size_t>> series_by_measurement(const Survey& survey) {
  std::vector<std::optional<std::size_t>> out(survey.measurements.size());
  for (std::size_t s = 0; s < survey.series.size(); ++s) {
    for (const std::size_t i : survey.series[s].measurements) out[i] = s;
  }
  return out;
}

/// A base series is a phase of its own; what lies between two of them is another.
std::vector<int> phases_of(const Survey& survey,
                           const std::vector<std::optional<std::size_t>>& series) {
  std::vector<int> phases;
  std::optional<std::size_t> current;  // base series that the last target belongs to
  int phase = 0;
  for (const auto& of : series) {
    const bool is_base = of && survey.series[*of].level == CorrectionLevel::Base;
    const std::optional<std::size_t> base = is_base ? of : std::nullopt;
    if (!phases.empty() && base != current) ++phase;
    current = base;
    phases.push_back(phase);
  }
  return phases;
}

/// Layers of one target are in the order of the board, so such series stay as they are.
std::vector<VisitRun> runs_of(const Survey& survey,
                              const std::vector<std::optional<std::size_t>>& series) {
  std::map<std::vector<std::pair<std::string, int>>, std::size_t> kinds;
  std::vector<VisitRun> runs;
  for (std::size_t i = 0; i < series.size();) {
    VisitRun run;
    const auto of = series[i];
    const bool is_free =
        of && survey.series[*of].points.size() == survey.series[*of].measurements.size();
    std::vector<std::pair<std::string, int>> lines;
    do {
      const MeasurementRequest& request = survey.measurements[i].request;
      lines.emplace_back(request.file, request.line);
      run.places.push_back(i++);
    } while (is_free && i < series.size() && series[i] == of);
    run.kind = kinds.emplace(lines, kinds.size()).first->second;
    runs.push_back(std::move(run));
  }
  return runs;
}

}  // namespace

VisitPlan plan_visits(const Survey& survey) {
  VisitPlan plan;
  for (const Measurement& measurement : survey.measurements) {
    plan.places.push_back(measurement.request.nominal);
  }
  std::vector<std::size_t> programmed(plan.places.size());
  std::iota(programmed.begin(), programmed.end(), std::size_t{0});
  plan.programmed = way_length(plan.places, programmed);
  const auto series = series_by_measurement(survey);
  plan.within_series = order_within_runs(plan.places, runs_of(survey, series));
  plan.within_series_length = way_length(plan.places, plan.within_series);
  plan.free = short_order(plan.places, phases_of(survey, series));
  plan.free_length = way_length(plan.places, plan.free);
  plan.is_exact = plan.places.size() <= kMostExact;
  return plan;
}

}  // namespace panelcal::plan
