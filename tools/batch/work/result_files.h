// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "calib/base/files/file_descriptor.h"
#include "machine/job/output/output.h"

namespace panelcal::batch {

/// A file of results that is whole but not yet seen under its name.
struct PartFile {
  std::filesystem::path part;
  std::filesystem::path target;  ///< empty: a file that must not be there any more is `part`
};

/// The folder of a batch's results, locked against a second batch as long as this lives.
///
///   store.sqlite          docs/formats/store.md
///   jobs/ID/              facts.json, and the corrected program if no column names its place
///   parts/                of jobs that are under way
///   lock
///
/// A shard of a batch has jobs/ in common with the others, and the rest in a folder of its own.
///
/// A file is written to parts/ without a sync, and many are synced at once before they get their
/// names: one sync a file would take longer than most jobs.
///
/// See    tests/tools/batch_test.py; docs/decisions/batch.md
class ResultFolder {
 public:
  /// Makes the folder where it is missing, and clears parts/.
  ///
  /// Fails  device-write; output-in-use (another batch writes there)
  static Expected<ResultFolder> open(const std::filesystem::path& folder) {
    return open(folder, folder);
  }
  static Expected<ResultFolder> open(const std::filesystem::path& folder,
                                     const std::filesystem::path& own);

  /// Of jobs/.
  const std::filesystem::path& path() const { return folder_; }
  /// Of everything else.
  const std::filesystem::path& own() const { return own_; }
  std::filesystem::path part(std::int64_t number, std::string_view kind) const;

  /// Puts files in place: when it returns, they and their names are on disk.
  ///
  /// Fails  device-write
  Expected<void> publish(std::span<const PartFile> files) const;

 private:
  ResultFolder(std::filesystem::path folder,
               std::filesystem::path own,
               internal::FileDescriptor lock);
  Expected<void> sync() const;

  std::filesystem::path folder_;
  std::filesystem::path own_;
  internal::FileDescriptor lock_;
};

/// Checks that a file can get this name, as far as that is known before it is written.
///
/// Fails  device-write: a folder has the name, or none can be made or written to above it
Expected<void> check_target(const std::filesystem::path& target);

/// A job's output that goes to a part and stays there until the results are published.
class PartOutput final : public JobOutput {
 public:
  explicit PartOutput(std::filesystem::path part) : part_(std::move(part)) {}
  PartOutput(const PartOutput&) = delete;
  PartOutput& operator=(const PartOutput&) = delete;
  /// Removes what was not committed.
  ~PartOutput() override;

  Expected<void> begin() override;
  Expected<void> write(std::string_view bytes) override;
  Expected<void> commit() override;
  const std::filesystem::path& path() const { return part_; }
  bool is_committed() const { return is_committed_; }
  /// The disk failed: this ends the batch, not the job.
  const std::optional<Diagnostic>& problem() const { return problem_; }

 private:
  Expected<void> fail(std::string_view doing);
  Expected<void> flush();

  std::filesystem::path part_;
  internal::FileDescriptor file_;
  std::string buffer_;
  bool is_committed_ = false;
  std::optional<Diagnostic> problem_;
};

}  // namespace panelcal::batch
