// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/record/night_lock.h"

#include <array>
#include <cerrno>
#include <string_view>
#include <system_error>
#include <utility>

#include "calib/base/clock.h"
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

namespace panelcal {
namespace {

std::filesystem::path lock_file(const std::filesystem::path& ledger) {
  std::filesystem::path path = ledger;
  path += ".lock";
  return path;
}

/// The whole file, for writing. Locks of open file descriptions and not of processes: closing
/// another descriptor of the file does not free them.
struct flock whole_file() {
  struct flock lock = {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return lock;
}

/// Content of the file: its one line without the end.
std::string content(int fd) {
  std::array<char, 200> bytes{};
  const ssize_t n = ::pread(fd, bytes.data(), bytes.size(), 0);
  const std::string text(bytes.data(), n > 0 ? static_cast<std::size_t>(n) : 0);
  return text.substr(0, text.find('\n'));
}

/// The line of `text` that is to be believed: another program may have written anything there.
std::string owner_words(const std::string& text) {
  return text.empty() ? std::string("a process without a name") : quoted(text, 100);
}

Diagnostic write_problem(const std::filesystem::path& path, int error) {
  return {Code::DeviceWrite,
          {path.string(), 0, 0},
          "the night's lock cannot be written: " + std::generic_category().message(error),
          "a folder that may be written"};
}

}  // namespace

Expected<NightLock> NightLock::take(const std::filesystem::path& ledger,
                                    std::chrono::sys_seconds now) {
  const std::filesystem::path path = lock_file(ledger);
  const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (fd < 0) return failure(write_problem(path, errno));
  struct flock lock = whole_file();
  if (::fcntl(fd, F_OFD_SETLK, &lock) != 0) {
    const int error = errno;
    const std::string who = owner_words(content(fd));
    ::close(fd);
    if (error != EAGAIN && error != EACCES) return failure(write_problem(path, error));
    return failure({Code::LedgerBusy,
                    {path.string(), 0, 0},
                    "another night of this machine runs: " + who,
                    "one at a time; wait for it, or end it"});
  }
  // From here on the destructor frees it.
  NightLock taken(fd, content(fd));
  const std::string line = fmt::format("process {} since {}\n", ::getpid(), iso_8601(now));
  const bool is_written = ::ftruncate(fd, 0) == 0 && ::pwrite(fd, line.data(), line.size(), 0) ==
                                                         static_cast<ssize_t>(line.size());
  if (!is_written) return failure(write_problem(path, errno));
  return taken;
}

std::string NightLock::holder(const std::filesystem::path& ledger) {
  const int fd = ::open(lock_file(ledger).c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return "";
  struct flock lock = whole_file();
  const bool is_held = ::fcntl(fd, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
  std::string who = is_held ? owner_words(content(fd)) : "";
  ::close(fd);
  return who;
}

NightLock::NightLock(NightLock&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), cut_off_(std::move(other.cut_off_)) {
}

NightLock::~NightLock() {
  if (fd_ < 0) return;
  // If this fails the next run is told of a run that was cut off: no harm.
  static_cast<void>(::ftruncate(fd_, 0) == 0);
  ::close(fd_);
}

}  // namespace panelcal
