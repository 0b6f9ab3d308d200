// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/folder_lock.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace panelcal::internal {

Expected<FolderLock> FolderLock::take(const std::filesystem::path& folder) {
  constexpr mode_t kMode = 0666;
  const std::filesystem::path file = folder / "station.lock";
  const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, kMode);
  if (fd < 0) {
    return failure({Code::DeviceWrite,
                    {file.string(), 0, 0},
                    std::system_category().message(errno),
                    "a folder that may be written"});
  }
  FolderLock lock(fd);
  if (::flock(fd, LOCK_EX | LOCK_NB) == 0) return lock;
  return failure({Code::Usage,
                  {folder.string(), 0, 0},
                  "another panelcal serve has this folder of jobs",
                  "one server for one machine"});
}

FolderLock::FolderLock(FolderLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {
}

FolderLock::~FolderLock() {
  if (fd_ >= 0) ::close(fd_);
}

}  // namespace panelcal::internal
