// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/work/result_files.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

namespace panelcal::batch {
namespace {

namespace fs = std::filesystem;
using internal::FileDescriptor;

constexpr std::size_t kPartBytes = std::size_t{1} << 16;  ///< written at once

Diagnostic not_done(const fs::path& path, std::string_view doing, int error) {
  return {Code::DeviceWrite,
          {path.string(), 0, 0},
          fmt::format("cannot {}: {}", doing, std::generic_category().message(error)),
          ""};
}

Expected<void> make_results_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return failure(not_done(folder, "make the folder", error.value()));
  return {};
}

}  // namespace

ResultFolder::ResultFolder(fs::path folder, fs::path own, FileDescriptor lock)
    : folder_(std::move(folder)), own_(std::move(own)), lock_(std::move(lock)) {
}

Expected<ResultFolder> ResultFolder::open(const fs::path& folder, const fs::path& own) {
  PANELCAL_CHECK(make_results_folder(own));
  const fs::path lock = own / "lock";
  FileDescriptor file(::open(lock.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666));
  if (file.get() < 0) return failure(not_done(lock, "create", errno));
  if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0) {
    return failure({Code::OutputInUse,
                    {own.string(), 0, 0},
                    "another batch writes to it",
                    "a folder of its own for each batch"});
  }
  const fs::path parts = own / "parts";
  std::error_code ignored;
  fs::remove_all(parts, ignored);
  PANELCAL_CHECK(make_results_folder(parts));
  return ResultFolder(folder, own, std::move(file));
}

fs::path ResultFolder::part(std::int64_t number, std::string_view kind) const {
  return own_ / "parts" / fmt::format("{}-{}", number, kind);
}

Expected<void> ResultFolder::sync() const {
  // All files of the file system at once; of another one, publish() syncs each.
  if (::syncfs(lock_.get()) == 0) return {};
  return failure(not_done(own_, "sync to disk", errno));
}

Expected<void> ResultFolder::publish(std::span<const PartFile> files) const {
  PANELCAL_CHECK(sync());
  for (const PartFile& file : files) {
    std::error_code error;
    if (file.target.empty()) {
      fs::remove(file.part, error);
      if (error) return failure(not_done(file.part, "remove it", error.value()));
      continue;
    }
    const fs::path folder = file.target.parent_path();
    if (!folder.empty()) PANELCAL_CHECK(make_results_folder(folder));
    fs::rename(file.part, file.target, error);
    if (error.value() == EXDEV) {
      PANELCAL_TRY(const std::string bytes, read_file(file.part));
      PANELCAL_CHECK(write_file(file.target, bytes));
      fs::remove(file.part, error);
    } else if (error) {
      return failure(not_done(file.target, "put it in place", error.value()));
    }
  }
  return sync();
}

Expected<void> check_target(const fs::path& target) {
  const auto refuse = [&](int error) {
    return failure(not_done(target, "put it in place", error));
  };
  std::error_code error;
  const fs::file_status there = fs::status(target, error);
  if (there.type() == fs::file_type::none) return refuse(error.value());
  if (fs::is_directory(there) || !target.has_filename()) return refuse(EISDIR);
  // Folders that are missing are made.
  fs::path folder = fs::absolute(target, error).parent_path();
  while (!fs::exists(folder, error) && folder != folder.parent_path()) {
    folder = folder.parent_path();
  }
  if (!fs::is_directory(folder, error)) return refuse(ENOTDIR);
  if (::faccessat(AT_FDCWD, folder.c_str(), W_OK | X_OK, AT_EACCESS) != 0) return refuse(errno);
  return {};
}

PartOutput::~PartOutput() {
  if (!is_committed_ && file_.get() >= 0) ::unlink(part_.c_str());
}

Expected<void> PartOutput::fail(std::string_view doing) {
  problem_ = not_done(part_, doing, errno);
  return failure(*problem_);
}

Expected<void> PartOutput::begin() {
  buffer_.clear();
  file_ = FileDescriptor(
      ::open(part_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0666));
  if (file_.get() < 0) return fail("create");
  return {};
}

Expected<void> PartOutput::write(std::string_view bytes) {
  buffer_ += bytes;
  return buffer_.size() < kPartBytes ? Expected<void>() : flush();
}

Expected<void> PartOutput::flush() {
  std::string_view rest = buffer_;
  while (!rest.empty()) {
    const ssize_t n = ::write(file_.get(), rest.data(), rest.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail("write");
    rest.remove_prefix(static_cast<std::size_t>(n));
  }
  buffer_.clear();
  return {};
}

Expected<void> PartOutput::commit() {
  PANELCAL_CHECK(flush());
  is_committed_ = true;
  file_.close();
  return {};
}

}  // namespace panelcal::batch
