// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/cluster/slurm_array.h"

#include <algorithm>
#include <chrono>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "calib/base/interruption.h"
#include "calib/base/json/facts.h"
#include "machine/devices/commands/external_program.h"
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

namespace panelcal::batch {
namespace {

namespace fs = std::filesystem;
using facts::Json;

constexpr const char* kStateFile = "array.json";
constexpr const char* kScriptFile = "array.sh";
/// A controller under load answers after many seconds.
constexpr double kMaxAnswer_s = 120;
/// The queue is looked at after a twentieth of the time so far: soon in a small batch, and no load
/// on the controller in a large one.
constexpr double kMinPause_s = 0.5;
constexpr double kMaxPause_s = 10;

/// A file name as sbatch takes it: it replaces what follows a percent sign.
std::string without_patterns(const std::string& path) {
  std::string out;
  for (const char c : path) out += c == '%' ? std::string("%%") : std::string(1, c);
  return out;
}

Diagnostic other_array(const fs::path& file, std::string what) {
  return {Code::Usage,
          {file.string(), 0, 0},
          std::move(what),
          "the same options, or `panelcal batch merge` once its tasks have ended"};
}

}  // namespace

std::string shell_text(std::span<const std::string> words) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_=+,./:@";
  std::string out;
  for (const std::string& word : words) {
    if (!out.empty()) out += ' ';
    if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) {
      out += word;
      continue;
    }
    out += '\'';
    for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    out += '\'';
  }
  return out;
}

SlurmArray::SlurmArray(ArrayTerms terms, Console& console)
    : terms_(std::move(terms)),
      console_(console),
      progress_(console, static_cast<std::size_t>(terms_.n_jobs)) {
}

bool SlurmArray::is_under_way(const fs::path& results) {
  std::error_code ignored;
  return fs::exists(results / "slurm" / kStateFile, ignored);
}

Expected<std::vector<std::int64_t>> SlurmArray::run() {
  const fs::path state = folder() / kStateFile;
  if (is_under_way(terms_.results)) {
    PANELCAL_TRY(const std::string text, read_file(state));
    PANELCAL_CHECK(go_on(text));
  } else {
    PANELCAL_CHECK(begin());
  }
  const auto begun = std::chrono::steady_clock::now();
  while (true) {
    const auto all_ended = look();
    if (interruption() != 0) {
      console_.end_progress();
      console_.say(job_words() + " goes on: --resume follows it again, scancel ends it");
      return failure(check_interruption().error());
    }
    if (!all_ended) return failure(all_ended.error());
    if (*all_ended) break;
    const double so_far_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    sleep_for(seconds(std::clamp(so_far_s / 20, kMinPause_s, kMaxPause_s)));
  }
  console_.end_progress();
  std::vector<std::int64_t> given_up;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (parts_[i].is_given_up) given_up.push_back(static_cast<std::int64_t>(i) + 1);
  }
  // From here on the stores of the shards are all that is left of it.
  std::error_code error;
  fs::remove(state, error);
  if (error) return failure({Code::DeviceWrite, {state.string(), 0, 0}, error.message(), ""});
  return given_up;
}

Expected<void> SlurmArray::begin() {
  const std::int64_t n_asked = terms_.n_shards > 0 ? terms_.n_shards : kUsualShards;
  terms_.n_shards = std::clamp<std::int64_t>(terms_.n_jobs, 1, n_asked);
  parts_.resize(static_cast<std::size_t>(terms_.n_shards));
  std::error_code error;
  fs::create_directories(folder(), error);
  if (error) return failure({Code::DeviceWrite, {folder().string(), 0, 0}, error.message(), ""});
  const std::string where = fs::absolute(terms_.results, error).string();
  const std::string what =
      fmt::format("{} {} {}", where, iso_8601(system_clock()()), static_cast<long>(::getpid()));
  name_ = "panelcal-" + sha256(what).substr(0, 16);
  PANELCAL_CHECK(write_script());
  return save();
}

Expected<void> SlurmArray::go_on(const std::string& text) {
  const fs::path file = folder() / kStateFile;
  try {
    const Json state = Json::parse(text);
    const auto starts = state.at("starts").get<std::vector<std::int64_t>>();
    const auto n_shards = static_cast<std::int64_t>(starts.size());
    if (state.at("command").get<std::vector<std::string>>() != terms_.command) {
      return failure(other_array(file, "an array with other options is under way"));
    }
    if (terms_.n_shards > 0 && terms_.n_shards != n_shards) {
      return failure(
          other_array(file, fmt::format("an array of {} shards is under way", n_shards)));
    }
    terms_.n_shards = n_shards;
    name_ = state.at("name").get<std::string>();
    jobs_ = state.at("jobs").get<std::vector<std::string>>();
    parts_.resize(starts.size());
    for (std::size_t i = 0; i < starts.size(); ++i) parts_[i].n_starts = starts[i];
  } catch (const Json::exception& error) {
    return failure(other_array(file, std::string("not the state of an array: ") + error.what()));
  }
  console_.say("following " + job_words());
  return {};
}

