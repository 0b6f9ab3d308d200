// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/files/byte_sink.h"
#include "calib/base/thread_pool.h"
#include "machine/job/facts/job_facts.h"
#include "machine/job/facts/seen_pictures.h"
#include "machine/job/facts/survey_facts.h"
#include "machine/job/job.h"
#include "machine/job/output/output.h"
#include "machine/job/text_variables.h"
#include "machine/sources/measurement_file_source.h"
#include "machine/sources/probe_file_source.h"
#include "python/bindings/columns.h"
#include "python/bindings/convert.h"
#include "python/bindings/programs.h"
#include "surface/map/file.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/provenance.h"
#include "vision/suggest/common_scale.h"
#include <pybind11/stl.h>

namespace panelcal::python {
namespace {

constexpr const char* kCorrect = "panelcal.correct";

/// As the facts have it.
std::string_view verdict_word(facts::Verdict verdict) {
  constexpr std::array<std::string_view, 4> kWords = {"drill", "warned", "hold", "forced"};
  return kWords.at(static_cast<std::size_t>(verdict));
}

/// The arguments of correct(); empty names: not given.
struct CorrectOptions {
  std::string images;
  std::string measurements;                      ///< a file
  std::optional<std::string> measurements_text;  ///< or JSON Lines
  std::string driver;
  std::string probes;
  std::string surface;
  std::string truth;
  std::string output;
  std::string format;
  std::string clock;
  std::optional<int> turned_deg;
  std::optional<double> resolution_um;
  bool uncorrected = false;
  bool force = false;
  bool facts = true;
  std::size_t n_threads = 1;
};

/// One call of correct(). Nothing here touches Python but take().
class Correction {
 public:
  Correction(const ProgramSource& program, const Machine& machine, CorrectOptions options)
      : options_(std::move(options)), machine_(*machine.config) {
    if (options_.turned_deg) machine_.walk.base_limits.turned_deg = *options_.turned_deg;
    const std::chrono::sys_seconds now = system_clock()();
    value_of(wall_time(options_.clock, now, kCorrect));
    job_ = program.read(machine_, now);
    job_.clock = options_.clock;
    job_.command = kCorrect;
    job_.force = options_.force;
    job_.compares_models = job_.finds_worst_place = job_.keeps_places = options_.facts;
    if (options_.resolution_um) job_.resolution = um(*options_.resolution_um);
    if (!options_.truth.empty()) job_.truth = value_of(read_truth_json(options_.truth));
    read_surface();
    check_output_file(program);
    open_output();
  }

  void run() {
    DiagnosticLog log;
    const JobSinks sinks{.output = output_.get(), .operations = &columns_, .log = &log};
    const OpenJobSources open = [this](const Survey& nominal) { return open_sources(nominal); };
    Expected<JobResult> result = correct(job_, open, machine_, sinks);
    log_.assign(log.kept().begin(), log.kept().end());
    if (!result) throw Raised{std::move(result).error(), log_};
    result_ = *std::move(result);
    if (auto warning = scale_.warning(machine_.file.string())) log_.push_back(*std::move(warning));
    const JobFactsInput input = all_facts();
    verdict_ = verdict_word(facts::verdict_of(input));
    if (options_.facts) facts_ = job_facts(input);
  }

  py::dict take() {
    py::dict out;
    out["facts"] = options_.facts ? py::object(text(facts_)) : py::object(py::none());
    out["operations"] = may_be_used() ? py::object(columns_.take()) : py::object(py::none());
    out["verdict"] = verdict_;
    out["may_be_drilled"] = result_.may_be_drilled();
    out["is_written"] = result_.is_committed;
    out["measurements"] = text(measurement_lines(*result_.survey));
    const bool has_text = result_.is_committed && options_.output.empty();
    out["program"] = has_text ? py::object(bytes_of(written_.text())) : py::object(py::none());
    out["diagnostics"] = diagnostics(log_);
    return out;
  }

 private:
  /// Places of a job that is held are for no machine.
  bool may_be_used() const {
    return result_.may_be_drilled() || (options_.force && result_.is_executed);
  }

  void read_surface() {
    if (options_.surface.empty()) return;
    StoredZones stored = value_of(read_zoned_map_file(options_.surface));
    job_.surface = std::make_shared<const ZonedMap>(std::move(stored.map));
    job_.surface_axis = stored.z_axis;
  }

  /// No output may replace what the job reads, as on the command line.
  void check_output_file(const ProgramSource& program) const {
    if (options_.output.empty()) return;
    Options called;
    called.command_name = kCorrect;
    called.files = {{FileUse::Read, program.text ? "" : program.name, "the program"},
                    {FileUse::Machine, machine_.file.string(), ""},
                    {FileUse::Pictures, options_.images, "the pictures of images"},
                    {FileUse::Read, options_.measurements, "the file of measurements"},
                    {FileUse::Read, options_.probes, "the file of probes"},
                    {FileUse::Read, options_.surface, "the file of surface"},
                    {FileUse::Read, options_.truth, "the file of truth"}};
    FileRegister files = files_in_use(called);
    add_pattern_files(job_.program, files);
    value_of(check_output(called, files, options_.output));
  }

