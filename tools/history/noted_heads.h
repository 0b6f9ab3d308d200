// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/json/noted_head.h"
#include "calib/ledger/ledger.h"

namespace panelcal::history {

/// A file that notes the head of a ledger.
struct NotedFile {
  std::filesystem::path file;
  internal::NotedHead head;
  std::string sha256;  ///< of the file
};

/// The head that a file's text notes: "ledger" of a calibration, "ledger_head" of a night's JSON,
/// the row "ledger head" of a page. Nothing in any other text.
std::optional<internal::NotedHead> head_in(std::string_view text);

/// Files with their folders' .json and .html files in their place, in the order of their names.
///
/// Fails  file-unreadable (there is no such file)
Expected<std::vector<std::filesystem::path>> files_below(
    const std::vector<std::filesystem::path>& files);

/// Entries that files note and a ledger lacks, a sentence each; empty if it has all.
///
/// Fails  what the ledger reports
Expected<std::vector<std::string>> missing_entries(const Ledger& ledger,
                                                   const std::vector<NotedFile>& files);

}  // namespace panelcal::history