Expected<void> SlurmArray::save() const {
  std::vector<std::int64_t> starts;
  for (const Part& part : parts_) starts.push_back(part.n_starts);
  const Json state = {
      {"name", name_}, {"jobs", jobs_}, {"starts", starts}, {"command", terms_.command}};
  return write_file(folder() / kStateFile, facts::text(state));
}

Expected<void> SlurmArray::write_script() const {
  const std::string script = fmt::format(
      "#!/bin/sh\n"
      "# A shard of a batch of panelcal: task SLURM_ARRAY_TASK_ID of {0}. Started again, it goes\n"
      "# on where it was. By hand: sbatch --array=1-{0} array.sh\n"
      "exec {1} --threads \"${{SLURM_CPUS_PER_TASK:-1}}\" --shard \"$SLURM_ARRAY_TASK_ID/{0}\"\n",
      terms_.n_shards,
      shell_text(terms_.command));
  return write_file(folder() / kScriptFile, script);
}

Expected<void> SlurmArray::submit(const std::vector<std::int64_t>& numbers) {
  std::error_code error;
  const fs::path folder_here = fs::absolute(folder(), error);
  const std::vector<std::string> words = {
      "sbatch",
      "--parsable",
      "--requeue",
      "--open-mode=append",
      "--job-name=" + name_,
      fmt::format("--array={}", fmt::join(numbers, ",")),
      fmt::format("--cpus-per-task={}", terms_.n_threads),
      "--chdir=" + fs::current_path(error).string(),
      "--output=" + without_patterns(folder_here.string()) + "/%A_%a.log",
      (folder_here / kScriptFile).string()};
  const auto answer = internal::run_program(words, seconds(kMaxAnswer_s));
  if (!answer) {
    // Refused, and not submitted without an answer: other options may be tried.
    const auto tasks = jobs_.empty() ? queued() : failure(answer.error());
    if (tasks && tasks->empty()) fs::remove(folder() / kStateFile, error);
    return failure(answer.error());
  }
  // "1234", or "1234;cluster".
  jobs_.push_back(answer->substr(0, answer->find(';')));
  const bool is_first = jobs_.size() == 1;
  for (const std::int64_t number : numbers) {
    Part& part = parts_[static_cast<std::size_t>(number - 1)];
    if (part.n_starts > 0) {
      console_.say(fmt::format(
          "shard {} of {} ended before it was done: submitted again", number, terms_.n_shards));
    }
    ++part.n_starts;
  }
  if (is_first) {
    console_.say(fmt::format("submitted {} of {} shards", job_words(), terms_.n_shards));
  }
  return save();
}

Expected<bool> SlurmArray::look() {
  // Before the shards: one that leaves the queue has written its last words by then.
  const auto tasks = queued();
  PANELCAL_CHECK(check_interruption());
  if (!tasks && jobs_.empty()) return failure(tasks.error());
  if (!tasks && is_queue_known_) {
    console_.end_progress();
    console_.print(tasks.error());
    console_.say("asking again until the controller answers");
  }
  is_queue_known_ = tasks.has_value();
  JobCount all;
  std::vector<std::int64_t> again;
  std::int64_t n_running = 0;
  bool all_ended = true;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    const auto number = static_cast<std::int64_t>(i) + 1;
    const bool is_queued = tasks && tasks->contains(number);
    if (is_queued && tasks->at(number) == "R") ++n_running;
    if (!part.is_done) {
      const auto count = read_count(shard_folder(terms_.results, Shard{number, terms_.n_shards}));
      if (count) part.count = *count;
      part.is_done = count && count->is_whole();
    }
    all += part.count;
    if (part.is_done || part.is_given_up) continue;
    if (tasks && !is_queued) {
      part.is_given_up = part.n_starts > terms_.n_retries;
      if (!part.is_given_up) again.push_back(number);
    }
    all_ended = all_ended && part.is_given_up;
  }
  if (!again.empty()) PANELCAL_CHECK(submit(again));
  const std::size_t n_queued = tasks ? tasks->size() : 0;
  progress_.set(
      all,
      fmt::format(
          "{} shards run, {} wait", n_running, n_queued - static_cast<std::size_t>(n_running)));
  progress_.show();
  return all_ended;
}

Expected<std::map<std::int64_t, std::string>> SlurmArray::queued() const {
  const std::vector<std::string> words = {
      "squeue", "--noheader", "--array", "--name=" + name_, "--format=%K %t"};
  PANELCAL_TRY(const std::string answer, internal::run_program(words, seconds(kMaxAnswer_s)));
  std::map<std::int64_t, std::string> out;
  std::istringstream lines(answer);
  std::int64_t number = 0;
  std::string state;
  while (lines >> number >> state) out[number] = state;
  return out;
}

std::string SlurmArray::job_words() const {
  return fmt::format("array {} ({})", fmt::join(jobs_, ", "), name_);
}

}  // namespace panelcal::batch
