// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <deque>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "calib/base/amount.h"
#include "calib/base/clock.h"
#include "calib/base/interruption.h"
#include "calib/base/thread_pool.h"
#include "machine/job/text_variables.h"
#include "tools/batch/cluster/shard.h"
#include "tools/batch/cluster/slurm_array.h"
#include "tools/batch/manifest/manifest.h"
#include "tools/batch/manifest/output_check.h"
#include "tools/batch/output/progress.h"
#include "tools/batch/results.h"
#include "tools/batch/store/store.h"
#include "tools/batch/work/worker.h"
#include "tools/cli/commands.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/process/version.h"
#include "tools/gather/jobs.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal {
namespace batch {
namespace {

constexpr const char* kCommandName = "panelcal batch";

/// Jobs whose files are synced together, and how long the first of them waits for that: a tenth of
/// the time worked so far, so that this is the most that a kill takes away.
constexpr std::size_t kShardJobs = 256;
constexpr std::chrono::steady_clock::duration kMinShardTime = std::chrono::milliseconds(20);
constexpr std::chrono::steady_clock::duration kMaxShardTime = std::chrono::seconds(2);
/// Jobs that are begun or wait behind one that takes long, besides those of the threads.
constexpr std::size_t kWaitingJobs = 256;

Diagnostic usage_of_batch(std::string what, std::string expected) {
  return {Code::Usage, {kCommandName, 0, 0}, std::move(what), std::move(expected)};
}

/// From a manifest to results. The store and the files are those of the jobs in their order,
/// whatever the number of threads and wherever an earlier start of the batch was ended.
class BatchRun {
 public:
  BatchRun(const BatchOptions& options, CommandContext& context)
      : options_(options), context_(context) {}

  Expected<Answer> run() {
    heed_interruptions();
    PANELCAL_CHECK(check_options());
    PANELCAL_CHECK(read_jobs());
    if (options_.engine == "parallel") return parallel_lines();
    PANELCAL_CHECK(open_results());
    // The shards of an array that is under way are its own affair.
    const bool is_array = options_.engine == "slurm";
    if (!shard_ && !(is_array && SlurmArray::is_under_way(options_.output))) {
      PANELCAL_CHECK(gather());
    }
    PANELCAL_CHECK(select());
    PANELCAL_CHECK(open_database());
    PANELCAL_CHECK(is_array ? work_by_array() : work());
    if (shard_) return shard_answer();
    PANELCAL_TRY(Answer answer,
                 answer_of(*store_,
                           {session_.n_jobs, session_.seconds},
                           {options_.facts, options_.metrics},
                           context_));
    if (lacks_jobs_) answer.code = std::max(answer.code, ExitCode::DeviceFailed);
    return answer;
  }

 private:
  Expected<void> check_options() {
    if (options_.output.empty()) return failure(usage_of_batch("no folder for results", "-o"));
    PANELCAL_CHECK(check_extension(kCommandName, options_.metrics, ".prom"));
    if (options_.manifest.empty() == options_.pattern.empty()) {
      return failure(usage_of_batch("jobs from nowhere, or from two places",
                                    "a manifest, or --pattern 'jobs/*'"));
    }
    if (options_.engine != "local" && options_.manifest == "-") {
      return failure(usage_of_batch("jobs from standard input, for more than one process",
                                    "a manifest that all of them can read"));
    }
    if (!options_.store.empty() && (!options_.shard.empty() || options_.engine == "parallel")) {
      return failure(usage_of_batch("--store for a part of the batch",
                                    "`panelcal batch push` behind `panelcal batch merge`"));
    }
    if (!options_.shard.empty()) {
      PANELCAL_TRY(shard_, read_shard(options_.shard));
    }
    return {};
  }

  Expected<void> read_jobs() {
    const ManifestDefaults defaults{options_.machine};
    if (options_.manifest.empty()) {
      PANELCAL_TRY(manifest_, find_job_folders(options_.pattern, defaults));
    } else {
      PANELCAL_TRY(manifest_, read_manifest(options_.manifest, defaults));
    }
    return check_job_outputs(manifest_,
                             options_.output,
                             {options_.facts.json, options_.metrics},
                             !options_.format.empty());
  }

  std::filesystem::path whole_store() const {
    return std::filesystem::path(options_.output) / Store::kFileName;
  }

