// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <filesystem>
#include <system_error>
#include <utility>

#include "tools/batch/cluster/shard.h"
#include "tools/batch/results.h"
#include "tools/cli/commands.h"
#include "tools/cli/output_paths.h"

namespace panelcal::batch {
namespace {

namespace fs = std::filesystem;

/// The batch of shards that were started by hand, by the first store that is found.
Expected<StoredBatch> batch_of_shards(const std::string& results) {
  std::error_code error;
  for (fs::directory_iterator at(shards_folder(results), error), end; !error && at != end;
       at.increment(error)) {
    const fs::path file = at->path() / Store::kFileName;
    std::error_code ignored;
    if (!fs::exists(file, ignored)) continue;
    PANELCAL_TRY(Store part, Store::open_to_read(file));
    return part.batch();
  }
  return failure({Code::Usage, {results, 0, 0}, "no results of a batch", "the folder of -o"});
}

}  // namespace

Expected<Answer> merge(const BatchReportOptions& options, CommandContext& context) {
  PANELCAL_CHECK(check_extension("panelcal batch merge", options.metrics, ".prom"));
  const auto begun = std::chrono::steady_clock::now();
  const fs::path file = fs::path(options.results) / Store::kFileName;
  std::error_code ignored;
  const bool is_there = fs::exists(file, ignored);
  StoredBatch batch;
  // A refusal leaves no folder behind.
  if (!is_there) {
    PANELCAL_TRY(batch, batch_of_shards(options.results));
  }
  PANELCAL_TRY(const ResultFolder folder, ResultFolder::open(options.results));
  PANELCAL_TRY(Store store, is_there ? Store::open(file) : begin_store(folder, batch));
  PANELCAL_TRY(const std::int64_t n_jobs, gather_shards(store, folder));
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return answer_of(store, {n_jobs, seconds}, {options.facts, options.metrics}, context);
}

}  // namespace panelcal::batch
