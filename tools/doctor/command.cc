// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/json/facts.h"
#include "machine/config/machine_config.h"
#include "machine/doctor/doctor.h"
#include "tools/cli/commands.h"
#include "tools/cli/facts_output.h"
#include "tools/cli/process/version.h"
#include "tools/cli/provenance.h"
#include "tools/cli/stated_clock.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

std::string findings_text(const Findings& findings) {
  std::string text;
  for (const Finding& finding : findings.all()) {
    text += fmt::format("{:<10}{}: {}{}{}\n",
                        name(finding.state),
                        escaped_controls(finding.subject),
                        escaped_controls(finding.text),
                        finding.remedy.empty() ? "" : "; ",
                        escaped_controls(finding.remedy));
  }
  const int n_failing = findings.count(FindingState::Fails);
  const int n_warnings = findings.count(FindingState::Warning);
  return text + fmt::format("{}: {} failing, {} warning{}\n",
                            n_failing == 0 ? "ready" : "not ready",
                            n_failing,
                            n_warnings,
                            n_warnings == 1 ? "" : "s");
}

/// share/schema/doctor.schema.json
facts::Json doctor_facts(const DoctorOptions& options,
                         std::chrono::sys_seconds time,
                         const Findings& findings) {
  facts::Json document = facts::envelope("doctor", 1);
  document["machine"] = options.machine;
  document["time"] = iso_8601(time);
  document["opens_devices"] = options.opens_devices;
  document["is_ready"] = findings.count(FindingState::Fails) == 0;
  document["n_failing"] = findings.count(FindingState::Fails);
  document["n_warnings"] = findings.count(FindingState::Warning);
  document["findings"] = facts::Json::array();
  for (const Finding& finding : findings.all()) {
    document["findings"].push_back({{"state", name(finding.state)},
                                    {"subject", finding.subject},
                                    {"text", finding.text},
                                    {"remedy", finding.remedy}});
  }
  return document;
}

}  // namespace

Expected<Answer> run_command(const DoctorOptions& options, CommandContext& context) {
  PANELCAL_TRY(const Clock clock, stated_clock(options.clock));
  // A machine.toml that is wrong is a finding; one that is not there is none.
  PANELCAL_CHECK(read_file(options.machine, kMaxConfigBytes));
  const Findings findings = examine({.machine_toml = options.machine,
                                     .camera = options.camera,
                                     .opens_devices = options.opens_devices,
                                     .clock = clock,
                                     .software = std::string("panelcal ") + kVersion,
                                     .asked_by = asking_person({})});
  const bool is_ready = findings.count(FindingState::Fails) == 0;
  const auto document = [&] { return facts::text(doctor_facts(options, clock(), findings)); };
  return state_facts(context,
                     options.facts,
                     {},
                     document,
                     {findings_text(findings), is_ready ? ExitCode::Done : ExitCode::GateFailed});
}

}  // namespace panelcal
