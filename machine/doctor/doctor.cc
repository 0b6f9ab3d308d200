// SPDX-License-Identifier: Apache-2.0
#include "machine/doctor/doctor.h"

#include <optional>
#include <string>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "machine/check/machine_check.h"
#include "machine/check/stated_keys.h"
#include "machine/config/machine_config.h"
#include "machine/doctor/checks.h"
#include "machine/job/spindle_age.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr const char* kMachineFile = "machine.toml";

/// What jobs and nights would come upon, and lets the offset drift until now.
void check_configuration(MachineConfig& config, std::chrono::sys_seconds now, Findings& findings) {
  DiagnosticLog log;
  check_machine(config, StatedKeys::of_file(config.file), now, log);
  for (const Diagnostic& problem : log.kept()) findings.add(kMachineFile, problem);
  const auto aged = age_offset(config, now);
  if (!aged) findings.add(kMachineFile, aged.error());
}

}  // namespace

Findings examine(const Examination& examination) {
  Findings findings;
  Expected<MachineConfig> config = read_machine_config(examination.machine_toml);
  if (!config) {
    findings.add(kMachineFile, config.error());
    return findings;
  }
  findings.ok(kMachineFile, quoted(config->name) + ", read with all that it names");
  if (const auto text = read_file(examination.machine_toml, kMaxConfigBytes)) {
    doctor::check_assumptions(*text, findings);
  }
  const std::chrono::sys_seconds now = examination.clock();
  check_configuration(*config, now, findings);
  doctor::check_calibrations(*config, now, findings);
  doctor::check_error_budget(*config, findings);
  doctor::check_programs(*config, findings);
  doctor::check_files(*config, findings);
  doctor::check_devices(*config, examination, findings);
  if (config->nightly) doctor::check_night(*config, examination, findings);
  return findings;
}

}  // namespace panelcal