  void open_output() {
    if (options_.output.empty() && options_.format.empty()) return;
    const std::string extension = std::filesystem::path(options_.output).extension().string();
    job_.format = options_.format.empty() ? output_format_of_extension(extension)
                                          : output_format_from_name(options_.format);
    if (!job_.format) {
      raise_usage("correct",
                  options_.format.empty()
                      ? "no format belongs to the output's name " + quoted(options_.output)
                      : "format = " + quoted(options_.format),
                  "jsonl, csv, excellon, sieb-meyer, gcode or svg as format");
    }
    note_provenance();
    if (options_.output.empty()) {
      output_ = std::make_unique<SpooledOutput>(written_);
    } else {
      output_ = std::make_unique<FileOutput>(options_.output);
    }
  }

  void note_provenance() {
    Options called;
    called.command_line = {"panelcal", "correct", "(Python)"};
    provenance_ = provenance_of(called,
                                job_.program,
                                {machine_.file.string(),
                                 machine_.spindle_setting.file.string(),
                                 machine_.table_file.string(),
                                 options_.measurements,
                                 options_.probes,
                                 options_.surface});
    if (!options_.clock.empty()) provenance_.emplace_back("clock", options_.clock);
    job_.comments = comment_lines(provenance_);
  }

  Expected<JobSources> open_sources(const Survey& nominal) {
    if (!options_.images.empty()) {
      pool_ = make_thread_pool(options_.n_threads, nominal.measurements.size());
    }
    SourceChoice choice{.command = kCorrect,
                        .images = options_.images,
                        .measurements = options_.measurements,
                        .machine_driver = options_.driver,
                        .probes = options_.probes,
                        .uncorrected = options_.uncorrected,
                        .observer = observer(),
                        .executor = pool_.get()};
    if (!options_.measurements_text) return panelcal::open_sources(choice, machine_, nominal);
    PANELCAL_TRY(RecordedMeasurements recorded,
                 parse_measurements(*options_.measurements_text, "measurements"));
    // The probes, if there are any, as of a program without targets.
    Survey probed = nominal;
    probed.measurements.clear();
    PANELCAL_TRY(JobSources sources, panelcal::open_sources(choice, machine_, probed));
    sources.targets = std::make_shared<MeasurementFileSource>(std::move(recorded));
    sources.words = "measurements given to panelcal.correct";
    return sources;
  }

  PictureObserver observer() {
    PictureObserver draw = options_.facts ? pictures_.observer() : PictureObserver();
    return [this, draw](const SeenView& seen) {
      scale_.add(seen.detection);
      if (draw) draw(seen);
    };
  }

  JobFactsInput all_facts() {
    if (provenance_.empty() && options_.facts) note_provenance();
    JobFactsInput input = facts_input(result_);
    input.program_file = job_.program.source.file;
    input.machine_name = machine_.name;
    // Without a file the caller gets it, as standard output would.
    if (may_be_used()) input.output_file = options_.output.empty() ? "-" : options_.output;
    input.forced = may_be_used() && result_.log.has_errors();
    input.common_scale = scale_.words().value_or("");
    input.pictures = std::move(pictures_.by_seq);
    input.diagnostics = log_;
    input.provenance = provenance_;
    input.provenance.emplace_back(
        "date", options_.clock.empty() ? iso_8601(system_clock()()) : options_.clock);
    std::ranges::move(ledger_head_row(machine_.ledger_file), std::back_inserter(input.provenance));
    return input;
  }

  CorrectOptions options_;
  MachineConfig machine_;
  Job job_;
  Provenance provenance_;
  SeenPictures pictures_;
  CommonScale scale_;
  std::unique_ptr<ThreadPool> pool_;
  StringSink written_;
  std::unique_ptr<JobOutput> output_;
  OperationColumns columns_;
  JobResult result_;
  std::vector<Diagnostic> log_;
  std::string facts_;
  std::string_view verdict_;
};

}  // namespace

void bind_jobs(py::module_& module) {
  py::class_<CorrectOptions>(module, "CorrectOptions")
      .def(py::init<>())
      .def_readwrite("images", &CorrectOptions::images)
      .def_readwrite("measurements", &CorrectOptions::measurements)
      .def_readwrite("measurements_text", &CorrectOptions::measurements_text)
      .def_readwrite("driver", &CorrectOptions::driver)
      .def_readwrite("probes", &CorrectOptions::probes)
      .def_readwrite("surface", &CorrectOptions::surface)
      .def_readwrite("truth", &CorrectOptions::truth)
      .def_readwrite("output", &CorrectOptions::output)
      .def_readwrite("format", &CorrectOptions::format)
      .def_readwrite("clock", &CorrectOptions::clock)
      .def_readwrite("turned_deg", &CorrectOptions::turned_deg)
      .def_readwrite("resolution_um", &CorrectOptions::resolution_um)
      .def_readwrite("uncorrected", &CorrectOptions::uncorrected)
      .def_readwrite("force", &CorrectOptions::force)
      .def_readwrite("facts", &CorrectOptions::facts)
      .def_readwrite("n_threads", &CorrectOptions::n_threads);
  module.def(
      "correct",
      [](const ProgramSource& program, const Machine& machine, const CorrectOptions& options) {
        std::unique_ptr<Correction> correction;
        {
          const py::gil_scoped_release release;
          correction = std::make_unique<Correction>(program, machine, options);
          correction->run();
        }
        return correction->take();
      },
      py::arg("program"),
      py::arg("machine"),
      py::arg("options"));
}

}  // namespace panelcal::python
