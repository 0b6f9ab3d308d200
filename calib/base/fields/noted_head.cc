// SPDX-License-Identifier: Apache-2.0
#include "calib/base/fields/noted_head.h"

#include <array>
#include <cstddef>
#include <utility>

#include "calib/base/fields/json.h"
#include "calib/base/fields/slots.h"
#include "calib/base/json/strict_json.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using nlohmann::json;

constexpr const char* kLedgerKey = "ledger";
constexpr std::size_t kHashChars = 64;
constexpr WholeRange kEntries = {0, std::int64_t{1} << 53};

#include "calib/base/fields/noted_head.def"

const JsonTable<NotedHead>& noted_table(NotedHead::Use use) {
  return use == NotedHead::Use::Head ? kNotedHead : kRecordedAfter;
}

}  // namespace

bool is_ledger_hash(std::string_view text) {
  return text.size() == kHashChars &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

std::string with_noted_head(std::string text, const NotedHead& head) {
  text.resize(text.rfind('}'));
  text.resize(text.find_last_not_of("\n ") + 1);
  const std::string note = json_text(noted_table(head.use), head, JsonStyle::File);
  return text + fmt::format(",\n  \"{}\": {}}}\n", kLedgerKey, note);
}

Expected<std::optional<NotedHead>> take_noted_head(json& document, const std::string& file) {
  if (!document.is_object() || !document.contains(kLedgerKey)) return std::optional<NotedHead>();
  const json note = std::exchange(document[kLedgerKey], json());
  document.erase(kLedgerKey);
  const bool is_recorded = note.is_object() && note.contains("recorded_after");
  const auto use = is_recorded ? NotedHead::Use::RecordedAfter : NotedHead::Use::Head;
  PANELCAL_TRY(NotedHead head, read_json(noted_table(use), note, Code::CalibrationInvalid, file));
  head.use = use;
  if (head.id == 0 ? head.hash.empty() && !note.contains("hash") : is_ledger_hash(head.hash)) {
    return std::optional(std::move(head));
  }
  return failure({Code::CalibrationInvalid,
                  {file, 0, 0},
                  "\"ledger\" is " + quoted(note.dump()),
                  "an entry's number and its hash of 64 hexadecimal digits, or 0 and no hash"});
}

std::array<const TableDescription*, 2> noted_head_tables() {
  return {&kNotedHead, &kRecordedAfter};
}

Expected<json> parse_calibration_json(std::string_view text, const std::string& file) {
  PANELCAL_TRY(json document, parse_strict_json(text, file));
  PANELCAL_CHECK(take_noted_head(document, file));
  return document;
}

}  // namespace panelcal::internal
