// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>

#include "calib/base/statistics/chi_square.h"
#include "machine/job/facts/sections.h"
#include "machine/job/facts/survey_facts.h"

namespace panelcal::facts {
namespace {

/// What facts call a target: its number in the order of the measuring.
Json seq_of(const Survey& survey, std::size_t i) {
  return i < survey.measurements.size() ? Json(survey.measurements[i].request.seq) : Json();
}

Json seqs_of(const Survey& survey, const std::vector<std::size_t>& indices) {
  Json out = Json::array();
  for (const std::size_t i : indices) out.push_back(seq_of(survey, i));
  return out;
}

/// Of a point of the fit.
Json seq_of_point(const Survey& survey, const SeriesResult& series, std::optional<std::size_t> k) {
  return k && *k < series.points.size() ? seq_of(survey, series.points[*k]) : Json();
}

Json uncertain_json(const Uncertain& value) {
  return {{"value", number(value.value)}, {"sigma", number(value.sigma)}};
}

Json chi_square_json(double chi_square, int degrees_of_freedom) {
  const bool is_checked = degrees_of_freedom > 0;
  return {
      {"value", number(chi_square)},
      {"degrees_of_freedom", degrees_of_freedom},
      {"p", is_checked ? number(chi_square_exceedance(chi_square, degrees_of_freedom)) : Json()},
      {"means", chi_square_meaning(chi_square, degrees_of_freedom)}};
}

Json map_json(const PanelFitSummary& fit) {
  Json cov = Json::array();
  for (int row = 0; row < 6; ++row) {
    Json cells = Json::array();
    for (int column = 0; column < 6; ++column) cells.push_back(number(fit.cov(row, column)));
    cov.push_back(std::move(cells));
  }
  return {{"linear", Json::array({point(fit.linear.row(0)), point(fit.linear.row(1))})},
          {"translation_mm", point(fit.translation_mm)},
          {"covariance", cov}};
}

Json fit_json(const SeriesResult& series) {
  if (!series.is_fitted()) return {};
  return {{"is_mirrored", series.is_mirrored},
          {"rotation_rad", uncertain_json(series.rotation_rad)},
          {"stretch_x_ppm", uncertain_json(series.stretch_x_ppm)},
          {"stretch_y_ppm", uncertain_json(series.stretch_y_ppm)},
          {"shear_ppm", uncertain_json(series.shear_ppm)},
          {"centroid_mm", point(series.centroid_mm)},
          {"shift_x_mm", uncertain_json(series.shift_x_mm)},
          {"shift_y_mm", uncertain_json(series.shift_y_mm)},
          {"chi_square", chi_square_json(series.chi_square, series.degrees_of_freedom)},
          {"misfit_ratio", number(series.misfit_ratio)},
          {"layer_spread_um", series.layer_spread ? number(series.layer_spread->in_um()) : Json()},
          {"map", map_json(series)}};
}

Json gates_json(const Survey& survey, const SeriesResult& series) {
  Json rows = Json::array();
  for (const GateVerdict& gate : series.gates) {
    rows.push_back({{"gate", gate.gate},
                    {"value", number(gate.value)},
                    {"limit", number(gate.limit)},
                    {"unit", gate.unit},
                    {"is_accepted", gate.accepted},
                    {"target", seq_of_point(survey, series, gate.i_target)}});
  }
  return rows;
}

Json models_json(const SeriesResult& series) {
  Json rows = Json::array();
  for (const ModelScore& score : series.compared) {
    rows.push_back(
        {{"name", name(score)},
         {"parameters", number(score.parameters)},
         {"chi_square", number(score.chi_square)},
         {"criterion", number(score.criterion)},
         {"left_out_um", score.left_out_mm ? number(*score.left_out_mm * 1e3) : Json()},
         {"is_eligible", score.is_eligible || score.is_smooth},
         {"is_chosen", score.is_chosen},
         {"is_in_force", score.is_smooth == series.is_smooth() && score.model == series.model}});
  }
  return rows;
}

/// The panel is bent, and its fit is not.
bool lacks_smooth_model(const SeriesResult& series) {
  return !series.is_smooth() && recommended_smooth(series.compared) != nullptr;
}

Json fault_json(const Survey& survey, const SeriesResult& series) {
  if (!series.fault) return {};
  const SeriesFault& fault = *series.fault;
  Json causes = Json::array();
  for (const SeriesFault::Suspicion& suspicion : fault.suspicions) {
    causes.push_back({{"cause", name(suspicion.cause)},
                      {"target", seq_of_point(survey, series, suspicion.i_point)},
                      {"text", suspicion.text},
                      {"probability", number(suspicion.probability)}});
  }
  return {{"p", number(fault.p_value)},
          {"false_alarm", number(fault.false_alarm)},
          {"degrees_of_freedom", fault.degrees_of_freedom},
          {"is_named", fault.is_named()},
          {"is_outlier_certain", fault.i_outlier.has_value()},
          {"weighs_taken_pads", fault.weighs_taken_pads},
          {"is_resolved", fault.is_resolved},
          {"text", fault.text()},
          {"causes", causes}};
}

Json assignment_json(const SeriesResult& series) {
  if (!series.assignment) return {};
  return {{"is_certain", series.assignment->is_certain()},
          {"n_candidates", series.assignment->n_candidates},
          {"text", series.assignment->text()}};
}

/// Of each target the largest error that the others would not show.
Json reliability_json(const Survey& survey, const SeriesResult& series) {
  if (!series.reliability) return {};
  std::map<std::size_t, const UnseenError*> largest;
  for (const UnseenError& unseen : series.reliability->unseen) {
    const UnseenError*& known = largest[unseen.i_target];
    if (known == nullptr || unseen.error_mm.norm() > known->error_mm.norm()) known = &unseen;
  }
  Json rows = Json::array();
  for (const auto& [i_target, unseen] : largest) {
    rows.push_back({{"target", seq_of_point(survey, series, i_target)},
                    {"error_um", point(unseen->error_mm * 1e3)},
                    {"is_unlimited", unseen->is_unlimited}});
  }
  return {{"can_be_stated", series.reliability->can_be_stated()},
          {"noise_ratio", number(std::sqrt(series.reliability->noise_ratio2))},
          {"unseen", rows}};
}

}  // namespace

Json series_json(const Survey& survey) {
  Json rows = Json::array();
  for (const SeriesResult& series : survey.series) {
    rows.push_back({{"name", series_name(series)},
                    {"level", series.level == CorrectionLevel::Base ? "panel" : "board"},
                    {"is_on_panel_fit", series.base_series.has_value()},
                    {"line", series.line},
                    {"board", board_json(series.path)},
                    {"is_accepted", series.is_accepted()},
                    {"targets", seqs_of(survey, series.measurements)},
                    {"points", seqs_of(survey, series.points)},
                    {"left_out", seqs_of(survey, series.dropped)},
                    {"model", series.is_smooth() ? "smooth" : std::string(name(series.model))},
                    {"model_text", series.model_text()},
                    {"prescribed", name(series.prescribed)},
                    {"is_chosen_by_targets", series.chose_model},
                    {"lacks_smooth_model", lacks_smooth_model(series)},
                    {"fit", fit_json(series)},
                    {"limits", gates_text(series.limits)},
                    {"gates", gates_json(survey, series)},
                    {"models", models_json(series)},
                    {"fault", fault_json(survey, series)},
                    {"assignment", assignment_json(series)},
                    {"reliability", reliability_json(survey, series)}});
    if (series.is_left_out) rows.back()["is_left_out"] = true;
  }
  return rows;
}

Json pooled_chi_square_json(const Survey& survey) {
  const PooledChiSquare pooled = pooled_chi_square(survey);
  if (pooled.degrees_of_freedom == 0) return {};
  return chi_square_json(pooled.chi_square, pooled.degrees_of_freedom);
}

}  // namespace panelcal::facts
