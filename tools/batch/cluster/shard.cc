// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/cluster/shard.h"

#include <array>
#include <charconv>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/base/json/facts.h"
#include <fmt/format.h>

namespace panelcal::batch {
namespace {

constexpr const char* kCountFile = "progress.json";
constexpr std::size_t kMaxCountBytes = 4096;

constexpr std::array<std::pair<const char*, std::int64_t JobCount::*>, 5> kCountKeys = {{
    {"jobs", &JobCount::n_jobs},
    {"done", &JobCount::n_done},
    {"held", &JobCount::n_held},
    {"failed", &JobCount::n_failed},
    {"pictures", &JobCount::n_pictures},
}};

/// A whole number that is all of the text.
std::optional<std::int64_t> whole_number(std::string_view text) {
  std::int64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || at != end) return std::nullopt;
  return value;
}

}  // namespace

Expected<Shard> read_shard(std::string_view text) {
  const std::size_t slash = text.find('/');
  if (slash != std::string_view::npos) {
    const auto number = whole_number(text.substr(0, slash));
    const auto n_shards = whole_number(text.substr(slash + 1));
    if (number && n_shards && *n_shards <= kMaxShards && *number >= 1 && *number <= *n_shards) {
      return Shard{*number, *n_shards};
    }
  }
  return failure({Code::Usage,
                  {"panelcal batch", 0, 0},
                  "--shard " + quoted(text),
                  fmt::format("NUMBER/SHARDS, from 1/1 to {0}/{0}", kMaxShards)});
}

std::filesystem::path shards_folder(const std::filesystem::path& results) {
  return results / "shards";
}

std::filesystem::path shard_folder(const std::filesystem::path& results, const Shard& shard) {
  return shards_folder(results) / fmt::format("{}-of-{}", shard.number, shard.n_shards);
}

Expected<void> write_count(const std::filesystem::path& folder, const JobCount& count) {
  facts::Json document = facts::Json::object();
  for (const auto& [key, member] : kCountKeys) document[key] = count.*member;
  return write_file(folder / kCountFile, facts::text(document));
}

std::optional<JobCount> read_count(const std::filesystem::path& folder) {
  const auto text = read_file(folder / kCountFile, kMaxCountBytes);
  if (!text) return std::nullopt;
  const facts::Json document = facts::Json::parse(*text, nullptr, false);
  JobCount count;
  for (const auto& [key, member] : kCountKeys) {
    if (!document.is_object() || !document.contains(key)) return std::nullopt;
    const facts::Json& value = document[key];
    if (!value.is_number_integer()) return std::nullopt;
    count.*member = value.get<std::int64_t>();
  }
  return count;
}

}  // namespace panelcal::batch
