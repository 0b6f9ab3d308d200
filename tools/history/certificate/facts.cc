// SPDX-License-Identifier: Apache-2.0
#include "tools/history/certificate/facts.h"

#include <cmath>

#include "calib/base/clock.h"

namespace panelcal::history {
namespace {

using facts::Json;
using facts::number;

Json both_um(const std::array<double, 2>& both_mm) {
  return {number(1e3 * both_mm[0]), number(1e3 * both_mm[1])};
}

/// In the unit of the sigma, times a factor.
Json scatter_facts(const Scatter& scatter, double factor) {
  const std::array<double, 2> interval = scatter.interval();
  return {{"sigma", number(factor * scatter.sigma())},
          {"degrees_of_freedom", number(scatter.degrees_of_freedom)},
          {"low", number(factor * interval[0])},
          {"high", number(factor * interval[1])}};
}

Json repeatability_facts(const std::vector<Repeatability>& all) {
  Json out = Json::array();
  for (const Repeatability& one : all) {
    const bool is_length = one.unit == "mm";
    Json row = {{"subject", one.subject},
                {"name", one.name},
                {"unit", is_length ? "um" : one.unit},
                {"nights", one.n_nights}};
    row.update(scatter_facts(one.scatter, is_length ? 1e3 : 1));
    out.push_back(std::move(row));
  }
  return out;
}

Json gauge_facts(const GaugeStudy& gauge) {
  return {{"repeatability_um", scatter_facts(gauge.repeatability, 1e3)},
          {"over_nights_um", scatter_facts(gauge.over_nights, 1e3)},
          {"within_um", number(1e3 * std::sqrt(gauge.within_variance))},
          {"reproducibility_um", number(1e3 * std::sqrt(gauge.reproducibility_variance()))},
          {"both_um", scatter_facts(gauge.both(), 1e3)},
          {"percent_of_tolerance", number(gauge.percent_of_tolerance)}};
}

Json certified_budget_facts(const UncertaintyBudget& budget) {
  Json rows = Json::array();
  for (const BudgetRow& row : budget.rows) {
    rows.push_back({{"source", row.source},
                    {"type", std::string(1, row.type)},
                    {"sigma_um", both_um(row.sigma_mm)},
                    {"degrees_of_freedom", number(row.degrees_of_freedom)},
                    {"origin", row.origin}});
  }
  const auto combined = budget.combined_mm();
  const auto degrees = budget.degrees_of_freedom();
  const auto factor = budget.coverage_factor();
  return {{"rows", std::move(rows)},
          {"missing", budget.missing},
          {"combined_um", both_um(combined)},
          {"degrees_of_freedom", {number(degrees[0]), number(degrees[1])}},
          {"coverage", kCoverage},
          {"coverage_factor", {number(factor[0]), number(factor[1])}},
          {"expanded_um", both_um({factor[0] * combined[0], factor[1] * combined[1]})}};
}

Json spindle_facts(const SpindleCertificate& spindle) {
  Json nights = Json::array();
  for (const CertifiedNight& night : spindle.nights) {
    nights.push_back({{"entry", night.entry},
                      {"time", iso_8601(night.time)},
                      {"asked_by", night.asked_by},
                      {"offset_mm", {number(night.value_mm[0]), number(night.value_mm[1])}},
                      {"sigma_um", both_um(night.sigma_mm)}});
  }
  const auto entry = [](const std::optional<std::int64_t>& id) { return id ? Json(*id) : Json(); };
  return {{"subject", spindle.subject},
          {"in_force", entry(spindle.in_force)},
          {"fresh_start", entry(spindle.fresh_start)},
          {"nights", std::move(nights)},
          {"refused", spindle.n_refused},
          {"rolled_back", spindle.n_rolled_back},
          {"gauge", spindle.gauge ? gauge_facts(*spindle.gauge) : Json()},
          {"budget", spindle.budget ? certified_budget_facts(*spindle.budget) : Json()}};
}

Json stage_facts(const std::vector<StageFigure>& stage) {
  Json out = Json::array();
  for (const StageFigure& figure : stage) {
    out.push_back({{"axis", figure.axis},
                   {"quantity", figure.quantity},
                   {"value", number(figure.value)},
                   {"sigma", number(figure.sigma)},
                   {"unit", figure.unit},
                   {"nights", figure.n_nights},
                   {"origin", figure.origin}});
  }
  return out;
}

Json plate_facts(const PlateTrace& trace) {
  const CalibrationPlate& plate = trace.plate;
  Json out = {{"file", plate.file.string()},
              {"sha256", trace.sha256},
              {"entry", trace.entry},
              {"name", plate.name},
              {"columns", plate.columns},
              {"rows", plate.rows},
              {"pitch_mm", plate.pitch.in_mm()},
              {"certified", plate.is_certified},
              {"certificate", plate.certificate},
              {"expanded_uncertainty_um", Json()},
              {"coverage_factor", Json()}};
  if (plate.expanded_uncertainty) {
    out["expanded_uncertainty_um"] = plate.expanded_uncertainty->in_um();
    out["coverage_factor"] = plate.coverage_factor;
  }
  return out;
}

}  // namespace

Json certificate_facts(const Certificate& certificate) {
  Json spindles = Json::array();
  for (const SpindleCertificate& spindle : certificate.spindles) {
    spindles.push_back(spindle_facts(spindle));
  }
  Json lacking = Json::array();
  for (const NotMeasured& one : certificate.not_measured) {
    lacking.push_back({{"what", one.what}, {"why", one.why}});
  }
  Json tolerance;
  if (certificate.tolerance_mm) {
    tolerance = {{"limit_um", number(1e3 * *certificate.tolerance_mm)},
                 {"origin", certificate.tolerance_origin}};
  }
  return {{"machine", certificate.machine},
          {"tolerance", std::move(tolerance)},
          {"repeatability", repeatability_facts(certificate.repeatability)},
          {"spindles", std::move(spindles)},
          {"table_entry", certificate.table_entry ? Json(*certificate.table_entry) : Json()},
          {"stage", stage_facts(certificate.stage)},
          {"plate", certificate.plate ? plate_facts(*certificate.plate) : Json()},
          {"not_measured", std::move(lacking)}};
}

}  // namespace panelcal::history