  /// Tells whether a batch was begun there, and refuses where that is not what the options want.
  Expected<bool> has_store(const std::filesystem::path& file) const {
    // A shard that is started again goes on: a cluster starts it with the same words.
    const bool goes_on = options_.resume || !options_.only.empty() || shard_;
    std::error_code ignored;
    const bool is_there = std::filesystem::exists(file, ignored);
    if (is_there && !goes_on) {
      return failure({Code::OutputInUse,
                      {options_.output, 0, 0},
                      "a batch has its results there",
                      "--resume to go on with it, or another folder"});
    }
    if (!std::filesystem::exists(whole_store(), ignored) && !options_.only.empty()) {
      return failure(usage_of_batch(
          "--only " + options_.only + " without results in " + quoted(options_.output),
          "a batch that was run before"));
    }
    return is_there;
  }

  /// A batch is begun where there is none, and gone on with where the same one is.
  Expected<void> open_results() {
    const std::filesystem::path results = options_.output;
    const std::filesystem::path own = shard_ ? shard_folder(results, *shard_) : results;
    const std::filesystem::path file = own / Store::kFileName;
    // A refusal leaves no folder behind.
    PANELCAL_CHECK(has_store(file));
    const std::chrono::sys_seconds now = system_clock()();
    PANELCAL_TRY(const std::string time, wall_time(options_.clock, now, kCommandName));
    StoredBatch wanted{kVersion,
                       manifest_.file,
                       manifest_.sha256,
                       terms_text(),
                       time,
                       static_cast<std::int64_t>(manifest_.jobs.size())};
    if (shard_) PANELCAL_CHECK(join_whole(wanted));
    PANELCAL_TRY(ResultFolder folder, ResultFolder::open(results, own));
    results_.emplace(std::move(folder));
    // Until the lock was had, another batch may have begun and ended.
    PANELCAL_TRY(const bool is_there, has_store(file));
    PANELCAL_TRY(Store store, is_there ? Store::open(file) : begin_store(*results_, wanted));
    store_.emplace(std::move(store));
    PANELCAL_TRY(const StoredBatch stored, store_->batch());
    time_ = stored.clock;
    return check_same_batch(stored, wanted, own.string(), options_.clock);
  }

  /// A shard has the time of the whole batch, and does not do again what that has done.
  Expected<void> join_whole(StoredBatch& wanted) {
    std::error_code ignored;
    if (!std::filesystem::exists(whole_store(), ignored)) {
      if (!options_.clock.empty()) return {};
      return failure(usage_of_batch("--shard " + options_.shard + " without a time",
                                    "--clock, the same one for all shards"));
    }
    PANELCAL_TRY(Store whole, Store::open_to_read(whole_store()));
    PANELCAL_TRY(const StoredBatch stored, whole.batch());
    PANELCAL_CHECK(check_same_batch(stored, wanted, options_.output, options_.clock));
    wanted = stored;
    PANELCAL_TRY(states_of_whole_, whole.states(wanted.n_jobs));
    return {};
  }

  /// What decides about the jobs' outcome, besides manifest and clock.
  std::string terms_text() const {
    return fmt::format("to={} machine={} places={}",
                       options_.format,
                       options_.machine,
                       options_.keeps_places ? "yes" : "no");
  }

  Expected<void> select() {
    PANELCAL_TRY(const auto states,
                 store_->states(static_cast<std::int64_t>(manifest_.jobs.size())));
    const auto& whole = shard_ && !states_of_whole_.empty() ? states_of_whole_ : states;
    const std::size_t n = options_.n_sampled > 0 ? options_.n_sampled : manifest_.jobs.size();
    for (const std::int64_t number : sample_of(manifest_, n)) {
      const auto i = static_cast<std::size_t>(number - 1);
      if (shard_ && !shard_->has(number)) continue;
      if (shard_ && states[i]) {
        // By an earlier start of the shard.
        count_.add({.state = *states[i]});
        continue;
      }
      const auto& state = whole[i];
      const bool is_wanted =
          options_.only.empty() ? !state : state && name(*state) == options_.only;
      if (is_wanted) selected_.push_back(i);
    }
    count_.n_jobs = count_.n_done + static_cast<std::int64_t>(selected_.size());
    return tell();
  }

  /// A shard tells how far it is; the process that submitted it reads that.
  Expected<void> tell() { return shard_ ? write_count(results_->own(), count_) : Expected<void>(); }

