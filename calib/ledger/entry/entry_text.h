// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "calib/ledger/entry/entry.h"

// Not installed.
namespace panelcal::internal {

/// Stands at the start of every entry's content, so that a wrecked ledger is still known as one.
inline constexpr std::string_view kEntryMark = R"({"panelcal":"ledger-entry","id":)";

/// The predecessor of the first entry has this hash.
inline constexpr std::string_view kNoHash =
    "0000000000000000000000000000000000000000000000000000000000000000";

/// Checks that the ledger can hold the draft; `file` is what messages name.
///
/// Fails  ledger-entry-invalid, with the field; json-syntax of the result
Expected<void> check_draft(const LedgerDraft& draft, const std::string& file);
/// The same without the result.
Expected<void> check_record(const LedgerRecord& record, const std::string& file);

/// Reads what ledger_entry_json wrote; `hash` is left empty.
///
/// Fails  ledger-corrupt
Expected<LedgerEntry> parse_entry(std::string_view content, const std::string& file);

/// The hash that chains an entry to its predecessor.
std::string chained_hash(std::string_view previous_hash, std::string_view content);

}  // namespace panelcal::internal
