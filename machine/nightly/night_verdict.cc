// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/night_verdict.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "calib/base/clock.h"
#include "machine/nightly/checks/warm_up.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace panelcal {
namespace {

std::string title(const NightStep& step) {
  return step.kind + " " + step.subject;
}

NightOutcome outcome_of(const NightRecord& record) {
  const auto is = [](NightState state) {
    return [state](const NightStep& step) { return step.state == state; };
  };
  const std::vector<NightStep>& steps = record.steps;
  if (std::ranges::any_of(steps, is(NightState::Failed)) ||
      std::ranges::any_of(steps, is(NightState::NotReached))) {
    return NightOutcome::Failed;
  }
  const bool is_good = std::ranges::all_of(record.checks, &SelfTestCheck::passed) &&
                       std::ranges::none_of(steps, is(NightState::KeptOld)) &&
                       std::ranges::none_of(steps, is(NightState::Held));
  return is_good ? NightOutcome::AllInstalled : NightOutcome::Refused;
}

bool forbids(const NightStep& step) {
  switch (step.state) {
    case NightState::Held:
    case NightState::Failed:
    case NightState::NotReached:
      return true;
    case NightState::WouldRun:
      // Nothing in force, or nothing that says that it still is right.
      if (!step.forecast || step.forecast->answer == DrillAnswer::NotEnoughHistory) return true;
      break;
    case NightState::Installed:
    case NightState::KeptOld:
      break;
  }
  return step.forecast && step.forecast->answer == DrillAnswer::No;
}

/// Reason why not, in the words of the first that forbids it.
std::string why_not(const NightRecord& record) {
  for (const NightStep& step : record.steps) {
    if (!forbids(step)) continue;
    const bool is_judged =
        step.state != NightState::Installed && step.state != NightState::WouldRun;
    return title(step) + ": " + (is_judged ? step.summary : step.forecast_text);
  }
  for (const SelfTestCheck& check : record.checks) {
    if (!check.passed) return check.text;
  }
  return "nothing is calibrated";
}

std::string verdict_words(const NightRecord& record) {
  if (!record.may_drill) return "do not drill: " + why_not(record);
  std::string words = record.drill_until
                          ? fmt::format("drill, until {}", iso_8601(*record.drill_until))
                          : std::string("drill");
  const auto is_vague = [](const NightStep& s) {
    return s.forecast && s.forecast->answer == DrillAnswer::NotEnoughHistory;
  };
  if (std::ranges::any_of(record.steps, is_vague)) {
    words += ", until the next night: there are too few nights yet for a forecast";
  }
  if (record.warm_up && record.warm_up->is_warm && record.warm_up->fit->is_seen) {
    constexpr double kMinute_s = 60;
    words += fmt::format("; after a cold start warm up for {:.0f} min first",
                         std::ceil(record.warm_up->fit->wait.in_s() / kMinute_s));
  }
  for (const NightStep& step : record.steps) {
    if (step.state == NightState::KeptOld)
      words += fmt::format("; {}: {}", title(step), step.summary);
  }
  for (const SelfTestCheck& check : record.checks) {
    if (!check.passed) words += "; " + check.text;
  }
  for (const NightStep& step : record.steps) {
    for (const std::string& alarm : step.alarms) {
      // The summary names what refused the result.
      if (step.state == NightState::Installed) words += fmt::format("; {}: {}", title(step), alarm);
    }
  }
  return words;
}

}  // namespace

void fill_verdict(NightRecord& record) {
  record.outcome = outcome_of(record);
  record.may_drill = record.outcome != NightOutcome::Failed && !record.steps.empty() &&
                     std::ranges::none_of(record.steps, forbids);
  record.drill_until.reset();
  for (const NightStep& step : record.steps) {
    if (!record.may_drill || !step.forecast || step.forecast->answer != DrillAnswer::Until)
      continue;
    const std::chrono::sys_seconds until = step.forecast->until;
    record.drill_until = record.drill_until ? std::min(*record.drill_until, until) : until;
  }
  record.verdict = verdict_words(record);
}

LedgerDraft night_draft(const NightRecord& record, const std::string& machine) {
  LedgerDraft draft;
  draft.record.key = {machine, LedgerKind::Night, "night"};
  draft.record.reason = record.verdict.substr(0, kMaxLedgerTextBytes);
  draft.record.asked_by = record.asked_by;
  draft.record.software = record.software;
  draft.record.temperature_degC = record.temperature_c;
  nlohmann::ordered_json steps = nlohmann::ordered_json::array();
  for (const NightStep& step : record.steps) {
    nlohmann::ordered_json out = {{"kind", step.kind},
                                  {"subject", step.subject},
                                  {"state", name(step.state)},
                                  {"summary", step.summary}};
    if (step.ledger_id) out["entry"] = *step.ledger_id;
    if (step.in_force_id) out["in_force"] = *step.in_force_id;
    steps.push_back(std::move(out));
  }
  nlohmann::ordered_json checks = nlohmann::ordered_json::array();
  for (const SelfTestCheck& check : record.checks) {
    checks.push_back({{"name", check.name}, {"passed", check.passed}, {"text", check.text}});
  }
  nlohmann::ordered_json document = {{"kind", "night"},
                                     {"version", 1},
                                     {"night", record.night},
                                     {"started", iso_8601(record.started)},
                                     {"exit_code", exit_code(record)},
                                     {"may_drill", record.may_drill},
                                     {"verdict", record.verdict},
                                     {"steps", std::move(steps)},
                                     {"checks", std::move(checks)},
                                     {"notes", record.notes}};
  if (record.warm_up) {
    document["warm_up"] = nlohmann::ordered_json::parse(warm_up_json(*record.warm_up));
  }
  // Text that is no UTF-8 must not throw.
  draft.result = document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  return draft;
}

}  // namespace panelcal
