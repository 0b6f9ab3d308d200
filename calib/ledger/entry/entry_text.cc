// SPDX-License-Identifier: Apache-2.0
#include "calib/ledger/entry/entry_text.h"

#include <array>
#include <utility>

#include "calib/base/fields/json.h"
#include "calib/base/fields/slots.h"
#include "calib/base/files/digest.h"
#include "calib/base/json/strict_json.h"
#include "calib/json_files.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr WholeRange kLedgerCount = {0, std::int64_t{1} << 53};

std::string_view kind_word(LedgerKind kind) {
  return word(kind);
}

std::string_view verdict_word(LedgerVerdict verdict) {
  return word(verdict);
}

#include "calib/ledger/entry/entry.def"

Diagnostic corrupt(const std::string& file, std::string what) {
  return {Code::LedgerCorrupt, {file, 0, 0}, std::move(what), ""};
}

}  // namespace

JsonFile ledger_entry_file() {
  return {"ledger-entry.json",
          "One entry of the ledger, as it is stored and as its hash covers it: one line. `panelcal "
          "history export` prints such lines.",
          {&kEntry}};
}

Expected<LedgerEntry> parse_entry(std::string_view content, const std::string& file) {
  const Expected<nlohmann::json> document = parse_strict_json(content, file);
  if (!document) return failure(corrupt(file, "an entry is no JSON: " + document.error().what));
  PANELCAL_TRY(LedgerEntry entry, read_json(kEntry, *document, Code::LedgerCorrupt, file));
  const LedgerRecord& record = entry.record;
  const auto n = static_cast<Eigen::Index>(record.parameters.size());
  if (record.covariance && record.covariance->rows() != n) {
    return failure(corrupt(file, fmt::format("the covariance of an entry is not {0} x {0}", n)));
  }
  return entry;
}

std::string chained_hash(std::string_view previous_hash, std::string_view content) {
  std::string text(previous_hash);
  text += '\n';
  text += content;
  return sha256(text);
}

}  // namespace panelcal::internal

namespace panelcal {

std::string ledger_entry_json(const LedgerEntry& entry) {
  return internal::json_text(internal::kEntry, entry, internal::JsonStyle::Compact);
}

}  // namespace panelcal
