// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "machine/operator/screen.h"
#include "program/model/measurement.h"

namespace panelcal::internal {

/// A job as its folder knows it.
struct JobRecord {
  std::string id;
  std::string program;
  std::string program_sha256;
  std::string machine_sha256;  ///< of machine.toml and the calibrations that it names
  std::string source;          ///< of the pictures, in words
  std::string who;             ///< has started it
  std::string started;         ///< ISO 8601, UTC
  JobState state = JobState::Measuring;
  std::string verdict;                  ///< in words, when it has ended
  std::optional<std::int64_t> n_holes;  ///< of a job that was executed
  std::vector<std::string> outputs;
  bool is_closed = false;  ///< a person has done with it
};

/// A decision of a person, as the job's record keeps it.
struct JobChoice {
  std::int64_t seq = 0;
  std::string what;  ///< in words
  std::string who;
  std::string when;
};

/// One job on the disk: what no kill may lose.
///
///   job.json            JobRecord, whole at each change
///   measurements.jsonl  a line each, on the disk before append() returns
///   choices.jsonl       the same
///
/// A line that a kill has cut off is dropped when the folder is opened again.
/// See    tests/machine/operator/job_folder_test.cc
class JobFolder {
 public:
  /// Fails  device-write; usage (a job of this id is there)
  static Expected<JobFolder> create(const std::filesystem::path& jobs, JobRecord record);
  /// Fails  file-unreadable; json-syntax; usage (it is no job's)
  static Expected<JobFolder> open(const std::filesystem::path& jobs, const std::string& id);
  JobFolder(JobFolder&& other) noexcept;
  JobFolder& operator=(JobFolder&&) = delete;
  ~JobFolder();

  const JobRecord& record() const { return record_; }
  std::filesystem::path file(std::string_view name) const { return folder_ / name; }

  /// All measurements, in the order of the measuring; empty where a line is no measurement.
  std::vector<Measurement> measurements() const;
  std::vector<JobChoice> choices() const;

  /// Fails  device-write, as the following
  Expected<void> append(const Measurement& measurement);
  Expected<void> append(const JobChoice& choice);
  /// Takes the place of the target's earlier one, at once and for good.
  Expected<void> replace(const Measurement& measurement);
  /// All targets are measured anew, with what the record says of program, machine and source.
  Expected<void> begin_anew(JobRecord record);
  Expected<void> set_state(JobState state);
  /// The same of a job that has ended.
  Expected<void> conclude(JobState state,
                          const std::string& verdict,
                          std::optional<std::int64_t> n_holes);
  Expected<void> close();
  Expected<void> add_output(const std::string& name);

 private:
  JobFolder(std::filesystem::path folder, JobRecord record)
      : folder_(std::move(folder)), record_(std::move(record)) {}
  Expected<void> write_record() const;
  Expected<void> open_journals();

  std::filesystem::path folder_;
  JobRecord record_;
  int measurements_fd_ = -1;
  int choices_fd_ = -1;
};

/// The ids of all jobs of a folder, the oldest first.
std::vector<std::string> list_jobs(const std::filesystem::path& jobs);

/// The file "picture-17.jpg" of a target.
std::string picture_name(std::int64_t seq);

/// One of "report.html", "output", "facts.json", "measurements.jsonl", "picture-17.jpg".
bool is_job_file(std::string_view name);

/// "2026-11-27-1" and nothing else.
bool is_job_id(std::string_view id);

}  // namespace panelcal::internal
