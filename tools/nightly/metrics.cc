// SPDX-License-Identifier: Apache-2.0
#include "tools/nightly/metrics.h"

#include <chrono>

namespace panelcal::nightly {
namespace {

double unix_time(std::chrono::sys_seconds time) {
  return static_cast<double>(time.time_since_epoch().count());
}

}  // namespace

Metrics night_metrics(const NightRecord& record, int exit_code) {
  Metrics out;
  const Metrics::Labels machine = {{"machine", record.machine}};
  out.gauge("panelcal_night_may_drill",
            "1: the machine may drill, 0: it may not",
            machine,
            record.may_drill ? 1 : 0);
  if (record.drill_until) {
    out.gauge("panelcal_night_drill_until_timestamp_seconds",
              "Earliest end of the forecasts of its calibrations",
              machine,
              unix_time(*record.drill_until));
  }
  out.gauge("panelcal_night_exit_code", "Exit code of panelcal nightly", machine, exit_code);
  out.gauge("panelcal_night_finished_timestamp_seconds",
            "End of the last night",
            machine,
            unix_time(record.finished));
  out.gauge("panelcal_night_duration_seconds",
            "Duration of the last night",
            machine,
            unix_time(record.finished) - unix_time(record.started));
  for (const NightStep& step : record.steps) {
    out.gauge("panelcal_night_calibration_installed",
              "1: the night's calibration is in force, 0: state tells why not",
              {{"machine", record.machine},
               {"kind", step.kind},
               {"subject", step.subject},
               {"state", std::string(name(step.state))}},
              step.state == NightState::Installed ? 1 : 0);
  }
  for (const SelfTestCheck& check : record.checks) {
    out.gauge("panelcal_night_check_passed",
              "1: a check of the self-test passed",
              {{"machine", record.machine}, {"check", check.name}},
              check.passed ? 1 : 0);
  }
  return out;
}

}  // namespace panelcal::nightly
