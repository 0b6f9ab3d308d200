// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/place_text.h"
#include "tools/nightly/report.h"
#include <fmt/format.h>

namespace panelcal::nightly {
namespace {

std::string joined(const std::vector<std::string>& texts) {
  return fmt::format("{}", fmt::join(texts, "; "));
}

std::string step_text(const NightStep& step, const std::string& verdict) {
  // A fact of the verdict is not repeated.
  const bool is_said = step.summary.empty() || verdict.find(step.summary) != std::string::npos;
  std::string text = fmt::format(
      "{} {}: {}", step.kind, step.subject, is_said ? std::string(name(step.state)) : step.summary);
  return step.since_when.empty() ? text : text + "; " + step.since_when;
}

std::string steps_line(const NightRecord& record) {
  std::vector<std::string> texts;
  for (const NightStep& step : record.steps) texts.push_back(step_text(step, record.verdict));
  return joined(texts);
}

std::string checks_line(const NightRecord& record) {
  if (record.checks.empty()) return {};
  std::vector<std::string> failed;
  for (const SelfTestCheck& check : record.checks) {
    if (!check.passed) failed.push_back(check.name + ": " + check.text);
  }
  const auto n = static_cast<std::int64_t>(record.checks.size());
  if (failed.empty()) return "self-test: " + report::counted(n, "check") + " passed";
  return fmt::format(
      "self-test: {} of {} failed: {}", failed.size(), report::counted(n, "check"), joined(failed));
}

}  // namespace

std::string night_text(const NightRecord& record) {
  const std::string what = record.is_dry_run ? ", dry run: " : ": ";
  const std::string steps = steps_line(record);
  std::string text;
  for (const std::string& line : {
           fmt::format("{}, night of {}{}{}", record.machine, record.night, what, record.verdict),
           steps,
           record.changes.empty() ? std::string() : "since last week: " + joined(record.changes),
           checks_line(record),
           record.notes.empty() ? std::string() : "note: " + joined(record.notes),
       }) {
    if (!line.empty()) text += report::one_line(line) + "\n";
  }
  return text;
}

}  // namespace panelcal::nightly
