// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "tools/batch/cluster/shard.h"
#include "tools/batch/output/progress.h"
#include "tools/cli/console.h"

namespace panelcal::batch {

/// A command's words as a shell reads them.
std::string shell_text(std::span<const std::string> words);

struct ArrayTerms {
  std::filesystem::path results;
  std::vector<std::string> command;  ///< that does the batch, without --threads and --shard
  std::int64_t n_jobs = 0;           ///< to be done
  std::int64_t n_shards = 0;         ///< 0: those of the array that is under way, or 16
  std::int64_t n_retries = 0;        ///< of each shard
  std::size_t n_threads = 1;         ///< of each shard
};

/// An array of Slurm whose tasks are the shards of a batch, on a folder that all nodes share.
///
///   RESULTS/slurm/array.json   the array that is under way, written before it is submitted
///   RESULTS/slurm/array.sh     the script of its tasks
///   RESULTS/slurm/JOB_TASK.log their words
///
/// The array has a name that no other one has, so that a process that was killed between sbatch
/// and its answer finds the tasks again by squeue, and submits none twice. A shard is done when its
/// own folder says so: no accounting is needed. Was it done twice all the same, by a file system
/// that shows its folder late, then the second process finds nothing left to do.
///
/// Fails  interrupted (the tasks go on); device-stage (sbatch: not there, or it refuses);
///        device-write; usage (an array of another command is under way)
/// See    tests/tools/batch_slurm_test.py; docs/howto/cluster.md
class SlurmArray {
 public:
  SlurmArray(ArrayTerms terms, Console& console);

  /// True if an array of these results has been submitted, and has not been followed to its end.
  static bool is_under_way(const std::filesystem::path& results);

  /// Submits the shards, or goes on with those of an array under way, until each is done or has
  /// ended more often than retries allow.
  ///
  /// Out    the numbers of the latter
  Expected<std::vector<std::int64_t>> run();

 private:
  /// Of a shard.
  struct Part {
    std::int64_t n_starts = 0;
    JobCount count;
    bool is_done = false;
    bool is_given_up = false;
  };

  Expected<void> begin();
  Expected<void> go_on(const std::string& text);
  Expected<void> save() const;
  Expected<void> write_script() const;
  Expected<void> submit(const std::vector<std::int64_t>& numbers);
  /// One look at the queue and at all shards. Out: true when all have ended.
  Expected<bool> look();
  /// The shards that are in the queue, each with its state in Slurm's letters.
  Expected<std::map<std::int64_t, std::string>> queued() const;
  std::filesystem::path folder() const { return terms_.results / "slurm"; }
  std::string job_words() const;

  ArrayTerms terms_;
  Console& console_;
  Progress progress_;
  std::string name_;
  std::vector<std::string> jobs_;  ///< Slurm's numbers, one for each submission
  std::vector<Part> parts_;
  bool is_queue_known_ = true;
};

}  // namespace panelcal::batch
