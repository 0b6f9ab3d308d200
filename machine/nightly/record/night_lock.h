// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "calib/base/expected.h"

namespace panelcal {

/// Held while a machine's night runs, so that there is only one.
///
/// A lock of the system's on <ledger>.lock: freed however the program ends, kill -9 and a power cut
/// included. The file says who holds it, for the message to a second run; if it still says so when
/// no program holds it, that run was cut off. The file stays: to remove it could take it from under
/// a run that has just opened it.
///
/// See    tests/machine/nightly/record/night_lock_test.cc
class NightLock {
 public:
  /// Fails  ledger-busy (names process and time); device-write
  static Expected<NightLock> take(const std::filesystem::path& ledger,
                                  std::chrono::sys_seconds now);
  /// The present holder of the lock, in words; empty if it is free. Writes nothing.
  static std::string holder(const std::filesystem::path& ledger);

  NightLock(NightLock&& other) noexcept;
  NightLock& operator=(NightLock&&) = delete;
  /// Frees it, and marks it as properly ended.
  ~NightLock();

  /// "process 4711 since 2026-11-21T22:00:00Z" of a run that did not end properly; empty if the
  /// last one did.
  const std::string& cut_off() const { return cut_off_; }

 private:
  NightLock(int fd, std::string cut_off) : fd_(fd), cut_off_(std::move(cut_off)) {}

  int fd_;
  std::string cut_off_;
};

}  // namespace panelcal
