// SPDX-License-Identifier: Apache-2.0
#include "python/bindings/programs.h"

#include <filesystem>
#include <memory>
#include <utility>

#include "calib/base/clock.h"
#include "machine/job/checked_program.h"
#include "machine/job/walk_terms.h"
#include "program/walk/walk.h"
#include "python/bindings/columns.h"
#include "python/bindings/convert.h"
#include "vision/fit/target.h"
#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

namespace panelcal::python {
namespace {

/// A program that was read and checked, with all that it does on a perfect panel.
struct ReadProgram {
  ProgramSource source;
  CheckedProgram checked;
  std::vector<Diagnostic> warnings;
  py::dict operations;
};

std::shared_ptr<ReadProgram> read(ProgramSource source, const Machine* machine) {
  auto out = std::make_shared<ReadProgram>();
  OperationColumns columns;
  {
    const py::gil_scoped_release release;
    MachineConfig config = machine != nullptr ? *machine->config : MachineConfig();
    const std::chrono::sys_seconds now = system_clock()();
    value_of(set_walk_terms({.program = source.name,
                             .now = now,
                             .ages_offset = false,
                             .command = "panelcal.read_program"},
                            config));
    Job job = source.read(config, now);
    DiagnosticLog log = std::move(job.reading);
    raise_errors(log);
    Survey survey = survey_nominal(job.program, config.walk, log);
    raise_errors(log);
    out->source = std::move(source);
    out->checked = {std::move(job.program), std::move(survey)};
    execute_nominal(out->checked, config.walk, columns, log);
    raise_errors(log);
    out->warnings.assign(log.kept().begin(), log.kept().end());
  }
  out->operations = columns.take();
  return out;
}

py::dict tools_of(const ReadProgram& self) {
  py::dict out;
  for (const auto& [number, tool] : self.checked.program.tools()) {
    py::dict row;
    if (tool.diameter) row["diameter_mm"] = tool.diameter->in_mm();
    if (tool.infeed) row["feed_mm_s"] = tool.infeed->in_mm_s();
    if (tool.retract) row["retract_mm_s"] = tool.retract->in_mm_s();
    if (tool.speed) row["speed_rpm"] = tool.speed->in_rpm();
    if (tool.max_hits) row["max_hits"] = *tool.max_hits;
    if (tool.depth_offset) row["depth_offset_mm"] = tool.depth_offset->in_mm();
    out[py::int_(number)] = row;
  }
  return out;
}

py::dict targets_of(const Machine& machine) {
  py::dict out;
  for (const auto& [number, target] : machine.config->vision_tools) {
    out[py::int_(number)] = std::make_shared<Target>(target);
  }
  return out;
}

std::shared_ptr<Machine> machine_of(Expected<MachineConfig> config) {
  return std::make_shared<Machine>(
      Machine{std::make_shared<const MachineConfig>(value_of(std::move(config)))});
}

}  // namespace

Job ProgramSource::read(const MachineConfig& machine, std::chrono::sys_seconds now) const {
  if (!text) return value_of(read_job(name, machine, now));
  Job job;
  job.program = load_program({.file = name, .bytes = *text}, job.reading, machine.reading);
  job.now = now;
  return job;
}

void bind_machine(py::module_& module) {
  py::class_<Machine, std::shared_ptr<Machine>>(module, "Machine", R"(
A machine as its machine.toml describes it; `read_machine` makes one.

Attributes
----------
name, file : str
targets : dict of int to Target
    The vision tools, by number.
mapping : CameraMapping or None
    Of the calibrated ``[camera]``.
picture_px : (int, int) or None
    Width and height of the pictures that this camera takes.

Notes
-----
Immutable: threads may share it.)")
      .def_property_readonly("name", [](const Machine& self) { return text(self.config->name); })
      .def_property_readonly("file",
                             [](const Machine& self) { return text(self.config->file.string()); })
      .def_property_readonly("targets", &targets_of)
      .def_property_readonly("mapping",
                             [](const Machine& self) {
                               const auto& camera = self.config->camera;
                               return camera ? std::optional(camera->mapping()) : std::nullopt;
                             })
      .def_property_readonly("picture_px",
                             [](const Machine& self) -> py::object {
                               const auto& camera = self.config->camera;
                               if (!camera) return py::none();
                               return py::make_tuple(camera->picture_width_px,
                                                     camera->picture_height_px);
                             })
      .def("__repr__", [](const Machine& self) {
        return fmt::format(
            "<panelcal.Machine {} of {}>", quoted(self.config->name), self.config->file.string());
      });
  module.def(
      "read_machine",
      [](const std::filesystem::path& file) { return machine_of(read_machine_config(file)); },
      py::arg("file"),
      py::call_guard<py::gil_scoped_release>());
  module.def(
      "parse_machine",
      [](const std::string& text, const std::filesystem::path& file) {
        return machine_of(parse_machine_config(text, file));
      },
      py::arg("text"),
      py::arg("file"),
      py::call_guard<py::gil_scoped_release>());
}

void bind_programs(py::module_& module) {
  py::class_<ProgramSource>(module, "ProgramSource")
      .def(py::init([](std::string name, std::optional<std::string> text) {
             return ProgramSource{std::move(name), std::move(text)};
           }),
           py::arg("name"),
           py::arg("text"));
  py::class_<ReadProgram, std::shared_ptr<ReadProgram>>(module, "ReadProgram")
      .def(py::init(&read), py::arg("source"), py::arg("machine").none(true))
      .def_property_readonly("source", [](const ReadProgram& self) { return self.source; })
      .def_property_readonly(
          "file", [](const ReadProgram& self) { return text(self.checked.program.source.file); })
      .def_property_readonly(
          "dialect", [](const ReadProgram& self) { return name(self.checked.program.dialect); })
      .def_property_readonly(
          "number_format",
          [](const ReadProgram& self) { return text(self.checked.program.number_summary()); })
      .def_property_readonly("tools", &tools_of)
      .def_property_readonly("operations", [](const ReadProgram& self) { return self.operations; })
      .def_property_readonly("requests",
                             [](const ReadProgram& self) {
                               py::list lines;
                               for (const auto& one : self.checked.nominal_survey.measurements) {
                                 lines.append(text(to_json(one.request)));
                               }
                               return lines;
                             })
      .def_property_readonly("diagnostics",
                             [](const ReadProgram& self) { return diagnostics(self.warnings); });
}

}  // namespace panelcal::python
