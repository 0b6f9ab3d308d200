// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "panelcal/calib/base/atomic_file.h"
#include "panelcal/calib/base/clock.h"
#include "panelcal/machine/machine_config.h"
#include "panelcal/machine/sim/truth.h"
#include "panelcal/program/writers/csv_writer.h"
#include "panelcal/program/writers/excellon_writer.h"
#include "panelcal/program/writers/jsonl_writer.h"
#include "panelcal/tools/commands.h"
#include "panelcal/tools/digest.h"
#include "panelcal/tools/measuring.h"
#include "panelcal/tools/program_input.h"
#include "panelcal/tools/report_html.h"
#include "panelcal/tools/truth_comparison.h"
#include "panelcal/tools/version.h"

namespace panelcal {
namespace {

using Provenance = std::vector<std::pair<std::string, std::string>>;

Expected<std::string> output_format(const RunOptions& options) {
  if (!options.format.empty()) return options.format;
  constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kByExtension = {
      {{".jsonl", "jsonl"}, {".csv", "csv"}, {".drl", "excellon"}, {".exc", "excellon"}}};
  const std::string extension = std::filesystem::path(options.output).extension().string();
  for (const auto& [known, format] : kByExtension) {
    if (extension == known) return std::string(format);
  }
  return failure({Code::Usage,
                  {"panelcal run", 0, 0},
                  "no format belongs to the output's name " + quoted(options.output),
                  ".jsonl, .csv, .drl or .exc, or --to"});
}

std::unique_ptr<TextWriter> make_writer(const std::string& format,
                                        ByteSink& bytes,
                                        const Provenance& provenance) {
  if (format == "jsonl") return std::make_unique<JsonlWriter>(bytes);
  if (format == "csv") return std::make_unique<CsvWriter>(bytes);
  std::vector<std::string> comments;
  for (const auto& [key, value] : provenance) comments.push_back(key + ": " + value);
  return std::make_unique<ExcellonWriter>(bytes, std::move(comments));
}

/// No output may overwrite an input or another output.
Expected<void> check_paths(const RunOptions& options) {
  std::vector<std::string> taken = {
      options.program, options.machine, options.measurements, options.truth};
  for (const std::string& output : {options.output, options.save_measurements, options.report}) {
    if (output.empty()) continue;
    const bool clashes = std::ranges::any_of(taken, [&](const std::string& other) {
      std::error_code ignored;
      return !other.empty() &&
             (other == output || std::filesystem::equivalent(other, output, ignored));
    });
    if (clashes && !(output == "-" && options.program == "-" && output == options.output)) {
      return failure({Code::Usage,
                      {"panelcal run", 0, 0},
                      quoted(output) + " is named twice on the command line",
                      "a file of its own for each output"});
    }
    taken.push_back(output);
  }
  return {};
}

/// What made the output, so that it can be made again: no dates, a replay is the same to the bit.
Provenance provenance_of(const Options& options,
                         const RunOptions& run,
                         const CheckedProgram& checked) {
  std::string command_line;
  for (const std::string& word : options.command_line) {
    // Where panelcal is installed says nothing about the job.
    command_line += command_line.empty() ? "panelcal" : " " + word;
  }
  Provenance provenance = {
      {"made by", std::string("panelcal ") + kVersion},
      {"command line", command_line},
      {"sha256 " + checked.program.source.file, sha256(checked.program.source.bytes)}};
  for (const std::string& file : {run.machine, run.measurements}) {
    if (file.empty()) continue;
    if (const auto bytes = read_file(file))
      provenance.emplace_back("sha256 " + file, sha256(*bytes));
  }
  return provenance;
}

/// One run, stage by stage. Every stage leaves its problems in log_.
class Run {
 public:
  Run(const RunOptions& options, CommandContext& context) : options_(options), context_(context) {}

  ExitCode execute_all() {
    if (!prepare() || !measure()) return finish();
    const bool may_write = !log_.has_errors() || (options_.force && has_only_gate_failures());
    if (may_write && measured_.survey.is_complete()) write_program();
    write_report();
    return finish();
  }

 private:
  template <class T>
  bool take(Expected<T> value, T& out) {
    if (value) {
      out = *std::move(value);
      return true;
    }
    log_.add(std::move(value).error());
    return false;
  }
  bool take(Expected<void> done) {
    if (!done) log_.add(std::move(done).error());
    return done.has_value();
  }

