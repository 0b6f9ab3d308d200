// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/work/worker.h"

#include <exception>
#include <filesystem>
#include <new>
#include <system_error>
#include <utility>

#include "machine/files/file_register.h"
#include "machine/job/facts/job_facts.h"
#include "machine/job/facts/seen_pictures.h"
#include "machine/job/job.h"
#include "machine/job/text_variables.h"
#include "tools/batch/work/job_rows.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/process/memory_limit.h"
#include "vision/suggest/common_scale.h"
#include <fmt/format.h>

namespace panelcal::batch {
namespace {

constexpr const char* kBatchName = "panelcal batch";

/// The extension of a format's files.
std::string_view extension_of_format(OutputFormat format) {
  switch (format) {
    case OutputFormat::Jsonl:
      return ".jsonl";
    case OutputFormat::Csv:
      return ".csv";
    case OutputFormat::Excellon:
      return ".drl";
    case OutputFormat::SiebMeyer:
      return ".s5";
    case OutputFormat::Gcode:
      return ".ngc";
    case OutputFormat::Svg:
      break;
  }
  return ".svg";
}

/// One job, as `run` has it (tools/run/command.cc), without a person who reads along.
class BatchJob {
 public:
  BatchJob(const ManifestJob& row, const JobTerms& terms, MachineCache& machines)
      : row_(row), terms_(terms), machines_(machines) {}

  /// Reads the program; the format and the output's name follow from it.
  Expected<void> prepare(const std::filesystem::path& results) {
    // Also a job that fails at once knows where an earlier start has left files of it.
    folder_ = job_folder(results, row_);
    facts_file = (folder_ / "facts.json").string();
    PANELCAL_TRY(machine_, machines_.get(row_.machine));
    PANELCAL_TRY(job_, read_job(row_.program, machine_->config, terms_.now));
    if (!row_.truth.empty()) {
      PANELCAL_TRY(job_.truth, read_truth_json(row_.truth));
    }
    job_.clock = clock();
    job_.command = kBatchName;
    job_.compares_models = job_.finds_worst_place = true;
    job_.keeps_places = terms_.keeps_places;
    choose_output();
    return check_own_files();
  }

  /// Precondition: prepared
  Expected<JobResult> measure(JobOutput* receiver, const PictureObserver& observer) {
    if (receiver == nullptr) job_.format.reset();
    note_origin();
    const OpenJobSources open = [&](const Survey& nominal) {
      return open_sources({.command = kBatchName,
                           .images = row_.images,
                           .measurements = row_.measurements,
                           .probes = row_.probes,
                           .observer =
                               [this, &observer](const SeenView& seen) {
                                 scale_.add(seen.detection);
                                 observer(seen);
                               }},
                          machine_->config,
                          nominal);
    };
    auto result = correct(job_, open, machine_->config, {.output = receiver, .log = &log});
    if (auto warning = scale_.warning(row_.machine)) log.add(*std::move(warning));
    return result;
  }

  std::string facts(const JobResult& result, SeenPictures pictures) const {
    return job_facts(facts_of(result, std::move(pictures)));
  }
  JobFactsInput facts_of(const JobResult& result, SeenPictures pictures) const {
    JobFactsInput input = facts_input(result);
    input.program_file = job_.program.source.file;
    input.machine_name = machine_->config.name;
    input.output_file = result.is_committed ? output : "";
    input.common_scale = scale_.words().value_or("");
    input.pictures = std::move(pictures.by_seq);
    input.diagnostics = log.kept();
    input.provenance = provenance_;
    input.provenance.emplace_back("date", job_.clock);
    input.provenance.insert(
        input.provenance.end(), machine_->ledger_head.begin(), machine_->ledger_head.end());
    return input;
  }

  std::string machine_name() const { return machine_ ? machine_->config.name : ""; }
  const Truth* truth() const { return job_.truth ? &*job_.truth : nullptr; }
  /// Every name that results of the job may have in its folder.
  std::vector<std::string> own_files() const {
    std::vector<std::string> out = {facts_file};
    if (!row_.output.empty()) return out;
    for (const OutputFormat format : {OutputFormat::Jsonl,
                                      OutputFormat::Csv,
                                      OutputFormat::Excellon,
                                      OutputFormat::SiebMeyer,
                                      OutputFormat::Gcode,
                                      OutputFormat::Svg}) {
      out.push_back(own_output(format));
    }
    return out;
  }
  const std::string& clock() const { return row_.clock.empty() ? terms_.clock : row_.clock; }

  DiagnosticLog log;
  std::string output;      ///< the corrected program's name
  std::string facts_file;  ///< that of the document of facts

 private:
  void choose_output() {
    job_.format = terms_.format;
    if (!job_.format && !row_.output.empty()) {
      job_.format = output_format_of_extension(extension_of(row_.output));
    }
    if (!job_.format) {
      job_.format = job_.program.dialect == Dialect::SiebMeyer ? OutputFormat::SiebMeyer
                                                               : OutputFormat::Excellon;
    }
    output = row_.output.empty() ? own_output(*job_.format) : row_.output;
  }

  /// The corrected program's name where no column states one.
  std::string own_output(OutputFormat format) const {
    return (folder_ / fmt::format("corrected{}", extension_of_format(format))).string();
  }

  /// Files that only the program names: the manifest's own were held against outputs before.
  Expected<void> check_own_files() const {
    if (row_.output.empty()) return {};
    FileRegister files;
    add_pattern_files(job_.program, files);
    const auto use = files.use_of(output);
    if (!use) return {};
    return failure({Code::OutputInUse,
                    {row_.program, 0, 0},
                    fmt::format("{} is {}", quoted(output), *use),
                    "a file of its own for each output"});
  }

