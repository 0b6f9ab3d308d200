// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/output/progress.h"

#include <cmath>
#include <utility>

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
      counted_(counted),
      count_{.n_jobs = static_cast<std::int64_t>(n_all)},
      is_terminal_(::isatty(STDERR_FILENO) == 1) {
}

void JobCount::add(const JobOutcome& job) {
  ++n_done;
  n_held += job.state == JobState::Held ? 1 : 0;
  n_failed += job.state == JobState::Failed ? 1 : 0;
  n_pictures += job.n_pictures;
}

JobCount& JobCount::operator+=(const JobCount& other) {
  n_jobs += other.n_jobs;
  n_done += other.n_done;
  n_held += other.n_held;
  n_failed += other.n_failed;
  n_pictures += other.n_pictures;
  return *this;
}

void Progress::count(std::int64_t n_pictures) {
  ++count_.n_done;
  count_.n_pictures += n_pictures;
}

void Progress::set(const JobCount& count, std::string note) {
  const std::int64_t n_jobs = count_.n_jobs;
  count_ = count;
  count_.n_jobs = n_jobs;
  if (!before_) before_ = count_;
  note_ = std::move(note);
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
  const JobCount before = before_.value_or(JobCount{});
  const double rate = static_cast<double>(count_.n_done - before.n_done) / seconds;
  const bool is_of_jobs = counted_ == Counted::Jobs;
  const std::string_view noun = is_of_jobs ? "jobs" : "points";
  std::string out = fmt::format(
      "{} of {} {}", internal::grouped(count_.n_done), internal::grouped(count_.n_jobs), noun);
  if (is_of_jobs) out += fmt::format(", {} held, {} failed", count_.n_held, count_.n_failed);
  out += "; ";
  if (!note_.empty()) out += note_ + "; ";
  out += fmt::format("{:.1f} {}/s", rate, noun);
  if (count_.n_pictures > 0) {
    const double n_pictures = static_cast<double>(count_.n_pictures - before.n_pictures);
    out += fmt::format(", {:.0f} pictures/s", n_pictures / seconds);
  }
  if (rate <= 0) return out;
  return out + "; " + duration_text(static_cast<double>(count_.n_jobs - count_.n_done) / rate) +
         " left";
}

}  // namespace panelcal::batch
