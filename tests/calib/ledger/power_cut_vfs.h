// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "calib/base/statistics/random.h"

namespace panelcal::test {

/// Orders of SQLite to the disk, in order.
struct DiskOrder {
  enum class Kind : std::uint8_t { Write, Truncate, Sync, Delete, SyncedDelete };
  Kind kind = Kind::Write;
  std::string file;
  std::int64_t offset = 0;  ///< of a truncation: the new size
  std::string bytes = {};
};

/// While it lives, SQLite's default files are those of the system, and every order is noted.
/// One at a time.
class DiskRecorder {
 public:
  DiskRecorder();
  DiskRecorder(const DiskRecorder&) = delete;
  DiskRecorder& operator=(const DiskRecorder&) = delete;
  ~DiskRecorder();

  const std::vector<DiskOrder>& orders() const;
};

using DiskContent = std::map<std::string, std::string>;  ///< by file

/// Content that may be left on the disk if the power goes after the first n orders. Synced content
/// is there. Of the later orders to a file each may have been carried out or not, and a write in
/// part (up to a border of 512 bytes); so may the making and deleting of the file itself.
DiskContent after_power_cut(const DiskContent& start,
                            const std::vector<DiskOrder>& orders,
                            std::size_t n,
                            Random& random);

}  // namespace panelcal::test
