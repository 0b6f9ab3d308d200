// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/regular_file.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include "calib/base/files/file_descriptor.h"
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace panelcal::internal {
Expected<std::string> read_regular(const std::filesystem::path& folder,
                                   const std::string& name,
                                   std::size_t max_bytes) {
  const auto refuse = [&](std::string why) {
    return failure({Code::FileUnreadable, {(folder / name).string(), 0, 0}, std::move(why), ""});
  };
  const FileDescriptor place(
      ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  if (place.get() < 0) return refuse(std::system_category().message(errno));
  const FileDescriptor file(
      ::openat(place.get(), name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (file.get() < 0) return refuse(std::system_category().message(errno));
  struct stat status = {};
  if (::fstat(file.get(), &status) != 0) return refuse(std::system_category().message(errno));
  if (!S_ISREG(status.st_mode)) return refuse("not a regular file");
  if (static_cast<std::size_t>(status.st_size) > max_bytes) return refuse("too large");
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  std::size_t n_read = 0;
  while (n_read < bytes.size()) {
    const ssize_t n = ::read(file.get(), bytes.data() + n_read, bytes.size() - n_read);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return refuse(std::system_category().message(errno));
    if (n == 0) break;  // cut off meanwhile
    n_read += static_cast<std::size_t>(n);
  }
  bytes.resize(n_read);
  return bytes;
}

}  // namespace panelcal::internal
