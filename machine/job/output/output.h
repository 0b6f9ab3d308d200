// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include "calib/base/expected.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/files/byte_sink.h"
#include "calib/base/files/spool.h"

namespace panelcal {

/// The receiver of a corrected program: whole or not at all.
class JobOutput : public ByteSink {
 public:
  /// Begins anew: bytes that came before are dropped.
  ///
  /// Fails  device-write
  virtual Expected<void> begin() = 0;
  /// Lets the bytes be seen.
  ///
  /// Fails  device-write
  virtual Expected<void> commit() = 0;
};

/// A file that appears whole under its name, or not at all.
class FileOutput final : public JobOutput {
 public:
  explicit FileOutput(std::filesystem::path target) : target_(std::move(target)) {}

  Expected<void> begin() override;
  /// Precondition: begun
  Expected<void> write(std::string_view bytes) override { return file_->write(bytes); }
  Expected<void> commit() override { return file_->commit(); }

 private:
  std::filesystem::path target_;
  std::optional<AtomicFile> file_;
};

/// An output that cannot be taken back, such as standard output: bytes wait for the commit.
///
/// See    tests/machine/job/output/output_test.cc
class SpooledOutput final : public JobOutput {
 public:
  /// Precondition: the target outlives this
  explicit SpooledOutput(ByteSink& target) : target_(target) {}

  Expected<void> begin() override {
    spool_.clear();
    return {};
  }
  Expected<void> write(std::string_view bytes) override { return spool_.write(bytes); }
  /// Fails  also what the target reports
  Expected<void> commit() override {
    has_begun_to_commit_ = true;
    return spool_.pass_to(target_);
  }
  /// Something may have gone to the target.
  bool has_begun_to_commit() const { return has_begun_to_commit_; }

 private:
  ByteSink& target_;
  Spool spool_;
  bool has_begun_to_commit_ = false;
};

}  // namespace panelcal