  /// The words of the command that does the same job alone.
  std::vector<std::string> run_words() const {
    std::vector<std::string> words = {"panelcal", "run", row_.program, "-m", row_.machine};
    const auto add = [&](const char* option, const std::string& value) {
      if (value.empty()) return;
      words.emplace_back(option);
      words.push_back(value);
    };
    add("--images", row_.images);
    add("--measurements", row_.measurements);
    add("--probes", row_.probes);
    add("--truth", row_.truth);
    if (terms_.format) add("--to", std::string(name(*terms_.format)));
    add("-o", output);
    add("--json", facts_file);
    add("--clock", job_.clock);
    return words;
  }

  void note_origin() {
    Options alone;
    alone.command_line = run_words();
    provenance_ = provenance_of(alone, job_.program, {});
    const auto append = [this](const Provenance& rows) {
      provenance_.insert(provenance_.end(), rows.begin(), rows.end());
    };
    append(machine_->digests);
    append(file_digests({row_.measurements, row_.probes}));
    const bool drifts = machine_->config.drift_um_per_sqrt_day > 0;
    if (drills_the_time(job_.program) || drifts) provenance_.emplace_back("clock", job_.clock);
    job_.comments = comment_lines(provenance_);
  }

  const ManifestJob& row_;
  const JobTerms& terms_;
  MachineCache& machines_;
  std::filesystem::path folder_;  ///< of the job's results
  std::shared_ptr<const KnownMachine> machine_;
  Job job_;
  Provenance provenance_;
  CommonScale scale_;
};

/// The files of a job with results; of one that failed none, whatever it has written. What an
/// earlier start has left in the job's folder is not this one's.
std::vector<PartFile> files_of(const BatchJob& job,
                               const JobResult* result,
                               const PartOutput& output,
                               const PartOutput& facts) {
  std::vector<PartFile> files;
  std::vector<std::string> old = job.own_files();
  const auto put = [&](const PartOutput& part, const std::string& target, bool is_result) {
    if (!part.is_committed()) return;
    files.push_back({part.path(), is_result ? target : ""});
    if (is_result) std::erase(old, target);
  };
  put(output, job.output, result != nullptr && result->is_committed);
  put(facts, job.facts_file, result != nullptr);
  for (const std::string& file : old) {
    std::error_code ignored;
    const std::filesystem::file_status there = std::filesystem::symlink_status(file, ignored);
    if (there.type() != std::filesystem::file_type::not_found) files.push_back({file, {}});
  }
  return files;
}

}  // namespace

std::filesystem::path job_folder(const std::filesystem::path& results, const ManifestJob& job) {
  return results / "jobs" / job.id;
}

JobWorker::JobWorker(JobTerms terms, MachineCache& machines, const ResultFolder& results)
    : terms_(std::move(terms)), machines_(machines), results_(results) {
}

FinishedJob JobWorker::run(const ManifestJob& row) const {
  FinishedJob done;
  JobOutcome& outcome = done.outcome;
  outcome.number = row.number;
  BatchJob job(row, terms_, machines_);
  PartOutput output(results_.part(row.number, "output"));
  PartOutput facts(results_.part(row.number, "facts"));
  SeenPictures pictures;
  pictures.cuts_out = false;
  const PictureObserver keep = pictures.observer();
  const PictureObserver observer = [&](const SeenView& seen) {
    outcome.of(JobTable::PictureQuality)
        .push_back(picture_row(row.number, outcome.n_pictures++, seen));
    keep(seen);
  };
  std::optional<JobResult> result;
  const auto fail = [&](Diagnostic problem) {
    result.reset();
    for (const JobTable table : {JobTable::Target, JobTable::Fit, JobTable::HoleSummary}) {
      outcome.of(table).clear();
    }
    job.log.add(std::move(problem));
  };
  try {
    Expected<void> ready = job.prepare(results_.path());
    // What fails when results are published ends the batch, and every one that goes on with it.
    if (ready && !row.output.empty()) ready = check_target(row.output);
    if (!ready) {
      fail(std::move(ready).error());
    } else if (auto measured = job.measure(&output, observer)) {
      result = *std::move(measured);
      put_result(*result, job.truth(), outcome);
      // A failure stays in `facts`.
      if (facts.begin() && facts.write(job.facts(*result, std::move(pictures)))) {
        static_cast<void>(facts.commit());
      }
    }
  } catch (const std::bad_alloc&) {
    fail({Code::OutOfMemory,
          {row.program, 0, 0},
          memory_limit(),
          "more memory, or fewer --threads"});
  } catch (const std::exception& error) {
    fail(
        {Code::Internal, {row.program, 0, 0}, error.what(), "no exception here; please report it"});
  }
  const bool is_written = result && result->is_committed;
  put_head(row,
           {job.machine_name(), job.clock(), is_written ? job.output : ""},
           result ? &*result : nullptr,
           job.log,
           outcome);
  for (const PartOutput* part : {&output, &facts}) {
    if (part->problem()) done.broken = part->problem();
  }
  done.files = files_of(job, result ? &*result : nullptr, output, facts);
  return done;
}

Expected<DrawnJob> draw_job(const ManifestJob& row, const JobTerms& terms, MachineCache& machines) {
  BatchJob job(row, terms, machines);
  PANELCAL_CHECK(job.prepare({}));
  SeenPictures pictures;
  PANELCAL_TRY(const JobResult result, job.measure(nullptr, pictures.observer()));
  const JobFactsInput input = job.facts_of(result, std::move(pictures));
  return DrawnJob{job_facts(input), job_pictures(input)};
}

}  // namespace panelcal::batch
