// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/output/json.h"

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "program/text/json_text.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::plan {
namespace {

/// Nine digits: enough for a nanometre on a metre, and the same on every processor.
std::string plan_number(double value) {
  return std::isfinite(value) ? fmt::format("{:.9g}", value) : "null";
}

std::string plan_point(const Position<frame::Nominal>& p) {
  return fmt::format("[{},{}]", plan_number(p.in_mm().x()), plan_number(p.in_mm().y()));
}

std::string place(const PlannedPlace& p) {
  std::string out = fmt::format("{{\"is\":\"{}\",\"nominal\":{},\"line\":{}",
                                p.is_target ? "target" : "hole",
                                plan_point(p.nominal),
                                p.line);
  if (!p.file.empty()) {
    out += ",\"file\":";
    append_json_string(out, p.file);
  }
  if (p.tool > 0) out += fmt::format(",\"tool\":{}", p.tool);
  return out + fmt::format(",\"path\":[{}]}}", fmt::join(p.path, ","));
}

template <class T, class Format>
std::string plan_json_list(const std::vector<T>& items, Format format) {
  std::string out = "[";
  for (const T& item : items) out += (out.size() > 1 ? "," : "") + format(item);
  return out + "]";
}

std::string_view answer_key(LieDetection::Answer answer) {
  constexpr std::array<std::string_view, 3> kWords = {"no", "in_part", "yes"};
  return kWords[static_cast<std::size_t>(answer)];
}

/// Predicted knowledge of a fit, as the inside of an object.
std::string knowledge(const Plan& plan,
                      const SeriesPlan& series,
                      const PredictedFit& fit,
                      const LeverageStats& stats,
                      const LieDetection& lies) {
  std::string out = fmt::format("\"dof\":{}", fit.degrees_of_freedom);
  if (stats.n > 0) {
    out += fmt::format(",\"worst\":{},\"worst_um\":{},\"total_um\":{},\"worst_at\":{},\"mean\":{}",
                       plan_number(stats.worst),
                       plan_number(stats.worst * series.noise.in_um()),
                       plan_number(plan.total_sigma(series, fit, stats.worst_place).in_um()),
                       place(stats.worst_place),
                       plan_number(stats.mean()));
  }
  out += fmt::format(",\"lie_found\":\"{}\",\"lie_named\":\"{}\"",
                     answer_key(lies.is_found),
                     answer_key(lies.is_named));
  if (lies.found_from) {
    out += fmt::format(",\"lie_found_from_um\":{}",
                       plan_number(*lies.found_from * series.noise.in_um()));
  }
  return out;
}

std::string model(const Plan& plan, const SeriesPlan& series, const ModelPlan& one) {
  std::string out =
      fmt::format("{{\"model\":\"{}\",\"determined\":{},", name(one.model), one.fit.has_value());
  if (one.fit) return out + knowledge(plan, series, *one.fit, one.stats, one.lies) + "}";
  return out + fmt::format("\"reason\":\"{}\"}}",
                           one.failure == FitFailure::TooFewTargets ? "targets-too-few"
                                                                    : "series-degenerate");
}

std::string addition(const Plan& plan, const SeriesPlan& series, const AdditionPlan& one) {
  std::string out = fmt::format("{{\"pads\":{},\"model\":\"{}\",\"determined\":{}",
                                plan_json_list(one.pads, place),
                                name(one.model),
                                one.fit.has_value());
  if (one.worst_if_kept) {
    out += fmt::format(",\"worst_if_model_kept\":{}", plan_number(*one.worst_if_kept));
  }
  if (one.fit) out += "," + knowledge(plan, series, *one.fit, one.stats, one.lies);
  return out + "}";
}

std::string series_object(const Plan& plan, const SeriesPlan& series) {
  std::string out = fmt::format(
      "{{\"level\":\"{}\",\"series\":{},\"model\":\"{}\",\"noise_um\":{},\"targets\":{},"
      "\"places\":{},\"places_are\":\"{}\",\"models\":{},\"hull\":{},\"outside\":{}",
      series.level == CorrectionLevel::Base ? "base" : "nested",
      series.i_series,
      name(series.programmed),
      plan_number(series.noise.in_um()),
      plan_json_list(series.targets, place),
      series.n_places,
      series.serves_targets ? "targets" : "holes",
      plan_json_list(series.models, [&](const ModelPlan& one) { return model(plan, series, one); }),
      plan_json_list(series.hull, plan_point),
      series.n_outside);
  if (series.n_outside > 0) {
    out += fmt::format(",\"farthest_mm\":{},\"farthest_at\":{}",
                       plan_number(series.farthest.in_mm()),
                       place(series.farthest_place));
  }
  out += fmt::format(",\"candidates\":{},\"thinned\":{}", series.n_candidates, series.is_thinned);
  std::vector<AdditionPlan> additions;
  for (const auto* one : {&series.one, &series.several}) {
    if (*one) additions.push_back(**one);
  }
  return out +
         fmt::format(",\"additions\":{}}}", plan_json_list(additions, [&](const AdditionPlan& one) {
                       return addition(plan, series, one);
                     }));
}

}  // namespace

std::string plan_json(const Plan& plan, const Program& program) {
  std::string out = "{\"program\":";
  append_json_string(out, program.source.file);
  out += fmt::format(
      ",\"places\":{},\"uncorrected\":{},\"own_target\":{},\"targets\":{},\"base_series\":{},"
      "\"nested_series\":{},\"like_worst\":{},\"picture_sigma_um\":{},\"plans\":{}",
      plan.n_places,
      plan.n_uncorrected,
      plan.n_own_target,
      plan.n_targets,
      plan.n_base,
      plan.n_nested,
      plan.n_like_worst,
      plan_number(plan.picture_sigma.in_um()),
      plan_json_list(plan.series,
                     [&](const SeriesPlan& series) { return series_object(plan, series); }));
  const VisitPlan& visits = plan.visits;
  return out + fmt::format(
                   ",\"visits\":{{\"programmed_mm\":{},\"within_series_mm\":{},\"within_series\":"
                   "[{}],\"free_mm\":{},\"free\":[{}],\"exact\":{}}}}}\n",
                   plan_number(visits.programmed.in_mm()),
                   plan_number(visits.within_series_length.in_mm()),
                   fmt::join(visits.within_series, ","),
                   plan_number(visits.free_length.in_mm()),
                   fmt::join(visits.free, ","),
                   visits.is_exact);
}

}  // namespace panelcal::plan
