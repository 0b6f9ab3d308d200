// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "tools/batch/output/progress.h"

namespace panelcal::batch {

/// A part of a batch that one process does: every n-th job, so that jobs that take long, which
/// often stand together, are spread over all shards.
struct Shard {
  std::int64_t number = 1;  ///< from 1
  std::int64_t n_shards = 1;

  bool has(std::int64_t job) const { return (job - 1) % n_shards == number - 1; }
};

inline constexpr std::int64_t kMaxShards = 5'000;
/// The number if none is asked for.
inline constexpr std::int64_t kUsualShards = 16;

/// Reads "3/8".
///
/// Fails  usage
Expected<Shard> read_shard(std::string_view text);

/// The folder of all shards' stores in the results of a batch.
std::filesystem::path shards_folder(const std::filesystem::path& results);
/// That of one: RESULTS/shards/3-of-8.
std::filesystem::path shard_folder(const std::filesystem::path& results, const Shard& shard);

/// Tells in a shard's folder how far it is, as progress.json.
///
/// Fails  device-write
Expected<void> write_count(const std::filesystem::path& folder, const JobCount& count);
/// Empty where no shard has told anything yet.
std::optional<JobCount> read_count(const std::filesystem::path& folder);

}  // namespace panelcal::batch
