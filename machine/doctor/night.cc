// SPDX-License-Identifier: Apache-2.0
// The night that comes, as a dry run foresees it.
#include <string>

#include "machine/devices/no_devices.h"
#include "machine/doctor/checks.h"
#include "machine/nightly/nightly.h"
#include <fmt/format.h>

namespace panelcal::doctor {
namespace {

void check_step(const NightStep& step, Findings& findings) {
  const std::string subject = fmt::format("tonight {} {}", step.kind, step.subject);
  // Of a step that has an obstacle a dry run says "would not be measured: ...".
  const bool would_run =
      step.state == NightState::WouldRun && !step.summary.starts_with("would not");
  if (!would_run) {
    return findings.fail(
        subject, step.summary, "panelcal nightly -m machine.toml --dry-run says more");
  }
  findings.ok(subject, step.summary);
  for (const std::string& alarm : step.alarms) {
    findings.warn(subject, alarm, "panelcal history plot shows it over the nights");
  }
  if (step.forecast && step.forecast->answer == DrillAnswer::No) {
    findings.warn(subject, step.forecast_text, "calibrate before the next job");
  }
}

}  // namespace

void check_night(const MachineConfig& config, const Examination& examination, Findings& findings) {
  NoDevices none;
  const Expected<NightRecord> night = run_nightly({.config = config,
                                                   .nightly = *config.nightly,
                                                   .devices = none.devices(),
                                                   .clock = examination.clock,
                                                   .software = examination.software,
                                                   .asked_by = examination.asked_by,
                                                   .is_dry_run = true});
  if (!night) {
    return findings.fail("tonight", "the night would not begin: " + night.error().text(), {});
  }
  for (const SelfTestCheck& check : night->checks) {
    const std::string subject = "tonight " + check.name;
    if (check.passed) {
      findings.ok(subject, check.text);
    } else {
      findings.fail(subject, check.text, "docs/howto/nightly.md");
    }
  }
  for (const std::string& note : night->notes) findings.warn("tonight", note, "");
  for (const NightStep& step : night->steps) check_step(step, findings);
}

}  // namespace panelcal::doctor
