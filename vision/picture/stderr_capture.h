// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

namespace panelcal::internal {

/// Takes what is written to standard error while it lives.
///
/// Picture decoders report to the process's standard error and nowhere else. Their words belong in
/// the diagnostic, not between the lines of the program. The file descriptor belongs to the whole
/// process: another thread's words of these milliseconds are taken too, and captures exclude each
/// other. If the system has no descriptor left, nothing is captured and nothing else happens.
class StderrCapture {
 public:
  static constexpr std::size_t kMaxText = 4096;

  StderrCapture();
  ~StderrCapture();
  StderrCapture(const StderrCapture&) = delete;
  StderrCapture& operator=(const StderrCapture&) = delete;

  /// Ends the capture and returns what was written, at most kMaxText bytes.
  std::string finish();

 private:
  void restore() noexcept;

  int saved_fd_ = -1;
  int memory_fd_ = -1;
};

}  // namespace panelcal::internal