  bool prepare() {
    if (!take(read_machine_config(options_.machine), config_)) return false;
    config_.walk.max_operations = options_.max_operations;
    if (!take(output_format(options_), format_) || !take(check_paths(options_))) return false;
    if (!options_.truth.empty()) {
      Truth truth;
      if (!take(read_truth_json(options_.truth), truth)) return false;
      truth_ = std::move(truth);
      comparison_.emplace(*truth_);
    }
    checked_ = read_and_check(options_.program, config_.walk, log_);
    if (log_.has_errors() || !checked_) return false;
    provenance_ = provenance_of(context_.options, options_, *checked_);
    return true;
  }

  /// False if there is nothing to go on with; targets that were lost are something.
  bool measure() {
    DiagnosticLog found;
    const bool has_source = take(measure_program(options_,
                                                 config_,
                                                 checked_->program,
                                                 checked_->nominal_survey.measurements.size(),
                                                 context_.console,
                                                 found),
                                 measured_);
    // The warnings are those of the check, said already.
    for (const Diagnostic& diagnostic : found.kept()) {
      if (diagnostic.severity() == Severity::Error) log_.add(diagnostic);
    }
    if (!has_source || (exit_code(found) > ExitCode::GateFailed)) return false;
    context_.console.say(fits_summary(measured_.survey));
    if (options_.save_measurements.empty()) return true;
    std::string lines;
    for (const Measurement& measurement : measured_.survey.measurements) {
      lines += to_json(measurement) + "\n";
    }
    return take(write_result(options_.save_measurements, lines));
  }

  /// To a file, whole or not at all, or to standard output.
  Expected<void> write_result(const std::string& path, std::string_view bytes) {
    return path == "-" ? context_.output.write(bytes) : write_file(path, bytes);
  }

  bool has_only_gate_failures() const { return exit_code(log_) == ExitCode::GateFailed; }

  void write_program() {
    std::optional<AtomicFile> file;
    ByteSink* bytes = &context_.output;
    if (options_.output != "-") {
      Expected<AtomicFile> created = AtomicFile::create(options_.output);
      if (!created) return log_.add(std::move(created).error());
      file.emplace(*std::move(created));
      bytes = &*file;
    }
    const auto writer = make_writer(format_, *bytes, provenance_);
    std::vector<OperationSink*> sinks = {writer.get(), &tally_};
    if (comparison_) sinks.push_back(&*comparison_);
    Tee tee(std::move(sinks));
    DiagnosticLog walk_log;
    execute(checked_->program, config_.walk, measured_.survey, tee, walk_log);
    for (const Diagnostic& diagnostic : walk_log.kept()) log_.add(diagnostic);
    if (walk_log.has_errors() || !take(writer->finish()) || (file && !take(file->commit()))) return;
    is_written_ = true;
    context_.console.say(fmt::format(
        "{} holes written to {}, largest shift {:.1f} um, largest predicted sigma {:.3f} um",
        tally_.n_holes(),
        options_.output == "-" ? "standard output" : options_.output,
        tally_.max_shift().in_um(),
        tally_.max_sigma().in_um()));
    if (comparison_) context_.console.say("\nerror against truth\n" + comparison_->summary());
  }

  void write_report() {
    if (options_.report.empty()) return;
    ReportInput input;
    input.program_file = checked_->program.source.file;
    input.machine_name = config_.name;
    input.source = measured_.source;
    input.output_file = is_written_ ? options_.output : "";
    input.forced = is_written_ && log_.has_errors();
    input.survey = &measured_.survey;
    input.tally = is_written_ ? &tally_ : nullptr;
    input.truth = is_written_ && comparison_ ? &*comparison_ : nullptr;
    input.crops_png = std::move(measured_.crops_png);
    input.diagnostics = log_.kept();
    input.provenance = provenance_;
    input.provenance.emplace_back("date", iso_8601(system_clock()()));
    if (take(write_result(options_.report, report_html(input)))) {
      context_.console.say("report: " + options_.report);
    }
  }

  ExitCode finish() {
    context_.console.print(log_);
    if (log_.has_errors() && !is_written_) {
      context_.console.say("nothing was written to " + options_.output);
    }
    return exit_code(log_);
  }

  const RunOptions& options_;
  CommandContext& context_;
  DiagnosticLog log_;
  MachineConfig config_;
  std::string format_;
  std::optional<Truth> truth_;
  std::optional<TruthComparison> comparison_;
  std::optional<CheckedProgram> checked_;
  Provenance provenance_;
  MeasuringResult measured_;
  Tally tally_;
  bool is_written_ = false;
};

}  // namespace

ExitCode run_command(const RunOptions& options, CommandContext& context) {
  return Run(options, context).execute_all();
}

}  // namespace panelcal
