// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "tools/batch/store/outcome.h"
#include "tools/cli/console.h"

namespace panelcal::batch {

/// A number of jobs, done or to be done, with what came of them.
struct JobCount {
  std::int64_t n_jobs = 0;  ///< to be done
  std::int64_t n_done = 0;
  std::int64_t n_held = 0;
  std::int64_t n_failed = 0;
  std::int64_t n_pictures = 0;

  bool is_whole() const { return n_done >= n_jobs; }
  void add(const JobOutcome& job);
  JobCount& operator+=(const JobCount& other);
};

/// The things whose progress is told; of jobs their outcomes as well.
enum class Counted : std::uint8_t { Jobs, Points };

/// Tells how far a batch is, with its rate and the time that is left: a line that is drawn anew on
/// a terminal, a line now and then in a log.
class Progress {
 public:
  Progress(Console& console, std::size_t n_all, Counted counted = Counted::Jobs);

  void count(const JobOutcome& job) { count_.add(job); }
  /// A thing without an outcome is done.
  void count(std::int64_t n_pictures);
  /// Instead of counting: all that is done, by this process or others, and a word about them.
  void set(const JobCount& count, std::string note);
  void show();

 private:
  std::string text(double seconds) const;

  Console& console_;
  Counted counted_;
  JobCount count_;
  std::optional<JobCount> before_;  ///< at the first `set`
  std::string note_;
  bool is_terminal_;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point shown_ = begun_;
};

}  // namespace panelcal::batch