  /// The stores of shards, as far as they are there.
  Expected<void> gather() {
    PANELCAL_TRY(const std::int64_t n_jobs, gather_shards(*store_, *results_));
    session_.n_jobs += n_jobs;
    return {};
  }

  std::size_t n_threads() const {
    const std::size_t asked =
        options_.n_threads > 0 ? options_.n_threads : std::thread::hardware_concurrency();
    return std::clamp<std::size_t>(asked, 1, std::max<std::size_t>(1, selected_.size()));
  }

  /// Before the first job, so that a wrong address is known at once.
  Expected<void> open_database() {
    if (options_.store.empty()) return {};
    PANELCAL_TRY(gather::JobDelivery delivery, gather::JobDelivery::begin(options_.store, *store_));
    delivery_.emplace(std::move(delivery));
    // Of earlier starts.
    check_delivered(delivery_->deliver_all());
    return {};
  }

  /// What does not reach the database stays in the results: the batch goes on without it.
  void check_delivered(const Expected<std::int64_t>& n) {
    if (n) return;
    context_.console.end_progress();
    context_.console.print(n.error());
    context_.console.say(
        fmt::format("the results are whole in {}; `panelcal batch push {} --store "
                    "...` brings them into the database",
                    options_.output,
                    options_.output));
    delivery_.reset();
    lacks_jobs_ = true;
  }

  Expected<void> work() {
    if (selected_.empty()) return {};
    const std::size_t n = n_threads();
    session_ = {.started = iso_8601(system_clock()()), .n_threads = static_cast<std::int64_t>(n)};
    PANELCAL_TRY(i_session_, store_->begin_session(session_));
    std::optional<OutputFormat> format;
    if (!options_.format.empty()) format = output_format_from_name(options_.format);
    MachineCache machines;
    const JobWorker worker(
        {time_, system_clock()(), format, options_.keeps_places}, machines, *results_);
    Progress progress(context_.console, selected_.size());
    begun_ = std::chrono::steady_clock::now();
    std::deque<std::future<FinishedJob>> pending;
    ThreadPool pool(n);  // last: its tasks use the others
    const std::size_t n_ahead = kWaitingJobs + 2 * n;
    std::size_t i_next = 0;
    for (std::size_t i = 0; i < selected_.size(); ++i) {
      for (; i_next < std::min(selected_.size(), i + n_ahead); ++i_next) {
        const ManifestJob& job = manifest_.jobs[selected_[i_next]];
        pending.push_back(submit(pool, [&worker, &job] { return worker.run(job); }));
      }
      FinishedJob done = pending.front().get();
      pending.pop_front();
      // A job that saw the signal too has not failed.
      if (interruption() != 0) break;
      if (done.broken) {
        PANELCAL_CHECK(commit_shard());
        return failure(*std::move(done.broken));
      }
      progress.count(done.outcome);
      count_.add(done.outcome);
      PANELCAL_CHECK(take(std::move(done)));
      progress.show();
    }
    context_.console.end_progress();
    PANELCAL_CHECK(commit_shard());
    return check_interruption();
  }

  Expected<void> take(FinishedJob done) {
    const auto now = std::chrono::steady_clock::now();
    if (outcomes_.empty()) shard_begun_ = now;
    std::ranges::move(done.files, std::back_inserter(files_));
    ++session_.n_jobs;
    session_.n_pictures += done.outcome.n_pictures;
    outcomes_.push_back(std::move(done.outcome));
    const auto patience = std::clamp((now - begun_) / 10, kMinShardTime, kMaxShardTime);
    const bool is_full = outcomes_.size() >= kShardJobs || now - shard_begun_ >= patience;
    return is_full ? commit_shard() : Expected<void>();
  }

  /// The rows say that jobs are done once their files are on disk.
  Expected<void> commit_shard() {
    if (outcomes_.empty()) return {};
    PANELCAL_CHECK(results_->publish(files_));
    session_.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count();
    PANELCAL_CHECK(store_->put(outcomes_, i_session_, session_));
    if (delivery_) {
      std::vector<std::int64_t> numbers;
      for (const JobOutcome& job : outcomes_) numbers.push_back(job.number);
      check_delivered(delivery_->deliver(numbers));
    }
    files_.clear();
    outcomes_.clear();
    return tell();
  }

