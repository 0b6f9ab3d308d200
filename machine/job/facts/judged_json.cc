// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "machine/job/facts/sections.h"
#include "machine/job/summary/depth_summary.h"
#include "machine/job/summary/verdict_summary.h"

namespace panelcal::facts {
namespace {

/// Heights of a map along the longer side.
constexpr int kDepthNodes = 60;

std::string_view decision_word(JobDecision decision) {
  switch (decision) {
    case JobDecision::Drill:
      return "drill";
    case JobDecision::DrillWithWarning:
      return "warned";
    case JobDecision::Hold:
      return "hold";
    case JobDecision::NotJudged:
      break;
  }
  return "not_judged";
}

template <class Place>
Json worst_json(const Place& worst) {
  return {{"line", worst.line},
          {"file", worst.file},
          {"board", board_json(worst.path)},
          {"nominal_mm", point(worst.nominal.in_mm())}};
}

Json um(const std::optional<Length>& length) {
  return length ? number(length->in_um()) : Json();
}

Json radial_json(const RadialFigures& figures, const std::optional<Length>& tolerance) {
  return {{"mean_um", number(figures.mean().in_um())},
          {"mean_plus_3_sigma_um", number(figures.mean_plus_3_sigma().in_um())},
          {"cpk", tolerance ? number(figures.cpk(*tolerance)) : Json()}};
}

Json actual_json(const ToolRow& row) {
  if (row.actual == nullptr) return {};
  Json out = radial_json(row.actual->radial(), row.predicted->tolerance);
  out["max_um"] = number(row.actual->max().in_um());
  return out;
}

Json tool_json(const ToolRow& row, const RiskBasis& basis) {
  const JobVerdict::ToolFigures& tool = *row.predicted;
  Json predicted = radial_json(tool.predicted, tool.tolerance);
  if (!basis.tells_risk()) predicted["cpk"] = Json();
  return {{"tool", row.tool},
          {"n_places", tool.predicted.n + tool.n_uncorrected},
          {"n_judged", tool.n_judged},
          {"n_warned", tool.n_warned},
          {"n_held", tool.n_held},
          {"tolerance_um", um(tool.tolerance)},
          {"largest_sigma_um", number(tool.largest_sigma.in_um())},
          {"largest_radius_95_um", number(tool.largest_radius_95.in_um())},
          {"predicted", predicted},
          {"actual", actual_json(row)},
          {"risk", tool.n_judged > 0 && basis.tells_risk() ? number(tool.stated_risk) : Json()},
          {"worst", tool.n_judged > 0 ? worst_json(tool.worst) : Json()}};
}

Json decades_json(const JobVerdict& verdict) {
  Json rows = Json::array();
  for (std::size_t i = 0; i < JobVerdict::kDecades; ++i) {
    const JobVerdict::Decade& decade = verdict.decades()[i];
    rows.push_back({{"below_exponent", JobVerdict::kLowestDecade + static_cast<int>(i)},
                    {"n_good", decade.n_good},
                    {"n_warned", decade.n_warned},
                    {"n_held", decade.n_held}});
  }
  return rows;
}

std::string_view basis_word(RiskBasis::Kind kind) {
  if (kind == RiskBasis::Kind::Stated) return "stated";
  return kind == RiskBasis::Kind::Bounded ? "bounded" : "unknown";
}

Json depth_tool_json(int number_of_tool, const DepthVerdict::ToolFigures& tool) {
  const bool is_judged = tool.places.n_judged > 0;
  Json worst;
  if (is_judged) {
    worst = worst_json(tool.worst);
    worst["mean_um"] = number(tool.worst.error.mean.in_um());
    worst["sigma_um"] = number(tool.worst.error.sigma.in_um());
    worst["axis"] = tool.worst.error.axis ? Json(*tool.worst.error.axis) : Json();
    worst["risk_too_shallow"] = number(tool.worst.risk.too_shallow);
    worst["risk_too_deep"] = number(tool.worst.risk.too_deep);
  }
  return {{"tool", number_of_tool},
          {"n_depths", tool.places.n_judged + tool.places.n_unjudged},
          {"n_judged", tool.places.n_judged},
          {"n_warned", tool.places.n_warned},
          {"n_held", tool.places.n_held},
          {"too_shallow_um", um(tool.tolerance.too_shallow)},
          {"too_deep_um", um(tool.tolerance.too_deep)},
          {"largest_mean_um", is_judged ? number(tool.largest_mean.in_um()) : Json()},
          {"largest_sigma_um", is_judged ? number(tool.largest_sigma.in_um()) : Json()},
          {"expected_too_shallow", number(tool.expected_too_shallow)},
          {"expected_too_deep", number(tool.expected_too_deep)},
          {"worst", worst}};
}

/// Heights on a grid over the probes' hull, row by row from the lowest y; null where the map knows
/// none.
Json height_map_json(const HeightMap& map) {
  Json hull = Json::array();
  Eigen::Vector2d low_mm = map.hull().front().in_mm();
  Eigen::Vector2d high_mm = low_mm;
  for (const auto& corner : map.hull()) {
    hull.push_back(point(corner.in_mm()));
    low_mm = low_mm.cwiseMin(corner.in_mm());
    high_mm = high_mm.cwiseMax(corner.in_mm());
  }
  const double step_mm = std::max(1e-6, (high_mm - low_mm).maxCoeff() / (kDepthNodes - 1));
  const Eigen::Array2i n = ((high_mm - low_mm) / step_mm).array().ceil().cast<int>() + 1;
  Json heights = Json::array();
  Json sigmas = Json::array();
  for (int row = 0; row < n.y(); ++row) {
    for (int column = 0; column < n.x(); ++column) {
      const Eigen::Vector2d at_mm = low_mm + step_mm * Eigen::Vector2d(column, row);
      const auto height = map.height_at(position_mm<frame::Nominal>(at_mm));
      heights.push_back(height ? number(std::round(height->height.in_mm() * 1e6) / 1e6) : Json());
      sigmas.push_back(height ? number(std::round(height->sigma.in_um() * 1e3) / 1e3) : Json());
    }
  }
  return {{"hull_mm", hull},
          {"low_mm", point(low_mm)},
          {"step_mm", number(step_mm)},
          {"n_x", n.x()},
          {"n_y", n.y()},
          {"height_mm", heights},
          {"sigma_um", sigmas}};
}

Json height_maps_json(const DepthVerdict& verdict) {
  Json rows = Json::array();
  const auto maps = verdict.errors().maps();
  for (std::size_t axis = 0; axis < maps.size(); ++axis) {
    if (!maps[axis]) continue;
    const auto zones = maps[axis]->zones();
    for (std::size_t i = 0; i < maps[axis]->maps().size(); ++i) {
      Json row = {{"axis", axis}, {"zone", zones.empty() ? Json() : Json(zones[i].name)}};
      row.update(height_map_json(maps[axis]->map(i)));
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

Json cov_um2(const Eigen::Matrix2d& cov_mm2) {
  return covariance(cov_mm2 * 1e6);
}

Json errors_json(const TruthComparison::Errors& errors) {
  return {{"n", errors.corrected.n},
          {"uncorrected_max_um", number(errors.uncorrected.max().in_um())},
          {"uncorrected_rms_um", number(errors.uncorrected.rms().in_um())},
          {"corrected_max_um", number(errors.corrected.max().in_um())},
          {"corrected_rms_um", number(errors.corrected.rms().in_um())}};
}

}  // namespace

Json tolerance_json(const JobFactsInput& input) {
  if (input.verdict == nullptr) return {};
  const JobVerdict& verdict = *input.verdict;
  const RiskBasis& basis = verdict.basis();
  Json tools = Json::array();
  for (const ToolRow& row : tool_rows(verdict, input.truth)) tools.push_back(tool_json(row, basis));
  const JobVerdict::ToolFigures* worst = verdict.worst_tool();
  return {
      {"decision", decision_word(verdict.decision())},
      {"sentence", verdict.sentence()},
      {"basis", basis_word(basis.kind)},
      {"basis_words", basis.words},
      {"is_of_fit_only", basis.is_of_fit_only},
      {"warn_above", number(verdict.tolerances().warn_above)},
      {"hold_above", number(verdict.tolerances().hold_above)},
      {"n_judged", verdict.n_judged()},
      {"n_warned", verdict.n_warned()},
      {"n_held", verdict.n_held()},
      {"expected_broken",
       basis.kind == RiskBasis::Kind::Stated ? number(verdict.expected_broken()) : Json()},
      {"worst_risk",
       worst != nullptr && basis.tells_risk()
           ? number(basis.kind == RiskBasis::Kind::Stated ? worst->worst.risk : worst->stated_risk)
           : Json()},
      {"tools", tools},
      {"decades", basis.kind == RiskBasis::Kind::Stated ? decades_json(verdict) : Json::array()}};
}

Json depth_json(const DepthVerdict* verdict) {
  if (verdict == nullptr) return {};
  Json tools = Json::array();
  for (const auto& [tool, figures] : verdict->by_tool()) {
    tools.push_back(depth_tool_json(tool, figures));
  }
  const JudgedPlaces places = verdict->places();
  const DepthVerdict::ToolFigures* worst = verdict->worst_tool();
  return {{"decision", decision_word(verdict->decision())},
          {"sentence", verdict->sentence()},
          {"warn_above", number(verdict->tolerances().warn_above)},
          {"hold_above", number(verdict->tolerances().hold_above)},
          {"n_judged", places.n_judged},
          {"expected_broken", number(places.expected_broken)},
          {"worst_risk", worst != nullptr ? number(worst->worst.risk.either()) : Json()},
          {"machine_sigma_um", number(verdict->errors().depth_sigma().in_um())},
          {"surface_lines", surface_lines(*verdict)},
          {"tools", tools},
          {"maps", height_maps_json(*verdict)}};
}

Json budget_json(const std::optional<HoleBudget>& hole) {
  if (!hole || hole->budget.empty()) return {};
  Json terms = Json::array();
  for (const BudgetTerm& term : hole->budget) {
    terms.push_back({{"source", term.source},
                     {"common_to", name(term.shared)},
                     {"counts", term.counts()},
                     {"covariance_um2", cov_um2(term.cov_mm2)}});
  }
  Json out = worst_json(*hole);
  out["tool"] = hole->tool;
  out["is_likeliest_to_break"] = hole->is_likeliest_to_break;
  out["risk"] = number(hole->risk);
  out["covariance_um2"] = cov_um2(total_mm2(hole->budget));
  out["terms"] = terms;
  return out;
}

Json truth_json(const TruthComparison* truth) {
  if (truth == nullptr) return {};
  Json tools = Json::array();
  for (const auto& [tool, errors] : truth->by_tool()) {
    Json row = {{"tool", tool}};
    row.update(errors_json(errors));
    tools.push_back(std::move(row));
  }
  const double square = truth->mean_normalized_square();
  return {{"tools", tools},
          {"all", errors_json(truth->all())},
          {"mean_normalized_square", square > 0 ? number(square) : Json()}};
}

}  // namespace panelcal::facts
