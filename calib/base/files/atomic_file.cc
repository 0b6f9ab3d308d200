// SPDX-License-Identifier: Apache-2.0
#include "calib/base/files/atomic_file.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>
#include <vector>

#include "calib/base/files/file_rights.h"
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace panelcal {
namespace {

/// Small pieces are collected up to here; larger ones go to the file as they are.
constexpr std::size_t kBufferBytes = std::size_t{1} << 16;

/// Read at once: what fits into the processor's cache until it is copied.
constexpr std::size_t kReadBytes = std::size_t{1} << 16;

constexpr const char* kOwnFile = "a file of its own for each output";

std::string system_text(int error) {
  return std::generic_category().message(error);
}

Diagnostic write_failure(const std::filesystem::path& path, std::string_view doing, int error) {
  return {Code::DeviceWrite,
          {path.string(), 0, 0},
          "cannot " + std::string(doing) + ": " + system_text(error),
          ""};
}

Expected<void> write_all(int fd, const std::filesystem::path& path, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return failure(write_failure(path, "write", errno));
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return {};
}

Diagnostic unreadable(const std::filesystem::path& path, const std::string& why) {
  return {Code::FileUnreadable, {path.string(), 0, 0}, why, "a readable file"};
}

/// Makes a rename durable. Some file systems cannot sync a folder; that is not our error.
void sync_parent_of(const std::filesystem::path& path) {
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);
  ::close(fd);
}

/// True if a file begins as every SQLite database does. Only the ledger writes those, in place.
bool is_database(const std::filesystem::path& path) {
  constexpr std::string_view kMagic("SQLite format 3\0", 16);
  std::array<char, kMagic.size()> head{};
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const ssize_t n = ::pread(fd, head.data(), head.size(), 0);
  ::close(fd);
  return n == static_cast<ssize_t>(head.size()) &&
         std::string_view(head.data(), head.size()) == kMagic;
}

/// A file that its writer has locked, until it is closed.
struct PartFile {
  int fd = -1;
  std::filesystem::path path;
};

/// True if `path` still names the file that is open.
bool is_named(int fd, const std::filesystem::path& path) {
  struct stat open {
  }, named{};
  return ::fstat(fd, &open) == 0 && ::lstat(path.c_str(), &named) == 0 &&
         open.st_dev == named.st_dev && open.st_ino == named.st_ino;
}

/// Removes the part that a process left behind when it died; a living one's stays, which is locked.
void sweep(const std::filesystem::path& part) {
  const int fd = ::open(part.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return;
  struct stat status {};
  const bool is_file = ::fstat(fd, &status) == 0 && S_ISREG(status.st_mode);
  // The process that removes or renames it holds its lock: nothing happens to the name between.
  if (is_file && ::flock(fd, LOCK_EX | LOCK_NB) == 0 && is_named(fd, part)) ::unlink(part.c_str());
  ::close(fd);
}

/// As many processes may write one file at once.
constexpr int kMaxParts = 100;

std::filesystem::path part_name(std::filesystem::path real, int i) {
  return real += ".part-panelcal-" + std::to_string(i);
}

/// Sweeps NAME.part-panelcal-1, -2, ... up to the first that is not there.
void sweep_all(const std::filesystem::path& real) {
  struct stat ignored {};
  for (int i = 1; i <= kMaxParts; ++i) {
    const std::filesystem::path part = part_name(real, i);
    if (::lstat(part.c_str(), &ignored) != 0) return;
    sweep(part);
  }
}

/// The first of NAME.part-panelcal-1, -2, ... that no living process writes.
Expected<PartFile> open_part(const std::filesystem::path& real,
                             const std::filesystem::path& target) {
  sweep_all(real);
  int error = EEXIST;
  for (int i = 1; i <= kMaxParts; ++i) {
    std::filesystem::path part = part_name(real, i);
    const int fd = ::open(part.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (fd < 0 && errno == EEXIST) continue;
    if (fd < 0) {
      error = errno;
      break;
    }
    // If files cannot be locked, no process sweeps either.
    ::flock(fd, LOCK_EX);
    if (is_named(fd, part)) return PartFile{fd, std::move(part)};
    // Another process swept it before it was locked.
    ::close(fd);
  }
  return failure(write_failure(target, "create a file beside it", error));
}

/// Those of the file that is replaced, as far as the system lets us; of a new one, those of any
/// file that the user makes.
void give_rights(int fd, const struct stat* replaced) {
  if (replaced == nullptr) {
    ::fchmod(fd, usual_file_rights());
    return;
  }
  // The group at least, where only the owner of the system may give files away.
  if (::fchown(fd, replaced->st_uid, replaced->st_gid) != 0) {
    static_cast<void>(::fchown(fd, static_cast<uid_t>(-1), replaced->st_gid) == 0);
  }
  ::fchmod(fd, replaced->st_mode & 07777);
}

}  // namespace

Expected<AtomicFile> AtomicFile::create(const std::filesystem::path& target) {
  // A link stays a link: what it points to is replaced.
  std::error_code error;
  std::filesystem::path real = std::filesystem::canonical(target, error);
  if (error) real = target;
  struct stat present {};
  const bool is_there = ::stat(real.c_str(), &present) == 0;
  if (is_there && S_ISDIR(present.st_mode)) {
    return failure(write_failure(target, "write the file", EISDIR));
  }
  if (is_there && !S_ISREG(present.st_mode)) {
    return failure({Code::DeviceWrite,
                    {target.string(), 0, 0},
                    "it is a device or a pipe",
                    "a regular file, or - for standard output"});
  }
  if (is_there && is_database(real)) {
    return failure({Code::OutputInUse,
                    {target.string(), 0, 0},
                    quoted(target.string()) + " is a ledger or another database",
                    kOwnFile});
  }
  PANELCAL_TRY(auto part, open_part(real, target));
  give_rights(part.fd, is_there ? &present : nullptr);
  return AtomicFile(part.fd, std::move(real), std::move(part.path));
}

AtomicFile::AtomicFile(int fd, std::filesystem::path target, std::filesystem::path temporary)
    : fd_(fd), target_(std::move(target)), temporary_(std::move(temporary)) {
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      target_(std::move(other.target_)),
      temporary_(std::move(other.temporary_)),
      buffer_(std::move(other.buffer_)) {
}

AtomicFile::~AtomicFile() {
  discard();
}

void AtomicFile::discard() noexcept {
  if (fd_ < 0) return;
  // As long as it is locked no other process has the name.
  ::unlink(temporary_.c_str());
  ::close(std::exchange(fd_, -1));
}

Expected<void> AtomicFile::write(std::string_view bytes) {
  if (buffer_.size() + bytes.size() < kBufferBytes) {
    buffer_ += bytes;
    return {};
  }
  PANELCAL_CHECK(flush());
  if (bytes.size() >= kBufferBytes) return write_all(fd_, target_, bytes);
  buffer_ = bytes;
  return {};
}

Expected<void> AtomicFile::flush() {
  PANELCAL_CHECK(write_all(fd_, target_, buffer_));
  buffer_.clear();
  return {};
}

Expected<void> AtomicFile::commit() {
  PANELCAL_CHECK(flush());
  if (::fsync(fd_) != 0) return failure(write_failure(target_, "sync to disk", errno));
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) {
    return failure(write_failure(target_, "put it in place", errno));
  }
  ::close(std::exchange(fd_, -1));
  sync_parent_of(target_);
  return {};
}

Expected<void> write_file(const std::filesystem::path& target, std::string_view bytes) {
  PANELCAL_TRY(AtomicFile file, AtomicFile::create(target));
  PANELCAL_CHECK(file.write(bytes));
  return file.commit();
}

Expected<std::string> read_file(const std::filesystem::path& path, std::size_t max_bytes) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return failure(unreadable(path, system_text(errno)));
  struct stat status {};
  if (::fstat(fd, &status) == 0 && S_ISDIR(status.st_mode)) {
    ::close(fd);
    return failure(unreadable(path, "it is a folder"));
  }
  std::string text;
  // Growing piece by piece would take the memory of one and a half files.
  const auto expected_bytes = static_cast<std::size_t>(status.st_size);
  if (S_ISREG(status.st_mode) && expected_bytes <= max_bytes) text.reserve(expected_bytes);
  std::vector<char> chunk(kReadBytes);
  while (true) {
    const ssize_t n = ::read(fd, chunk.data(), chunk.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const int error = errno;
      ::close(fd);
      return failure(unreadable(path, system_text(error)));
    }
    if (n == 0) break;
    if (text.size() + static_cast<std::size_t>(n) > max_bytes) {
      ::close(fd);
      return failure(unreadable(path, "larger than " + std::to_string(max_bytes) + " bytes"));
    }
    text.append(chunk.data(), static_cast<std::size_t>(n));
  }
  ::close(fd);
  return text;
}

}  // namespace panelcal
