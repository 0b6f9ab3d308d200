// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/record/noted_heads.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "calib/base/amount.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "calib/base/json/facts.h"
#include "calib/base/json/strict_json.h"
#include "machine/config/machine_config.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/nightly/record/night_history.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

namespace fs = std::filesystem;
using internal::NotedHead;

/// As pages had it before they carried their facts; years of reports lie in folders.
constexpr std::string_view kPageRow = "<dt>ledger head</dt><dd class=\"mono\">";

std::optional<NotedHead> head_in_page_row(std::string_view text) {
  const std::size_t at = text.find(kPageRow);
  if (at == std::string_view::npos) return std::nullopt;
  text.remove_prefix(at + kPageRow.size());
  text = text.substr(0, text.find('<'));
  NotedHead head;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), head.id);
  if (error != std::errc() || end == text.data() + text.size() || *end != ' ') return std::nullopt;
  head.hash = std::string(end + 1, text.data() + text.size());
  if (!internal::is_ledger_hash(head.hash)) return std::nullopt;
  return head;
}

/// Of a night, or of a job: the facts of either name it alike.
std::optional<NotedHead> head_of_facts(const nlohmann::json& document) {
  if (!document.is_object() || !document.contains("ledger_head")) return std::nullopt;
  const nlohmann::json& head = document["ledger_head"];
  if (!head.is_object() || !head.contains("id") || !head.contains("hash")) return std::nullopt;
  if (!head["id"].is_number_unsigned() || !head["hash"].is_string()) return std::nullopt;
  NotedHead noted = {NotedHead::Use::Head, head["id"].get<std::int64_t>(), head["hash"]};
  // A night that did not reach the ledger notes none.
  if (!internal::is_ledger_hash(noted.hash)) return std::nullopt;
  return noted;
}

std::optional<NotedHead> head_in_page(std::string_view text) {
  const std::string_view document = facts::in_page(text);
  if (document.empty()) return head_in_page_row(text);
  const auto parsed = internal::parse_strict_json(document, "");
  return parsed ? head_of_facts(*parsed) : std::nullopt;
}

bool is_read_in_folders(const fs::path& file) {
  return file.extension() == ".json" || file.extension() == ".html";
}

Diagnostic cannot_hold_against(const fs::path& file, const std::error_code& error) {
  return {Code::FileUnreadable,
          {file.string(), 0, 0},
          error ? error.message() : "there is no such file",
          "a file or a folder"};
}

constexpr std::size_t kMaxNotingBytes = std::size_t{1} << 28;

/// Of the files that machine.toml names: what is not there, or a calibration that cannot be read,
/// notes nothing.
Expected<NotingFiles> noting_files_of(const NightFiles& files) {
  NotingFiles all;
  for (const fs::path& file : files.that_note_the_head()) {
    std::error_code ignored;
    if (!fs::exists(file, ignored)) continue;
    PANELCAL_TRY(const std::vector<fs::path> below, files_below({file}));
    Expected<NotingFiles> noting = read_noting_files(below);
    if (!noting && file != files.reports) continue;
    if (!noting) return failure(noting.error());
    std::ranges::move(noting->noted, std::back_inserter(all.noted));
    all.n_without += noting->n_without;
  }
  return all;
}

std::string short_hash(const std::string& hash) {
  constexpr std::size_t kShown = 12;
  return hash.substr(0, kShown) + "...";
}

}  // namespace

std::optional<NotedHead> head_in(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) return std::nullopt;
  if (text[begin] != '{') return head_in_page(text);
  auto document = internal::parse_strict_json(text, "");
  if (!document) return std::nullopt;
  if (const auto head = head_of_facts(*document)) return head;
  const auto head = internal::take_noted_head(*document, "");
  return head ? *head : std::nullopt;
}

bool is_record_with_head(std::string_view text) {
  if (head_in_page(text)) return true;
  const auto document = internal::parse_strict_json(text, "");
  return document && head_of_facts(*document);
}

Expected<std::vector<fs::path>> files_below(const std::vector<fs::path>& files) {
  std::vector<fs::path> all;
  for (const fs::path& file : files) {
    std::error_code error;
    if (!fs::is_directory(file, error)) {
      if (!fs::exists(file, error)) return failure(cannot_hold_against(file, error));
      all.push_back(file);
      continue;
    }
    std::vector<fs::path> below;
    for (fs::recursive_directory_iterator at(file, error), end; !error && at != end;
         at.increment(error)) {
      if (is_read_in_folders(at->path()) && at->is_regular_file()) below.push_back(at->path());
    }
    if (error) return failure(cannot_hold_against(file, error));
    std::ranges::sort(below);
    all.insert(all.end(), below.begin(), below.end());
  }
  return all;
}

Expected<NotingFiles> read_noting_files(const std::vector<fs::path>& files) {
  NotingFiles noting;
  for (const fs::path& file : files) {
    PANELCAL_TRY(const std::string bytes, read_file(file, kMaxNotingBytes));
    if (const auto head = head_in(bytes)) {
      noting.noted.push_back({file, *head, sha256(bytes)});
    } else {
      ++noting.n_without;
    }
  }
  return noting;
}

