// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <string>

#include "calib/base/clock.h"
#include "machine/config/machine_config.h"
#include "machine/job/checked_program.h"
#include "machine/job/walk_terms.h"
#include "tools/cli/commands.h"

namespace panelcal {
namespace {

/// Writes down what is asked, and answers as a perfect panel would.
class RequestList final : public MeasurementSource, public ProbeSource {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    lines_ += to_json(request) + "\n";
    return panel_.measure(request);
  }
  Expected<std::optional<FocusResult>> focus(const MeasurementRequest& request) override {
    lines_ += to_json(request) + "\n";
    return panel_.focus(request);
  }
  Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order) override {
    lines_ += to_json(order) + "\n";
    return panel_.calibrate(order);
  }
  Expected<ProbeReading> probe(const ProbeRequest& request) override {
    lines_ += to_json(request) + "\n";
    return surface_.probe(request);
  }

  const std::string& lines() const { return lines_; }

 private:
  NominalSource panel_;
  NominalProbeSource surface_;
  std::string lines_;
};

}  // namespace

Expected<Answer> run_command(const SurveyOptions& options, CommandContext& context) {
  PANELCAL_TRY(MachineConfig config, read_machine_config(options.machine));
  const WalkTerms terms = {.program = options.program,
                           .clock = options.clock,
                           .now = system_clock()(),
                           .max_operations = options.max_operations,
                           .reading = options.reading,
                           .ages_offset = false,
                           .command = "panelcal survey"};
  PANELCAL_CHECK(set_walk_terms(terms, config));
  DiagnosticLog log;
  const auto checked = read_and_check(options.program, config.reading, config.walk, log);
  context.console.print(log);
  if (log.has_errors()) return Answer{{}, exit_code(log)};

  // Once more, since targets and probes are listed among each other as they are executed.
  RequestList list;
  DiagnosticLog said_already;
  survey(checked->program, config.walk, list, list, said_already);
  return Answer{list.lines()};
}

}  // namespace panelcal
