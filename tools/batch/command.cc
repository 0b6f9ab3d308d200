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
#include "calib/base/number_text.h"
#include "calib/base/thread_pool.h"
#include "machine/job/text_variables.h"
#include "tools/batch/manifest/manifest.h"
#include "tools/batch/manifest/output_check.h"
#include "tools/batch/output/facts.h"
#include "tools/batch/progress.h"
#include "tools/batch/store/store.h"
#include "tools/batch/work/worker.h"
#include "tools/cli/commands.h"
#include "tools/cli/facts_output.h"
#include "tools/cli/process/version.h"
#include <fmt/format.h>

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
    PANELCAL_CHECK(open_results());
    PANELCAL_CHECK(select());
    PANELCAL_CHECK(work());
    return answer();
  }

 private:
  Expected<void> check_options() const {
    if (options_.output.empty()) return failure(usage_of_batch("no folder for results", "-o"));
    if (options_.manifest.empty() == options_.pattern.empty()) {
      return failure(usage_of_batch("jobs from nowhere, or from two places",
                                    "a manifest, or --pattern 'jobs/*'"));
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
    return check_job_outputs(
        manifest_, options_.output, options_.facts.json, !options_.format.empty());
  }

  /// Tells whether a batch was begun there, and refuses where that is not what the options want.
  Expected<bool> has_store(const std::filesystem::path& file) const {
    const bool goes_on = options_.resume || !options_.only.empty();
    std::error_code ignored;
    const bool is_there = std::filesystem::exists(file, ignored);
    if (is_there && !goes_on) {
      return failure({Code::OutputInUse,
                      {options_.output, 0, 0},
                      "a batch has its results there",
                      "--resume to go on with it, or another folder"});
    }
    if (!is_there && !options_.only.empty()) {
      return failure(usage_of_batch(
          "--only " + options_.only + " without results in " + quoted(options_.output),
          "a batch that was run before"));
    }
    return is_there;
  }

  /// A batch is begun where there is none, and gone on with where the same one is.
  Expected<void> open_results() {
    const std::filesystem::path file = std::filesystem::path(options_.output) / Store::kFileName;
    // A refusal leaves no folder behind.
    PANELCAL_CHECK(has_store(file));
    PANELCAL_TRY(ResultFolder results, ResultFolder::open(options_.output));
    results_.emplace(std::move(results));
    // Until the lock was had, another batch may have begun and ended.
    PANELCAL_TRY(const bool is_there, has_store(file));
    const std::chrono::sys_seconds now = system_clock()();
    PANELCAL_TRY(const std::string time, wall_time(options_.clock, now, kCommandName));
    StoredBatch wanted{kVersion,
                       manifest_.file,
                       manifest_.sha256,
                       terms_text(),
                       time,
                       static_cast<std::int64_t>(manifest_.jobs.size())};
    if (!is_there) return begin(file, wanted);
    PANELCAL_TRY(Store store, Store::open(file));
    store_.emplace(std::move(store));
    PANELCAL_TRY(const StoredBatch stored, store_->batch());
    time_ = stored.clock;
    return check_same(stored, wanted);
  }

  /// Under another name first: a store is whole or not there.
  Expected<void> begin(const std::filesystem::path& file, const StoredBatch& batch) {
    const std::filesystem::path part = results_->path() / "parts" / Store::kFileName;
    { PANELCAL_TRY(const Store made, Store::create(part, batch)); }
    const std::vector<PartFile> files = {{part, file}};
    PANELCAL_CHECK(results_->publish(files));
    time_ = batch.clock;
    PANELCAL_TRY(Store store, Store::open(file));
    store_.emplace(std::move(store));
    return {};
  }

  /// What decides about the jobs' outcome, besides manifest and clock.
  std::string terms_text() const {
    return fmt::format("to={} machine={} places={}",
                       options_.format,
                       options_.machine,
                       options_.keeps_places ? "yes" : "no");
  }

  Expected<void> check_same(const StoredBatch& stored, const StoredBatch& wanted) const {
    const auto refuse = [&](std::string what, std::string expected) {
      return failure({Code::Usage, {options_.output, 0, 0}, std::move(what), std::move(expected)});
    };
    if (stored.manifest_sha256 != wanted.manifest_sha256) {
      return refuse("the manifest has changed since the batch was begun",
                    "the manifest as it was, or another folder");
    }
    if (stored.terms != wanted.terms) {
      return refuse("the batch was begun with " + quoted(stored.terms), "the same options");
    }
    if (!options_.clock.empty() && stored.clock != options_.clock) {
      return refuse("the batch was begun with --clock " + stored.clock, "the same, or none");
    }
    return {};
  }

  Expected<void> select() {
    PANELCAL_TRY(const auto states,
                 store_->states(static_cast<std::int64_t>(manifest_.jobs.size())));
    const std::size_t n = options_.n_sampled > 0 ? options_.n_sampled : manifest_.jobs.size();
    for (const std::int64_t number : sample_of(manifest_, n)) {
      const auto& state = states[static_cast<std::size_t>(number - 1)];
      const bool is_wanted =
          options_.only.empty() ? !state : state && name(*state) == options_.only;
      if (is_wanted) selected_.push_back(static_cast<std::size_t>(number - 1));
    }
    return {};
  }

  std::size_t n_threads() const {
    const std::size_t asked =
        options_.n_threads > 0 ? options_.n_threads : std::thread::hardware_concurrency();
    return std::clamp<std::size_t>(asked, 1, std::max<std::size_t>(1, selected_.size()));
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
    files_.clear();
    outcomes_.clear();
    return {};
  }

  Expected<Answer> answer() {
    PANELCAL_TRY(const facts::Json facts, batch_facts(*store_));
    const facts::Json& jobs = facts["jobs"];
    const auto count = [&](const char* key) {
      return internal::grouped(jobs[key].get<std::int64_t>());
    };
    context_.console.say(
        fmt::format("{}: {} drilled, {} held, {} failed{}; {} now in {:.1f} s",
                    internal::counted(jobs["done"].get<std::int64_t>(), "job"),
                    count("drilled"),
                    count("held"),
                    count("failed"),
                    jobs["missing"] == 0 ? "" : ", " + count("missing") + " not done",
                    internal::grouped(session_.n_jobs),
                    session_.seconds));
    Answer answer = state_facts(context_, options_.facts, manifest_.file + " - panelcal", [&] {
      return facts::text(facts);
    });
    answer.code = std::max(answer.code, static_cast<ExitCode>(jobs["exit_code"].get<int>()));
    return answer;
  }

  const BatchOptions& options_;
  CommandContext& context_;
  Manifest manifest_;
  std::optional<ResultFolder> results_;
  std::optional<Store> store_;
  std::string time_;  ///< on the wall, of the batch
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
