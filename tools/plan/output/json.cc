// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/output/json.h"

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "calib/base/json/json_string.h"
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

/// Of one target's error, as the inside of an object.
std::string noticed_keys(const SeriesPlan& series, const NoticedError& noticed) {
  if (!noticed.from) return "\"noticed_from_um\":null";
  return fmt::format("\"noticed_from_um\":{},\"noticed_by\":\"{}\"",
                     plan_number(*noticed.from * series.noise.in_um()),
                     name(noticed.by));
}

std::string trials_object(const ErrorTrials& trials) {
  return fmt::format("{{\"cases\":{},\"noticed\":{},\"named\":{},\"misnamed\":{}}}",
                     trials.n,
                     trials.n_noticed,
                     trials.n_named,
                     trials.n_misnamed);
}

std::string target_error(const SeriesPlan& series, const TargetError& error) {
  std::string out = noticed_keys(series, error.noticed);
  if (error.noticed.from) {
    out += fmt::format(",\"direction\":[{},{}]",
                       plan_number(error.noticed.direction.x()),
                       plan_number(error.noticed.direction.y()));
  }
  if (error.at_once) out += ",\"at_once\":" + trials_object(*error.at_once);
  if (error.at_twice) out += ",\"at_twice\":" + trials_object(*error.at_twice);
  return out;
}

/// Predicted knowledge of a fit, as the inside of an object.
std::string knowledge(const Plan& plan,
                      const SeriesPlan& series,
                      const PredictedFit& fit,
                      const LeverageStats& stats) {
  std::string out = fmt::format("\"dof\":{}", fit.degrees_of_freedom);
  if (stats.n > 0) {
    out += fmt::format(",\"worst\":{},\"worst_um\":{},\"total_um\":{},\"worst_at\":{},\"mean\":{}",
                       plan_number(stats.worst),
                       plan_number(stats.worst * series.noise.in_um()),
                       plan_number(plan.total_sigma(series, fit, stats.worst_place).in_um()),
                       place(stats.worst_place),
                       plan_number(stats.mean()));
  }
  return out;
}

std::string model(const Plan& plan, const SeriesPlan& series, const ModelPlan& one) {
  std::string out =
      fmt::format("{{\"model\":\"{}\",\"determined\":{},", name(one.model), one.fit.has_value());
  if (one.fit) {
    out += knowledge(plan, series, *one.fit, one.stats);
    if (one.noticed) out += "," + noticed_keys(series, *one.noticed);
    return out + "}";
  }
  return out + fmt::format("\"reason\":\"{}\"}}",
                           one.failure == FitFailure::TooFewTargets ? "targets-too-few"
                                                                    : "series-degenerate");
}

std::string addition(const Plan& plan, const SeriesPlan& series, const AdditionPlan& one) {
  std::string out = fmt::format("{{\"pads\":{},\"best\":{},\"model\":\"{}\",\"determined\":{}",
                                plan_json_list(one.pads, place),
                                one.is_best,
                                name(one.model),
                                one.fit.has_value());
  if (one.worst_if_kept) {
    out += fmt::format(",\"worst_if_model_kept\":{}", plan_number(*one.worst_if_kept));
  }
  if (one.fit) out += "," + knowledge(plan, series, *one.fit, one.stats);
  if (one.latest) out += "," + target_error(series, *one.latest);
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
  if (!series.errors.empty()) {
    out += ",\"errors\":" + plan_json_list(series.errors, [&](const TargetError& error) {
             return "{" + target_error(series, error) + "}";
           });
  }
  if (series.chosen) {
    out += fmt::format(",\"worst_if_chosen\":[{},{}]",
                       plan_number(series.chosen->low),
                       plan_number(series.chosen->high));
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
