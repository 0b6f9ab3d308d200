// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "calib/base/expected.h"

namespace panelcal::internal {

/// Held by the one station of a folder of jobs: two would drive one machine. A lock of the system's
/// on station.lock, freed however the program ends.
class FolderLock {
 public:
  /// Fails  usage (another station has the folder); device-write
  static Expected<FolderLock> take(const std::filesystem::path& folder);
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock();

 private:
  explicit FolderLock(int fd) : fd_(fd) {}

  int fd_;
};

}  // namespace panelcal::internal
