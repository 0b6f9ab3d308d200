// SPDX-License-Identifier: Apache-2.0
#include "calib/base/json/facts.h"

#include "calib/base/clock.h"
#include "machine/nightly/checks/warm_up.h"
#include "tools/nightly/report.h"
#include "tools/surface/made_facts.h"

namespace panelcal::nightly {
namespace {

using facts::Json;
using facts::number;

/// With the key "facts" the object is the document of facts; the version grows with its schema.
constexpr int kNightVersion = 1;

Json time(std::chrono::sys_seconds value) {
  return iso_8601(value);
}

Json id(const std::optional<std::int64_t>& value) {
  return value ? Json(*value) : Json();
}

template <class Range, class Function>
Json json_list(const Range& range, Function function) {
  Json out = Json::array();
  for (const auto& item : range) out.push_back(function(item));
  return out;
}

Json numbers(const std::vector<double>& values) {
  return json_list(values, [](double value) { return number(value); });
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
          {"value", number(c.value)},
          {"limit", number(c.limit)},
          {"unit", c.unit}};
}

Json axis(const NightAxis& a) {
  return {{"name", a.name},
          {"unit", a.unit},
          {"old", number(a.old_value)},
          {"new", number(a.new_value)},
          {"sigma", number(a.new_sigma)},
          {"expected", number(a.expected)},
          {"expected_sigma", number(a.expected_sigma)}};
}

Json decision(const NightDecision& d) {
  const Json gates = json_list(d.gates, [](const NightGate& gate) {
    return Json{{"name", gate.name}, {"passed", gate.passed}, {"text", gate.text}};
  });
  return {{"verdict", name(d.verdict)}, {"gates", gates}, {"reasons", d.reasons}};
}

Json quality(const NightQuality& q) {
  return {{"name", q.name},
          {"unit", q.unit},
          {"value", number(q.value)},
          {"usual", number(q.usual)},
          {"alarm", q.is_alarm},
          {"text", q.text}};
}

Json forecast(const NightStep& step) {
  Json out = {{"text", step.forecast_text}};
  if (!step.forecast) return out;
  const DrillForecast& f = *step.forecast;
  out["answer"] = outcome_word(f.answer);
  out["chance_now"] = number(f.chance_now);
  out["error"] = numbers({f.error.data(), f.error.data() + f.error.size()});
  out["now"] = time(f.now);
  out["until"] = f.answer == DrillAnswer::Until ? time(f.until) : Json();
  return out;
}

Json plot_point(const NightPlotPoint& p) {
  return {{"time", time(p.time)},
          {"value", numbers(p.value)},
          {"sigma", numbers(p.sigma)},
          {"refused", p.is_refused},
          {"fresh_start", p.is_fresh_start},
          {"alarm", p.is_alarm},
          {"in_force", numbers(p.in_force)},
          {"ledger_id", id(p.ledger_id)},
          {"asked_by", p.asked_by},
          {"by_hand", p.is_by_hand}};
}

Json hole(const NightHole& h) {
  return {{"place_mm", facts::point(h.place_mm)},
          {"residual_mm", facts::point(h.residual_mm)},
          {"outlier", h.is_outlier}};
}

/// As `panelcal surface fit` has a map.
Json surface_map(const StoredMap& probed) {
  const surface::MadeMap made = surface::made_map(
      {probed.points, ZonedMap(probed.map), probed.sources, probed.made_by}, {}, {}, {});
  return surface::made_facts(made, {});
}

Json step(const NightStep& s) {
  Json out = {{"kind", s.kind},
              {"subject", s.subject},
              {"state", name(s.state)},
              {"from_earlier_run", s.is_from_earlier_run},
              {"summary", s.summary},
              {"axes", json_list(s.axes, axis)},
              {"change", number(s.change)},
              {"change_sigma", number(s.change_sigma)},
              {"tolerance", number(s.tolerance)},
              {"decision", s.decision ? decision(*s.decision) : Json()},
              {"qualities", json_list(s.qualities, quality)},
              {"alarms", s.alarms},
              {"forecast", forecast(s)},
              {"since_when", s.since_when},
              {"series", json_list(s.series, plot_point)},
              {"holes", json_list(s.holes, hole)},
              {"surface", s.surface ? surface_map(*s.surface) : Json()},
              {"fit_report", s.fit_report},
              {"file", s.file.string()},
              {"ledger_id", id(s.ledger_id)},
              {"in_force_id", id(s.in_force_id)},
              {"problem", Json()}};
  if (s.problem) {
    out["problem"] = {{"code", info(s.problem->code).slug}, {"text", s.problem->text()}};
  }
  return out;
}

}  // namespace

facts::Json night_facts(const NightRecord& r, const Provenance& provenance) {
  Json out = facts::envelope("night", kNightVersion);
  out.update({{"machine", r.machine},
              {"night", r.night},
              {"may_drill", r.may_drill},
              {"drill_until", r.drill_until ? time(*r.drill_until) : Json()},
              {"verdict", r.verdict},
              {"outcome", outcome_word(r.outcome)},
              {"exit_code", exit_code(r)},
              {"dry_run", r.is_dry_run},
              {"resumed", r.is_resumed},
              {"started", time(r.started)},
              {"finished", time(r.finished)},
              {"software", r.software},
              {"asked_by", r.asked_by},
              {"temperature_c", number(r.temperature_c)},
              {"warmed_up_s", number(r.warmed_up.in_s())},
              {"changes", r.changes},
              {"notes", r.notes},
              {"checks", json_list(r.checks, check)},
              {"steps", json_list(r.steps, step)},
              {"config_file", r.config_file.string()},
              {"ledger_file", r.ledger_file.string()},
              {"ledger_head", {{"id", r.head.id}, {"hash", r.head.hash}}}});
  out["warm_up"] = r.warm_up ? Json::parse(warm_up_json(*r.warm_up)) : Json();
  out["provenance"] = Json::object();
  for (const auto& [key, value] : provenance) out["provenance"][key] = value;
  return out;
}

}  // namespace panelcal::nightly
