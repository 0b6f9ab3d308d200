// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <string>
#include <utility>

#include "calib/base/clock.h"
#include "machine/job/text_variables.h"
#include "python/bindings/convert.h"
#include "python/bindings/programs.h"
#include "tools/cli/provenance.h"
#include "tools/plan/output/json.h"
#include "tools/plan/planning.h"
#include <pybind11/stl.h>

namespace panelcal::python {
namespace {

/// share/schema/plan.schema.json
std::string plan_text(const ProgramSource& source,
                      const Machine& machine,
                      const std::string& measurements,
                      std::optional<double> fiducial_sigma_um,
                      std::size_t n_added,
                      const std::string& clock) {
  constexpr const char* kPlan = "panelcal.plan";
  if (n_added < 1 || n_added > plan::kMostAdded) {
    raise_usage(
        "plan", "n_added = " + std::to_string(n_added), "1 to " + std::to_string(plan::kMostAdded));
  }
  const py::gil_scoped_release release;
  const std::chrono::sys_seconds now = system_clock()();
  const plan::PlanningTerms terms = {
      .command = kPlan,
      .read =
          [&](const ReadOptions& reading, DiagnosticLog& log) {
            MachineConfig config;
            config.reading = reading;
            Job job = source.read(config, now);
            for (const Diagnostic& one : job.reading.kept()) log.add(one);
            return std::optional(std::move(job.program));
          },
      .walk = {.program = source.name, .clock = clock, .now = now, .command = kPlan},
      .measurements = measurements,
      .fiducial_sigma_um = fiducial_sigma_um,
      .n_added = n_added};
  DiagnosticLog log;
  const auto planning = plan::prepare_plan(terms, *machine.config, log);
  raise_errors(log);
  const Program& program = planning->checked.program;
  Options called;
  called.command_line = {"panelcal", "plan", "(Python)"};
  plan::PlanOrigin origin{
      program.source.file,
      planning->machine.name,
      provenance_of(called, program, {planning->machine.file.string(), measurements})};
  if (drills_the_time(program) || planning->machine.drift_um_per_sqrt_day > 0) {
    origin.provenance.emplace_back("clock", planning->time);
  }
  return facts::text(plan::plan_facts(planning->make(), planning->checked.nominal_survey, origin));
}

}  // namespace

void bind_plan(py::module_& module) {
  module.def(
      "plan",
      [](const ProgramSource& source,
         const Machine& machine,
         const std::string& measurements,
         std::optional<double> fiducial_sigma_um,
         std::size_t n_added,
         const std::string& clock) {
        return text(plan_text(source, machine, measurements, fiducial_sigma_um, n_added, clock));
      },
      py::arg("program"),
      py::arg("machine"),
      py::arg("measurements"),
      py::arg("fiducial_sigma_um"),
      py::arg("n_added"),
      py::arg("clock"));
}

}  // namespace panelcal::python