Expected<std::vector<std::string>> missing_entries(const Ledger& ledger,
                                                   const std::vector<NotedFile>& files) {
  struct Known {
    std::string hash;
    std::string result_sha256;
  };
  std::map<std::int64_t, Known> entries;
  std::map<std::string, std::int64_t> newest_of_result;
  PANELCAL_CHECK(ledger.for_each({}, [&](const LedgerEntry& entry) -> Expected<void> {
    entries[entry.id] = {entry.hash, entry.result_sha256};
    newest_of_result[entry.result_sha256] = entry.id;
    return {};
  }));
  PANELCAL_TRY(const std::set<std::string> given_up, given_up_hashes(ledger));
  const std::int64_t newest = entries.empty() ? 0 : entries.rbegin()->first;
  std::vector<std::string> missing;
  for (const auto& [file, head, digest] : files) {
    if (given_up.contains(head.hash)) continue;
    const std::string name = quoted(file.string(), 200);
    const auto entry = entries.find(head.id);
    if (head.id > newest) {
      missing.push_back(
          fmt::format("{} notes entry {}, and the newest is {}", name, head.id, newest));
    } else if (entry != entries.end() && entry->second.hash != head.hash) {
      missing.push_back(fmt::format("{} notes entry {} with the hash {}, and it has {}",
                                    name,
                                    head.id,
                                    short_hash(head.hash),
                                    short_hash(entry->second.hash)));
    } else if (head.use == NotedHead::Use::RecordedAfter) {
      const auto own = newest_of_result.find(digest);
      if (own != newest_of_result.end() && own->second > head.id) continue;
      missing.push_back(
          fmt::format("{} was recorded after entry {}, and is no entry's result", name, head.id));
    }
  }
  return missing;
}

/// No entry at all is missing from no ledger; each noted entry is from one that is gone.
Expected<std::vector<std::string>> missing_without_ledger(const std::vector<NotedFile>& files) {
  std::vector<std::string> missing;
  for (const NotedFile& file : files) {
    if (file.head.id == 0) continue;
    missing.push_back(fmt::format("{} notes entry {}, and there is no ledger",
                                  quoted(file.file.string(), 200),
                                  file.head.id));
  }
  return missing;
}

Expected<std::vector<std::string>> missing_of(const Ledger* ledger,
                                              const std::vector<NotedFile>& files) {
  return ledger != nullptr ? missing_entries(*ledger, files) : missing_without_ledger(files);
}

/// Where neither a report nor the spindle's calibration notes them, which are as old as the holes
/// of the coupon, the files are another machine's more often than the ledger an older copy.
Expected<std::string> remedy_of(const NightFiles& files,
                                const Ledger* ledger,
                                const std::vector<NotedFile>& noted) {
  const std::vector<fs::path> named = files.that_note_the_head();
  std::string brought;
  std::vector<NotedFile> own;
  for (const NotedFile& file : noted) {
    if (file.file == files.spindle || std::ranges::find(named, file.file) == named.end()) {
      own.push_back(file);
      continue;
    }
    PANELCAL_TRY(const std::vector<std::string> missing, missing_of(ledger, {file}));
    if (missing.empty()) continue;
    brought += (brought.empty() ? "" : " and from ") + quoted(file.file.string(), 200);
  }
  PANELCAL_TRY(const std::vector<std::string> missing, missing_of(ledger, own));
  if (missing.empty()) {
    return fmt::format(
        "\"ledger\" deleted from {} if another machine's ledger is noted there; else the newest "
        "copy of the ledger",
        brought);
  }
  return "the newest copy of the ledger; to begin a new ledger instead, lay a new coupon on the "
         "table, write its name into [coupon] name, move the reports to another folder, and "
         "delete \"ledger\" from calibration files that you keep";
}

Expected<void> check_noted_heads(const NightFiles& files, const Ledger* ledger) {
  PANELCAL_TRY(NotingFiles noting, noting_files_of(files));
  for (NotedFile& file : noting.noted) file.head.use = NotedHead::Use::Head;
  PANELCAL_TRY(const std::vector<std::string> missing, missing_of(ledger, noting.noted));
  if (missing.empty()) return {};
  PANELCAL_TRY(std::string remedy, remedy_of(files, ledger, noting.noted));
  std::string what = missing.back();
  if (missing.size() > 1) what += fmt::format(" (and {} more)", amount(missing.size() - 1, "file"));
  return failure(
      {Code::LedgerCutOff, {files.ledger.string(), 0, 0}, std::move(what), std::move(remedy)});
}

Expected<void> check_noted_heads(const MachineConfig& config) {
  if (config.ledger_file.empty()) return {};
  const NightFiles files =
      night_files_of(config, config.nightly ? *config.nightly : NightlyConfig());
  std::error_code ignored;
  if (!fs::exists(files.ledger, ignored)) return check_noted_heads(files, nullptr);
  PANELCAL_TRY(const Ledger ledger, Ledger::open_to_read(files.ledger));
  return check_noted_heads(files, &ledger);
}

Expected<std::vector<std::string>> noted_hashes(const NightFiles& files) {
  PANELCAL_TRY(const NotingFiles noting, noting_files_of(files));
  std::set<std::string> hashes;
  for (const NotedFile& file : noting.noted) {
    if (!file.head.hash.empty()) hashes.insert(file.head.hash);
  }
  return std::vector<std::string>(hashes.begin(), hashes.end());
}

}  // namespace panelcal
