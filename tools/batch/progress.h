// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "tools/batch/store/outcome.h"
#include "tools/cli/console.h"

namespace panelcal::batch {

/// The things whose progress is told; of jobs their outcomes as well.
enum class Counted : std::uint8_t { Jobs, Points };

/// Tells how far a batch is, with its rate and the time that is left: a line that is drawn anew on
/// a terminal, a line now and then in a log.
class Progress {
 public:
  Progress(Console& console, std::size_t n_all, Counted counted = Counted::Jobs);

  void count(const JobOutcome& job);
  /// A thing without an outcome is done.
  void count(std::int64_t n_pictures);
  void show();

 private:
  std::string text(double seconds) const;

  Console& console_;
  std::size_t n_all_;
  Counted counted_;
  std::size_t n_done_ = 0;
  std::int64_t n_pictures_ = 0;
  std::size_t n_held_ = 0;
  std::size_t n_failed_ = 0;
  bool is_terminal_;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point shown_ = begun_;
};

}  // namespace panelcal::batch
