// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/output/json.h"

#include <algorithm>
#include <cmath>

#include "calib/panel/model.h"

namespace panelcal::plan {
namespace {

using facts::Json;

constexpr int kPlanVersion = 1;

Json place(const PlannedPlace& p) {
  Json out = {{"is", p.is_target ? "target" : "hole"},
              {"nominal_mm", facts::point(p.nominal.in_mm())},
              {"line", p.line}};
  if (!p.file.empty()) out["file"] = p.file;
  if (p.tool > 0) out["tool"] = p.tool;
  if (!p.path.empty()) out["path"] = p.path;
  return out;
}

Json corners(const std::vector<Position<frame::Nominal>>& places) {
  Json out = Json::array();
  for (const auto& corner : places) out.push_back(facts::point(corner.in_mm()));
  return out;
}

/// [l00 l01 l10 l11 tx ty] by rows.
template <class Matrix>
Json matrix(const Matrix& values) {
  Json out = Json::array();
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index k = 0; k < values.cols(); ++k) row.push_back(values(i, k));
    out.push_back(std::move(row));
  }
  return out;
}

/// Columns of equal length; those that no place has a value in are left out.
Json candidates(const std::vector<PlannedPlace>& places) {
  Json out;
  for (const char* column : {"x_mm", "y_mm", "line", "tool", "is_target"}) {
    out[column] = Json::array();
  }
  for (const PlannedPlace& place : places) {
    out["x_mm"].push_back(place.nominal.in_mm().x());
    out["y_mm"].push_back(place.nominal.in_mm().y());
    out["line"].push_back(place.line);
    out["tool"].push_back(place.tool);
    out["is_target"].push_back(place.is_target);
  }
  if (!std::ranges::all_of(places, &std::string::empty, &PlannedPlace::file)) {
    for (const PlannedPlace& place : places) out["file"].push_back(place.file);
  }
  if (!std::ranges::all_of(places, &InstancePath::empty, &PlannedPlace::path)) {
    for (const PlannedPlace& place : places) out["path"].push_back(place.path);
  }
  return out;
}

void add_noticed(Json& out, const SeriesPlan& series, const NoticedError& noticed) {
  out["noticed_from_um"] = Json();
  if (!noticed.from) return;
  out["noticed_from_um"] = *noticed.from * series.noise.in_um();
  out["noticed_by"] = name(noticed.by);
}

Json trials(const ErrorTrials& tried) {
  return {{"cases", tried.n},
          {"noticed", tried.n_noticed},
          {"named", tried.n_named},
          {"misnamed", tried.n_misnamed}};
}

Json target_error(const SeriesPlan& series, const TargetError& error) {
  Json out;
  add_noticed(out, series, error.noticed);
  if (error.noticed.from) out["direction"] = facts::point(error.noticed.direction);
  if (error.at_once) out["at_once"] = trials(*error.at_once);
  if (error.at_twice) out["at_twice"] = trials(*error.at_twice);
  return out;
}

/// What a fit will know of the places.
void add_knowledge(Json& out,
                   const Plan& plan,
                   const SeriesPlan& series,
                   const PredictedFit& fit,
                   const LeverageStats& stats) {
  out["dof"] = fit.degrees_of_freedom;
  if (stats.n == 0) return;
  out["worst_leverage"] = stats.worst;
  out["worst_um"] = stats.worst * series.noise.in_um();
  out["total_um"] = plan.total_sigma(series, fit, stats.worst_place).in_um();
  out["worst_at"] = place(stats.worst_place);
  out["mean_leverage"] = stats.mean();
}

Json model(const Plan& plan, const SeriesPlan& series, const ModelPlan& one) {
  Json out = {{"model", name(one.model)}, {"determined", one.fit.has_value()}};
  if (!one.fit) {
    const bool are_few = one.failure == FitFailure::TooFewTargets;
    out["reason"] = are_few ? "targets-too-few" : "series-degenerate";
    return out;
  }
  add_knowledge(out, plan, series, *one.fit, one.stats);
  if (one.noticed) add_noticed(out, series, *one.noticed);
  return out;
}

Json addition(const Plan& plan, const SeriesPlan& series, const AdditionPlan& one) {
  Json out = {{"pads", Json::array()},
              {"best", one.is_best},
              {"model", name(one.model)},
              {"determined", one.fit.has_value()}};
  for (const PlannedPlace& pad : one.pads) out["pads"].push_back(place(pad));
  if (one.fit) add_knowledge(out, plan, series, *one.fit, one.stats);
  if (one.worst_if_kept) out["worst_leverage_if_model_kept"] = *one.worst_if_kept;
  if (one.latest) out["latest_error"] = target_error(series, *one.latest);
  return out;
}