  /// Of the batch, but for what differs between its processes.
  std::vector<std::string> command_words() const {
    std::error_code ignored;
    std::vector<std::string> words = {
        std::filesystem::read_symlink("/proc/self/exe", ignored).string(), "batch"};
    if (!options_.manifest.empty()) words.push_back(options_.manifest);
    const auto add = [&](const char* option, const std::string& value) {
      if (!value.empty()) words.insert(words.end(), {option, value});
    };
    add("--pattern", options_.pattern);
    add("-o", options_.output);
    add("-m", options_.machine);
    add("--to", options_.format);
    add("--only", options_.only);
    if (options_.n_sampled > 0) add("--sample", std::to_string(options_.n_sampled));
    if (options_.keeps_places) words.emplace_back("--places");
    add("--clock", time_);
    return words;
  }

  Expected<void> work_by_array() {
    if (selected_.empty()) return {};
    begun_ = std::chrono::steady_clock::now();
    SlurmArray array({.results = options_.output,
                      .command = command_words(),
                      .n_jobs = static_cast<std::int64_t>(selected_.size()),
                      .n_shards = options_.n_shards,
                      .n_retries = options_.n_retries,
                      .n_threads = std::max<std::size_t>(1, options_.n_threads)},
                     context_.console);
    PANELCAL_TRY(const std::vector<std::int64_t> given_up, array.run());
    PANELCAL_CHECK(gather());
    if (delivery_) check_delivered(delivery_->deliver_all());
    session_.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count();
    if (given_up.empty()) return {};
    return failure({Code::DeviceStage,
                    {options_.output, 0, 0},
                    fmt::format("shards {} ended before they were done, each {} times",
                                fmt::join(given_up, ", "),
                                options_.n_retries + 1),
                    "the cause in slurm/*.log mended, then --resume"});
  }

  /// Of GNU parallel, for a shell; with -q it hands words on as they are.
  Expected<Answer> parallel_lines() {
    PANELCAL_TRY(time_, wall_time(options_.clock, system_clock()(), kCommandName));
    const auto n_jobs = static_cast<std::int64_t>(manifest_.jobs.size());
    const std::int64_t n_shards = std::clamp<std::int64_t>(
        n_jobs, 1, options_.n_shards > 0 ? options_.n_shards : kUsualShards);
    const std::vector<std::string> command = command_words();
    std::vector<std::string> merging = {command[0], "batch", "merge", options_.output};
    const auto add = [&](const char* option, const std::string& value) {
      if (!value.empty()) merging.insert(merging.end(), {option, value});
    };
    add("--json", options_.facts.json);
    add("--metrics", options_.metrics);
    return Answer{
        fmt::format("parallel -q --retries {} {} --threads {} --shard {{}}/{} ::: "
                    "$(seq {}) && \\\n  {}\n",
                    options_.n_retries + 1,
                    shell_text(command),
                    std::max<std::size_t>(1, options_.n_threads),
                    n_shards,
                    n_shards,
                    shell_text(merging))};
  }

  /// Whether jobs were held or failed, the whole batch says: a cluster would start the shard again.
  Expected<Answer> shard_answer() {
    context_.console.say(fmt::format("shard {} of {}: {} of {} jobs done, {} held, {} failed",
                                     shard_->number,
                                     shard_->n_shards,
                                     count_.n_done,
                                     count_.n_jobs,
                                     count_.n_held,
                                     count_.n_failed));
    return Answer{};
  }

  const BatchOptions& options_;
  CommandContext& context_;
  Manifest manifest_;
  std::optional<Shard> shard_;
  std::vector<std::optional<JobState>> states_of_whole_;  ///< of a shard, where they are known
  JobCount count_;
  std::optional<ResultFolder> results_;
  std::optional<Store> store_;
  std::optional<gather::JobDelivery> delivery_;
  bool lacks_jobs_ = false;  ///< the database; the results have them
  std::string time_;         ///< on the wall, of the batch
  std::vector<std::size_t> selected_;
  StoredSession session_;
  std::int64_t i_session_ = 0;
  std::chrono::steady_clock::time_point begun_;
  std::chrono::steady_clock::time_point shard_begun_;
  std::vector<JobOutcome> outcomes_;  ///< of the shard
  std::vector<PartFile> files_;
};

}  // namespace
}  // namespace batch

Expected<Answer> run_command(const BatchOptions& options, CommandContext& context) {
  return batch::BatchRun(options, context).run();
}

}  // namespace panelcal
