// SPDX-License-Identifier: Apache-2.0
#include "calib/base/atomic_file.h"

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace panelcal {
namespace {

/// Small pieces are collected up to here; larger ones go to the file as they are.
constexpr std::size_t kBufferBytes = std::size_t{1} << 16;

/// Read at once: what fits into the processor's cache until it is copied.
constexpr std::size_t kReadBytes = std::size_t{1} << 16;

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

}  // namespace

Expected<AtomicFile> AtomicFile::create(const std::filesystem::path& target) {
  // A link stays a link: what it points to is replaced.
  std::error_code error;
  std::filesystem::path real = std::filesystem::canonical(target, error);
  if (error) real = target;
  const std::filesystem::file_status status = std::filesystem::status(real, error);
  if (std::filesystem::is_directory(status)) {
    return failure(write_failure(target, "write the file", EISDIR));
  }
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    return failure({Code::DeviceWrite,
                    {target.string(), 0, 0},
                    "it is a device or a pipe",
                    "a regular file, or - for standard output"});
  }
  std::string pattern = real.string() + ".part-XXXXXX";
  const int fd = ::mkostemp(pattern.data(), O_CLOEXEC);
  if (fd < 0) return failure(write_failure(target, "create a file beside it", errno));
  // mkostemp makes files private; a result is as readable as any file the user makes.
  const mode_t mask = ::umask(0);
  ::umask(mask);
  ::fchmod(fd, 0666 & ~mask);
  return AtomicFile(fd, real, pattern);
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
  ::close(std::exchange(fd_, -1));
  ::unlink(temporary_.c_str());
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