Json targets(const SeriesPlan& series) {
  Json out = Json::array();
  for (std::size_t i = 0; i < series.targets.size(); ++i) {
    Json target = place(series.targets[i]);
    target["weight"] = facts::covariance(internal::weight(series.design[i]));
    if (i < series.errors.size()) target["error"] = target_error(series, series.errors[i]);
    out.push_back(std::move(target));
  }
  return out;
}

Json series_facts(const Plan& plan, const SeriesPlan& series) {
  Json out = {{"level", series.level == CorrectionLevel::Base ? "base" : "nested"},
              {"series", series.i_series},
              {"model", name(series.programmed)},
              {"noise_um", series.noise.in_um()},
              {"targets", targets(series)}};
  if (!series.base_cov.isZero(0)) out["base_cov"] = matrix(series.base_cov);
  out["places"] = series.n_places;
  out["places_are"] = series.serves_targets ? "targets" : "holes";
  out["models"] = Json::array();
  for (const ModelPlan& one : series.models) out["models"].push_back(model(plan, series, one));
  if (series.chosen) {
    out["worst_leverage_if_chosen"] = {series.chosen->low, series.chosen->high};
  }
  out["hull_mm"] = corners(series.hull);
  out["places_hull_mm"] = corners(series.places_hull);
  out["outside"] = series.n_outside;
  if (series.n_outside > 0) {
    out["farthest_mm"] = series.farthest.in_mm();
    out["farthest_at"] = place(series.farthest_place);
  }
  out["has_slots"] = series.has_slots;
  out["models_with"] = Json::array();
  for (const PanelModel with : series.models_with) out["models_with"].push_back(name(with));
  out["thinned"] = series.is_thinned;
  out["candidates"] = candidates(series.candidates);
  out["additions"] = Json::array();
  for (const auto* one : {&series.one, &series.several}) {
    if (*one) out["additions"].push_back(addition(plan, series, **one));
  }
  return out;
}

Json visits(const VisitPlan& plan, const Survey& survey) {
  Json out = {{"x_mm", Json::array()}, {"y_mm", Json::array()}, {"line", Json::array()}};
  for (const Measurement& measurement : survey.measurements) {
    out["x_mm"].push_back(measurement.request.nominal.in_mm().x());
    out["y_mm"].push_back(measurement.request.nominal.in_mm().y());
    out["line"].push_back(measurement.request.line);
  }
  out["programmed_mm"] = plan.programmed.in_mm();
  out["within_series_mm"] = plan.within_series_length.in_mm();
  out["within_series"] = plan.within_series;
  out["free_mm"] = plan.free_length.in_mm();
  out["free"] = plan.free;
  out["exact"] = plan.is_exact;
  return out;
}

std::string_view model_rule(const Plan& plan) {
  if (plan.bends_panel) return "smooth";
  if (plan.chooses_model) return "auto";
  return plan.fixes_model ? "fixed" : "manual";
}

}  // namespace

Json plan_facts(const Plan& plan, const Survey& survey, const PlanOrigin& origin) {
  Json out = facts::envelope("plan", kPlanVersion);
  out["program"] = origin.program;
  out["machine"] = origin.machine;
  out["places"] = plan.n_places;
  out["has_routs"] = plan.has_routs;
  out["uncorrected"] = plan.n_uncorrected;
  out["own_target"] = plan.n_own_target;
  out["targets"] = plan.n_targets;
  out["base_series"] = plan.n_base;
  out["nested_series"] = plan.n_nested;
  out["like_worst"] = plan.n_like_worst;
  constexpr double kSquareUmPerMm = 1e6;
  const MachineUncertainty& machine = plan.machine;
  const double at_target_um = 1e3 * std::sqrt(machine.of_target_mm2()(0, 0));
  out["noise"] = {
      {"picture_um", plan.picture_sigma.in_um()},
      {"target_um", std::hypot(plan.picture_sigma.in_um(), at_target_um)},
      {"source", plan.sigma_source},
      {"recorded", plan.is_recorded},
      {"assumed", plan.is_assumed},
      {"stage_um", machine.stage_repeatability.in_um()},
      {"table_um", machine.table_residual.in_um()},
      {"hole_um2",
       facts::covariance(kSquareUmPerMm * (machine.shared_mm2() + machine.of_hole_mm2()))}};
  out["noticed_share"] = kNoticedShare;
  out["model_rule"] = model_rule(plan);
  for (const PanelModel one : kPlannedModels) {
    out["jacobians"][std::string(name(one))] = matrix(internal::drawn_jacobian(one));
  }
  out["series"] = Json::array();
  for (const SeriesPlan& series : plan.series) out["series"].push_back(series_facts(plan, series));
  out["visits"] = visits(plan.visits, survey);
  out["provenance"] = Json::array();
  for (const auto& [key, value] : origin.provenance) out["provenance"].push_back({key, value});
  return out;
}

}  // namespace panelcal::plan
