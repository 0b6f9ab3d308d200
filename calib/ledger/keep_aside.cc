// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <string>

#include "calib/ledger/database/chain.h"
#include "calib/ledger/database/file.h"
#include "calib/ledger/database/sqlite.h"
#include "calib/ledger/ledger.h"
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace panelcal {
namespace {

/// Held by the program that moves a ledger in this folder aside: without it the second of two
/// programs could move away the new ledger that the first has started.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& path) {
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    fd_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd_ >= 0) ::flock(fd_, LOCK_EX);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock() {
    if (fd_ >= 0) ::close(fd_);
  }

 private:
  int fd_ = -1;
};

/// `20261121T083738Z`: a time as it can stand in a file's name anywhere.
std::string compact(std::chrono::sys_seconds time) {
  std::string text = iso_8601(time);
  std::erase_if(text, [](char c) { return c == '-' || c == ':'; });
  return text;
}

Expected<void> examine_all(const std::filesystem::path& path, const LedgerOptions& options) {
  using internal::SqliteConnection;
  PANELCAL_TRY(const std::unique_ptr<SqliteConnection> connection,
               internal::open_ledger_file(path, SqliteConnection::Mode::Write, options));
  PANELCAL_CHECK(internal::check_all(*connection));
  return {};
}

}  // namespace

Expected<std::filesystem::path> Ledger::keep_aside(const std::filesystem::path& path,
                                                   const Clock& clock,
                                                   const LedgerOptions& options) {
  const FolderLock lock(path);
  const Expected<void> good = examine_all(path, options);
  if (good) {
    return failure({Code::LedgerEntryInvalid,
                    {path.string(), 0, 0},
                    "the ledger is not damaged",
                    "a damaged one"});
  }
  if (good.error().code != Code::LedgerCorrupt) return failure(good.error());
  return internal::move_aside(path, ".corrupt-" + compact(clock()));
}

}  // namespace panelcal
