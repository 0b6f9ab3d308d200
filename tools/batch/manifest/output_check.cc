// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/manifest/output_check.h"

#include <string>
#include <system_error>
#include <unordered_map>
#include <unordered_set>

#include "machine/files/machine_files.h"
#include "machine/job/output/output_format.h"
#include "tools/cli/output_paths.h"
#include <fmt/format.h>

namespace panelcal::batch {
namespace {

namespace fs = std::filesystem;

/// As links lead to it; of a file that is not there its folder counts.
fs::path real(const fs::path& path) {
  std::error_code error;
  const fs::path named = fs::absolute(path, error);
  fs::path found = fs::weakly_canonical(named, error);
  return error ? named.lexically_normal() : found;
}

bool is_within(const fs::path& path, const fs::path& folder) {
  for (fs::path above = path;; above = above.parent_path()) {
    if (above == folder) return true;
    if (above == above.parent_path()) return false;
  }
}

/// Knows what a batch reads. A batch has many files, so that each is looked up by its name.
class BatchInputs {
 public:
  BatchInputs(const Manifest& manifest, const fs::path& results)
      : manifest_(manifest), results_(real(results)) {
    for (const char* part : {"jobs", "parts", "lock", "store.sqlite", "shards", "slurm"}) {
      own_.push_back(results_ / part);
    }
  }

  Expected<void> add_all() {
    PANELCAL_CHECK(add(manifest_.file, 0, "the manifest", files_));
    for (const ManifestJob& job : manifest_.jobs) {
      const std::string of_job = " of job " + job.id;
      PANELCAL_CHECK(add(job.program, job.line, "the program" + of_job, files_));
      PANELCAL_CHECK(add(job.measurements, job.line, "the measurements" + of_job, files_));
      PANELCAL_CHECK(add(job.probes, job.line, "the probes" + of_job, files_));
      PANELCAL_CHECK(add(job.truth, job.line, "the truth" + of_job, files_));
      PANELCAL_CHECK(add(job.images, job.line, "in the pictures" + of_job, folders_));
      if (machines_.insert(job.machine).second) {
        PANELCAL_CHECK(add(job.machine, job.line, "the machine" + of_job, files_));
        add_machine_files(job.machine, machine_files_);
      }
    }
    return {};
  }

  Expected<void> check_output(const std::string& output, int line) {
    const fs::path place = real(output);
    if (const auto use = use_of(place, output)) return refuse(line, output, *use);
    if (!outputs_.insert(place.string()).second) {
      return refuse(line, output, "another job's output");
    }
    for (const fs::path& own : own_) {
      if (is_within(place, own)) return refuse(line, output, "in the results of the batch");
    }
    return {};
  }

 private:
  tl::unexpected<Diagnostic> refuse(int line, const std::string& file, const std::string& use) {
    return failure({Code::OutputInUse,
                    {manifest_.file, line, 0},
                    fmt::format("{} is {}", quoted(file), use),
                    "a file of its own for each output"});
  }

  Expected<void> add(const std::string& file,
                     int line,
                     const std::string& what,
                     std::unordered_map<std::string, std::string>& where) {
    if (file.empty()) return {};
    const fs::path place = real(file);
    for (const fs::path& own : own_) {
      if (!is_within(place, own)) continue;
      return failure({Code::OutputInUse,
                      {manifest_.file, line, 0},
                      fmt::format("{}, {}, is in the results of the batch", quoted(file), what),
                      "-o with another folder"});
    }
    where.emplace(place.string(), what);
    return {};
  }

  std::optional<std::string> use_of(const fs::path& place, const std::string& named) const {
    if (const auto at = files_.find(place.string()); at != files_.end()) return at->second;
    for (fs::path above = place.parent_path();; above = above.parent_path()) {
      if (const auto at = folders_.find(above.string()); at != folders_.end()) return at->second;
      if (above == above.parent_path()) break;
    }
    return machine_files_.use_of(named);
  }

  const Manifest& manifest_;
  fs::path results_;
  std::vector<fs::path> own_;  ///< what the batch itself writes
  std::unordered_map<std::string, std::string> files_;
  std::unordered_map<std::string, std::string> folders_;
  std::unordered_set<std::string> machines_;
  std::unordered_set<std::string> outputs_;
  FileRegister machine_files_;
};

}  // namespace

Expected<void> check_job_outputs(const Manifest& manifest,
                                 const fs::path& results,
                                 const std::vector<std::string>& other_outputs,
                                 bool has_format) {
  BatchInputs inputs(manifest, results);
  PANELCAL_CHECK(inputs.add_all());
  for (const std::string& output : other_outputs) {
    if (!output.empty() && output != "-") PANELCAL_CHECK(inputs.check_output(output, 0));
  }
  for (const ManifestJob& job : manifest.jobs) {
    if (job.output.empty()) continue;
    if (!has_format && !output_format_of_extension(extension_of(job.output))) {
      return failure({Code::Usage,
                      {manifest.file, job.line, 0},
                      "no format belongs to the output's name " + quoted(job.output),
                      ".jsonl, .csv, .drl, .exc, .s5, .sm, .ngc or .svg, or --to"});
    }
    PANELCAL_CHECK(inputs.check_output(job.output, job.line));
  }
  return {};
}

}  // namespace panelcal::batch
