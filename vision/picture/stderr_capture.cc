// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/stderr_capture.h"

#include <cstdio>
#include <iostream>
#include <mutex>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace panelcal::internal {
namespace {

std::mutex& one_at_a_time() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

StderrCapture::StderrCapture() {
  one_at_a_time().lock();
  memory_fd_ = ::memfd_create("decoder-messages", MFD_CLOEXEC);
  if (memory_fd_ < 0) return;
  std::cerr.flush();
  std::fflush(stderr);
  saved_fd_ = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  if (saved_fd_ >= 0) ::dup2(memory_fd_, STDERR_FILENO);
}

StderrCapture::~StderrCapture() {
  restore();
  if (memory_fd_ >= 0) ::close(memory_fd_);
  one_at_a_time().unlock();
}

void StderrCapture::restore() noexcept {
  if (saved_fd_ < 0) return;
  std::cerr.flush();
  std::fflush(stderr);
  ::dup2(saved_fd_, STDERR_FILENO);
  ::close(std::exchange(saved_fd_, -1));
}

std::string StderrCapture::finish() {
  const bool captured = saved_fd_ >= 0;
  restore();
  if (!captured) return {};
  std::string text(kMaxText, '\0');
  const ssize_t n = ::pread(memory_fd_, text.data(), text.size(), 0);
  text.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

}  // namespace panelcal::internal
