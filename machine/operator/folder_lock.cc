// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/folder_lock.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>

namespace panelcal::internal {

Expected<FolderLock> FolderLock::take(const std::filesystem::path& folder) {
  constexpr mode_t kMode = 0666;
  const std::filesystem::path file = folder / "station.lock";
  FileDescriptor opened(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, kMode));
  if (opened.get() < 0) {
    return failure({Code::DeviceWrite,
                    {file.string(), 0, 0},
                    std::system_category().message(errno),
                    "a folder that may be written"});
  }
  if (::flock(opened.get(), LOCK_EX | LOCK_NB) == 0) return FolderLock(std::move(opened));
  return failure({Code::Usage,
                  {folder.string(), 0, 0},
                  "another panelcal serve has this folder of jobs",
                  "one server for one machine"});
}

}  // namespace panelcal::internal
