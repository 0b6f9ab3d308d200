// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/progress.h"

#include <cmath>

#include "calib/base/number_text.h"
#include <fmt/format.h>
#include <unistd.h>

namespace panelcal::batch {
namespace {

constexpr std::chrono::milliseconds kOnTerminal{200};
constexpr std::chrono::seconds kInLog{10};

/// "1:02:03", "02:03".
std::string duration_text(double seconds) {
  const auto all = static_cast<std::int64_t>(std::ceil(seconds));
  const std::int64_t hours = all / 3600;
  const std::string rest = fmt::format("{:02}:{:02}", all / 60 % 60, all % 60);
  return hours > 0 ? fmt::format("{}:{}", hours, rest) : rest;
}

}  // namespace

Progress::Progress(Console& console, std::size_t n_all, Counted counted)
    : console_(console),
      n_all_(n_all),
      counted_(counted),
      is_terminal_(::isatty(STDERR_FILENO) == 1) {
}

void Progress::count(std::int64_t n_pictures) {
  ++n_done_;
  n_pictures_ += n_pictures;
}

void Progress::count(const JobOutcome& job) {
  count(job.n_pictures);
  n_held_ += job.state == JobState::Held ? 1 : 0;
  n_failed_ += job.state == JobState::Failed ? 1 : 0;
}

void Progress::show() {
  const auto now = std::chrono::steady_clock::now();
  const auto pause = is_terminal_ ? kOnTerminal : std::chrono::milliseconds(kInLog);
  if (now - shown_ < pause) return;
  shown_ = now;
  const std::string line = text(std::chrono::duration<double>(now - begun_).count());
  if (is_terminal_) {
    console_.progress(line);
  } else {
    console_.say(line);
  }
}

std::string Progress::text(double seconds) const {
  const double rate = static_cast<double>(n_done_) / seconds;
  const bool is_of_jobs = counted_ == Counted::Jobs;
  const std::string_view noun = is_of_jobs ? "jobs" : "points";
  std::string out = fmt::format("{} of {} {}",
                                internal::grouped(static_cast<std::int64_t>(n_done_)),
                                internal::grouped(static_cast<std::int64_t>(n_all_)),
                                noun);
  if (is_of_jobs) out += fmt::format(", {} held, {} failed", n_held_, n_failed_);
  out += fmt::format("; {:.1f} {}/s", rate, noun);
  if (n_pictures_ > 0) {
    out += fmt::format(", {:.0f} pictures/s", static_cast<double>(n_pictures_) / seconds);
  }
  return out + "; " + duration_text(static_cast<double>(n_all_ - n_done_) / rate) + " left";
}

}  // namespace panelcal::batch
