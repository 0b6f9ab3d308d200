// SPDX-License-Identifier: Apache-2.0
#include "calib/base/clock.h"
#include "machine/nightly/checks/warm_up.h"
#include "tools/nightly/report.h"
#include <nlohmann/json.hpp>

namespace panelcal::nightly {
namespace {

using Json = nlohmann::ordered_json;

Json optional_number(const std::optional<double>& value) {
  return value ? Json(*value) : Json();
}

Json vector(const Eigen::VectorXd& values) {
  Json out = Json::array();
  for (Eigen::Index i = 0; i < values.size(); ++i) out.push_back(values[i]);
  return out;
}

Json time(std::chrono::sys_seconds value) {
  return iso_8601(value);
}

std::string_view outcome_word(NightOutcome outcome) {
  switch (outcome) {
    case NightOutcome::AllInstalled:
      return "installed";
    case NightOutcome::Refused:
      return "refused";
    case NightOutcome::Failed:
      break;
  }
  return "failed";
}

std::string_view outcome_word(DrillAnswer answer) {
  switch (answer) {
    case DrillAnswer::NotEnoughHistory:
      return "not_enough_history";
    case DrillAnswer::No:
      return "no";
    case DrillAnswer::Until:
      return "until";
    case DrillAnswer::BeyondHorizon:
      break;
  }
  return "beyond_horizon";
}

Json check(const SelfTestCheck& c) {
  return {{"name", c.name},
          {"passed", c.passed},
          {"text", c.text},
          {"value", optional_number(c.value)},
          {"limit", optional_number(c.limit)},
          {"unit", c.unit}};
}

Json axis(const NightAxis& a) {
  return {{"name", a.name},
          {"unit", a.unit},
          {"old", optional_number(a.old_value)},
          {"new", optional_number(a.new_value)},
          {"sigma", optional_number(a.new_sigma)},
          {"expected", optional_number(a.expected)},
          {"expected_sigma", optional_number(a.expected_sigma)}};
}

Json decision(const NightDecision& d) {
  Json gates = Json::array();
  for (const NightGate& gate : d.gates) {
    gates.push_back({{"name", gate.name}, {"passed", gate.passed}, {"text", gate.text}});
  }
  return {{"verdict", std::string(name(d.verdict))}, {"gates", gates}, {"reasons", d.reasons}};
}

Json quality(const NightQuality& q) {
  return {{"name", q.name},
          {"unit", q.unit},
          {"value", q.value},
          {"usual", optional_number(q.usual)},
          {"alarm", q.is_alarm},
          {"text", q.text}};
}

Json forecast(const NightStep& step) {
  Json out = {{"text", step.forecast_text}};
  if (!step.forecast) return out;
  const DrillForecast& f = *step.forecast;
  const bool has_end = f.answer == DrillAnswer::Until;
  out["answer"] = std::string(outcome_word(f.answer));
  out["chance_now"] = f.chance_now;
  out["error"] = vector(f.error);
  out["now"] = time(f.now);
  out["until"] = has_end ? time(f.until) : Json();
  return out;
}

Json plot_point(const NightPlotPoint& p) {
  return {{"time", time(p.time)},
          {"value", p.value},
          {"sigma", p.sigma},
          {"refused", p.is_refused},
          {"fresh_start", p.is_fresh_start},
          {"alarm", p.is_alarm},
          {"in_force", p.in_force}};
}

Json hole(const NightHole& h) {
  return {{"place_mm", vector(h.place_mm)},
          {"residual_mm", vector(h.residual_mm)},
          {"outlier", h.is_outlier}};
}

Json problem(const Diagnostic& diagnostic) {
  return {{"code", std::string(info(diagnostic.code).slug)}, {"text", diagnostic.text()}};
}

template <class Range, class Function>
Json json_list(const Range& range, Function function) {
  Json out = Json::array();
  for (const auto& item : range) out.push_back(function(item));
  return out;
}

Json step(const NightStep& s) {
  Json out = {{"kind", s.kind},
              {"subject", s.subject},
              {"state", std::string(name(s.state))},
              {"from_earlier_run", s.is_from_earlier_run},
              {"summary", s.summary},
              {"axes", json_list(s.axes, axis)},
              {"change", optional_number(s.change)},
              {"change_sigma", optional_number(s.change_sigma)},
              {"decision", s.decision ? decision(*s.decision) : Json()},
              {"qualities", json_list(s.qualities, quality)},
              {"alarms", s.alarms},
              {"forecast", forecast(s)},
              {"since_when", s.since_when},
              {"series", json_list(s.series, plot_point)},
              {"holes", json_list(s.holes, hole)},
              {"fit_report", s.fit_report},
              {"file", s.file.string()}};
  out["ledger_id"] = s.ledger_id ? Json(*s.ledger_id) : Json();
  out["in_force_id"] = s.in_force_id ? Json(*s.in_force_id) : Json();
  out["problem"] = s.problem ? problem(*s.problem) : Json();
  return out;
}

}  // namespace

std::string night_json(const NightRecord& r, const Provenance& provenance) {
  Json out = {{"panelcal", "night"},
              {"version", 1},
              {"machine", r.machine},
              {"night", r.night},
              {"may_drill", r.may_drill},
              {"drill_until", r.drill_until ? time(*r.drill_until) : Json()},
              {"verdict", r.verdict},
              {"outcome", std::string(outcome_word(r.outcome))},
              {"exit_code", exit_code(r)},
              {"dry_run", r.is_dry_run},
              {"resumed", r.is_resumed},
              {"started", time(r.started)},
              {"finished", time(r.finished)},
              {"software", r.software},
              {"asked_by", r.asked_by},
              {"temperature_c", optional_number(r.temperature_c)},
              {"warmed_up_s", r.warmed_up.in_s()},
              {"changes", r.changes},
              {"notes", r.notes},
              {"checks", json_list(r.checks, check)},
              {"steps", json_list(r.steps, step)},
              {"config_file", r.config_file.string()},
              {"ledger_file", r.ledger_file.string()},
              {"ledger_head", {{"id", r.head.id}, {"hash", r.head.hash}}}};
  out["warm_up"] = r.warm_up ? Json::parse(warm_up_json(*r.warm_up)) : Json();
  out["provenance"] = Json::object();
  for (const auto& [key, value] : provenance) out["provenance"][key] = value;
  return out.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace panelcal::nightly
