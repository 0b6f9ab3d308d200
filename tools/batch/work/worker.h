// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "machine/job/output/output_format.h"
#include "tools/batch/manifest/manifest.h"
#include "tools/batch/store/outcome.h"
#include "tools/batch/work/machine_cache.h"
#include "tools/batch/work/result_files.h"

namespace panelcal::batch {

/// Everything that all jobs of a batch share.
struct JobTerms {
  std::string clock;                   ///< the time on the wall, but for jobs that state their own
  std::chrono::sys_seconds now;        ///< of this start of the batch
  std::optional<OutputFormat> format;  ///< of --to; absent: by the output's name, or the program's
  bool keeps_places = false;           ///< the facts list every place
};

/// A job that was done, whatever came of it.
struct FinishedJob {
  JobOutcome outcome;
  std::vector<PartFile> files;            ///< to be published with it
  std::optional<Diagnostic> broken = {};  ///< the disk failed: this is no outcome of the job
};

/// A job's document of facts, and the pictures that it names.
struct DrawnJob {
  std::string facts;
  std::map<std::string, std::string> pictures;  ///< JPEG bytes by name
};

/// Does one job as `panelcal run` would do it: the files are the same, byte for byte, but that no
/// pieces of pictures are cut out for a page, and places are listed only on demand. Several threads
/// may use one worker.
///
/// See    tests/tools/batch_test.py
class JobWorker {
 public:
  /// Precondition: machines and results outlive this
  JobWorker(JobTerms terms, MachineCache& machines, const ResultFolder& results);

  /// An exception of a job is its own failure.
  FinishedJob run(const ManifestJob& job) const;

 private:
  JobTerms terms_;
  MachineCache& machines_;
  const ResultFolder& results_;
};

/// Does a job once more, without writing anything, for pictures of its targets.
///
/// Fails  what kept it from being measured
Expected<DrawnJob> draw_job(const ManifestJob& job, const JobTerms& terms, MachineCache& machines);

/// The name of a job's folder of results.
std::filesystem::path job_folder(const std::filesystem::path& results, const ManifestJob& job);

}  // namespace panelcal::batch
