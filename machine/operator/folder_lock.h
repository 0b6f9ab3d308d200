// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <utility>

#include "calib/base/expected.h"
#include "calib/base/files/file_descriptor.h"

namespace panelcal::internal {

/// Held by the one station of a folder of jobs: two would drive one machine. A lock of the system's
/// on station.lock, freed however the program ends.
class FolderLock {
 public:
  /// Fails  usage (another station has the folder); device-write
  static Expected<FolderLock> take(const std::filesystem::path& folder);

 private:
  explicit FolderLock(FileDescriptor file) : file_(std::move(file)) {}

  FileDescriptor file_;
};

}  // namespace panelcal::internal
