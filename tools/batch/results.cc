// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/results.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/number_text.h"
#include "tools/batch/cluster/shard.h"
#include "tools/batch/output/facts.h"
#include "tools/cli/facts_output.h"
#include "tools/cli/metrics.h"
#include <fmt/format.h>

namespace panelcal::batch {
namespace {

namespace fs = std::filesystem;

Expected<void> remove_folder(const fs::path& folder) {
  std::error_code error;
  fs::remove_all(folder, error);
  if (!error) return {};
  return failure({Code::DeviceWrite, {folder.string(), 0, 0}, error.message(), ""});
}

/// In the order of their names.
/// "3-of-8": what a shard has made; whatever else lies there stays.
bool is_shards(const fs::path& folder) {
  std::string name = folder.filename().string();
  const std::size_t of = name.find("-of-");
  if (of == std::string::npos) return false;
  name.replace(of, 4, "/");
  return read_shard(name).has_value();
}

Expected<std::vector<fs::path>> shards_in(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (at->is_directory(error) && is_shards(at->path())) out.push_back(at->path());
  }
  if (error && error != std::errc::no_such_file_or_directory) {
    return failure({Code::FileUnreadable, {folder.string(), 0, 0}, error.message(), ""});
  }
  std::ranges::sort(out);
  return out;
}

/// The lock keeps the shard from writing meanwhile.
Expected<std::int64_t> take_shard(Store& store,
                                  const StoredBatch& batch,
                                  const ResultFolder& shard) {
  const fs::path file = shard.own() / Store::kFileName;
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return 0;
  {
    // Undoes what a killed shard was writing.
    PANELCAL_TRY(Store part, Store::open(file));
    PANELCAL_TRY(const StoredBatch of_part, part.batch());
    PANELCAL_CHECK(check_same_batch(of_part, batch, shard.own().string(), batch.clock));
  }
  return store.take_in(file);
}

Metrics metrics_of(const facts::Json& facts, const DoneNow& now) {
  const std::string batch = facts["manifest"].get<std::string>();
  const facts::Json& jobs = facts["jobs"];
  Metrics out;
  for (const char* state : {"drilled", "held", "failed", "missing"}) {
    out.gauge("panelcal_batch_jobs",
              "Jobs of the batch by what became of them; missing: not done yet",
              {{"batch", batch}, {"state", state}},
              jobs[state].get<double>());
  }
  const Metrics::Labels labels = {{"batch", batch}};
  out.gauge("panelcal_batch_pictures",
            "Pictures of the jobs that are done",
            labels,
            jobs["pictures"].get<double>());
  out.gauge("panelcal_batch_exit_code",
            "Exit code of panelcal batch over the jobs that are done",
            labels,
            jobs["exit_code"].get<double>());
  out.gauge("panelcal_batch_duration_seconds", "Duration of the last start", labels, now.seconds);
  out.gauge("panelcal_batch_finished_timestamp_seconds",
            "End of the last start",
            labels,
            static_cast<double>(system_clock()().time_since_epoch().count()));
  return out;
}

}  // namespace

Expected<Store> begin_store(const ResultFolder& folder, const StoredBatch& batch) {
  const fs::path file = folder.own() / Store::kFileName;
  const fs::path part = folder.own() / "parts" / Store::kFileName;
  { PANELCAL_TRY(const Store made, Store::create(part, batch)); }
  const std::vector<PartFile> files = {{part, file}};
  PANELCAL_CHECK(folder.publish(files));
  return Store::open(file);
}

Expected<Store> open_results_of(const std::string& folder) {
  const fs::path file = fs::path(folder) / Store::kFileName;
  std::error_code ignored;
  if (!fs::exists(file, ignored)) {
    return failure({Code::Usage, {folder, 0, 0}, "no results of a batch", "the folder of -o"});
  }
  return Store::open_to_read(file);
}

Expected<void> check_same_batch(const StoredBatch& stored,
                                const StoredBatch& wanted,
                                const std::string& folder,
                                const std::string& clock) {
  const auto refuse = [&](std::string what, std::string expected) {
    return failure({Code::Usage, {folder, 0, 0}, std::move(what), std::move(expected)});
  };
  if (stored.manifest_sha256 != wanted.manifest_sha256) {
    return refuse("the manifest has changed since the batch was begun",
                  "the manifest as it was, or another folder");
  }
  if (stored.terms != wanted.terms) {
    return refuse("the batch was begun with " + quoted(stored.terms), "the same options");
  }
  if (!clock.empty() && stored.clock != clock) {
    return refuse("the batch was begun with --clock " + stored.clock, "the same, or none");
  }
  return {};
}

Expected<std::int64_t> gather_shards(Store& store, const ResultFolder& folder) {
  const fs::path all = shards_folder(folder.path());
  PANELCAL_TRY(const std::vector<fs::path> shards, shards_in(all));
  PANELCAL_TRY(const StoredBatch batch, store.batch());
  std::int64_t n_jobs = 0;
  for (const fs::path& one : shards) {
    PANELCAL_TRY(const ResultFolder shard, ResultFolder::open(folder.path(), one));
    PANELCAL_TRY(const std::int64_t n, take_shard(store, batch, shard));
    n_jobs += n;
    PANELCAL_CHECK(remove_folder(one));
  }
  // Only if it is empty: another shard may have begun meanwhile.
  std::error_code ignored;
  fs::remove(all, ignored);
  return n_jobs;
}

Expected<Answer> answer_of(Store& store,
                           const DoneNow& now,
                           const AnswerFiles& files,
                           CommandContext& context) {
  PANELCAL_TRY(const facts::Json facts, batch_facts(store));
  const facts::Json& jobs = facts["jobs"];
  const auto count = [&](const char* key) {
    return internal::grouped(jobs[key].get<std::int64_t>());
  };
  context.console.say(fmt::format("{}: {} drilled, {} held, {} failed{}; {} now in {:.1f} s",
                                  internal::counted(jobs["done"].get<std::int64_t>(), "job"),
                                  count("drilled"),
                                  count("held"),
                                  count("failed"),
                                  jobs["missing"] == 0 ? "" : ", " + count("missing") + " not done",
                                  internal::grouped(now.n_jobs),
                                  now.seconds));
  const std::string title = facts["manifest"].get<std::string>() + " - panelcal";
  Answer answer = state_facts(context, files.facts, title, [&] { return facts::text(facts); });
  answer.code = std::max(answer.code, static_cast<ExitCode>(jobs["exit_code"].get<int>()));
  if (files.metrics.empty()) return answer;
  const auto written = write_file(files.metrics, metrics_of(facts, now).text());
  if (!written) {
    context.console.print(written.error());
    answer.code = std::max(answer.code, exit_code(written.error()));
  }
  return answer;
}

}  // namespace panelcal::batch
