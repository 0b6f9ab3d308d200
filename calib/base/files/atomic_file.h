// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "calib/base/files/byte_sink.h"

namespace panelcal {

/// A file that appears whole under its name, or not at all.
///
/// Bytes go to a file beside the target, NAME.part-panelcal-1, which is locked; `commit` syncs it
/// to disk and renames it. It has the owner and the mode of the file that it replaces. Without
/// `commit` the destructor removes it and the old content, if any, stays. What a process that died
/// left behind under these names, the next one that writes the target removes.
///
/// Fails  device-write (cannot create, write, sync or rename; with the system's text);
///        output-in-use (an SQLite database stands there, such as a ledger)
/// See    tests/calib/base/files/atomic_file_test.cc
class AtomicFile final : public ByteSink {
 public:
  static Expected<AtomicFile> create(const std::filesystem::path& target);
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  ~AtomicFile() override;

  Expected<void> write(std::string_view bytes) override;
  Expected<void> commit();

 private:
  AtomicFile(int fd, std::filesystem::path target, std::filesystem::path temporary);
  Expected<void> flush();
  void discard() noexcept;

  int fd_;
  std::filesystem::path target_;
  std::filesystem::path temporary_;
  std::string buffer_;
};

/// Writes `bytes` to `target` through an AtomicFile.
Expected<void> write_file(const std::filesystem::path& target, std::string_view bytes);

/// Reads a whole file, or a pipe to its end.
///
/// Fails  file-unreadable (missing, a folder, no permission, larger than max_bytes)
Expected<std::string> read_file(const std::filesystem::path& path,
                                std::size_t max_bytes = std::size_t{1} << 32);

}  // namespace panelcal
