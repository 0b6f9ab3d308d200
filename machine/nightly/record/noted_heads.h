// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/fields/noted_head.h"
#include "calib/ledger/ledger.h"
#include "machine/nightly/record/night_files.h"

namespace panelcal {

struct MachineConfig;

// Not installed: what files note of the ledger, and whether it still has it.
/// A file that notes the head of a ledger.
struct NotedFile {
  std::filesystem::path file;
  internal::NotedHead head;
  std::string sha256;  ///< of the file
};

/// The head that a file's text notes: "ledger" of a calibration, "ledger_head" of a night's or a
/// job's facts, alone or in a page, or the row "ledger head" of a page from before there were facts
/// in it. Nothing in any other text.
std::optional<internal::NotedHead> head_in(std::string_view text);

/// True for the page or the JSON of a night, and the page of a job, that note a head.
bool is_record_with_head(std::string_view text);

/// Files with their folders' .json and .html files in their place, in the order of their names.
///
/// Fails  file-unreadable (there is no such file)
Expected<std::vector<std::filesystem::path>> files_below(
    const std::vector<std::filesystem::path>& files);

/// Files that note a head, and the number of those that note none.
struct NotingFiles {
  std::vector<NotedFile> noted;
  std::size_t n_without = 0;
};

/// Fails  file-unreadable
Expected<NotingFiles> read_noting_files(const std::vector<std::filesystem::path>& files);

/// Entries that files note and a ledger lacks, a sentence each; empty if it has all. Heads that the
/// ledger gave up when it was begun anew (begun_anew_draft) are of the ledger before it.
///
/// Fails  what the ledger reports
Expected<std::vector<std::string>> missing_entries(const Ledger& ledger,
                                                   const std::vector<NotedFile>& files);

/// Holds a ledger against what machine.toml names: an older copy, or a new ledger, does not know
/// which rows of the coupon are drilled. A calibration whose bytes are no entry's result is left to
/// those who install: a person may have made it.
///
/// In     ledger: absent where there is none
/// Fails  ledger-cut-off; file-unreadable (a report)
/// See    tests/tools/cut_ledger_test.py
Expected<void> check_noted_heads(const NightFiles& files, const Ledger* ledger);

/// The same of what a valid machine.toml names; asked before rows of the coupon are taken. A
/// machine without a ledger has nothing to hold.
///
/// Fails  as above; what the ledger reports
/// See    tests/tools/cut_ledger_test.py
Expected<void> check_noted_heads(const MachineConfig& config);

/// Hashes of the heads that the files of a machine.toml note, each once.
///
/// Fails  file-unreadable (a report)
Expected<std::vector<std::string>> noted_hashes(const NightFiles& files);

}  // namespace panelcal
