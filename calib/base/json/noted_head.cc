// SPDX-License-Identifier: Apache-2.0
#include "calib/base/json/noted_head.h"

#include <cstddef>
#include <utility>
#include <vector>

#include "calib/base/json/strict_json.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using nlohmann::json;

constexpr const char* kLedgerKey = "ledger";
constexpr std::string_view kHead = "head";
constexpr std::string_view kRecordedAfter = "recorded_after";
constexpr std::string_view kHashKey = "hash";
constexpr std::size_t kHashChars = 64;
constexpr std::int64_t kMaxEntries = std::int64_t{1} << 53;

std::string_view noted_use(NotedHead::Use use) {
  return use == NotedHead::Use::Head ? kHead : kRecordedAfter;
}

}  // namespace

bool is_ledger_hash(std::string_view text) {
  return text.size() == kHashChars &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

std::string with_noted_head(std::string text, const NotedHead& head) {
  text.resize(text.rfind('}'));
  text.resize(text.find_last_not_of("\n ") + 1);
  text += fmt::format(",\n  \"{}\": {{\"{}\": {}", kLedgerKey, noted_use(head.use), head.id);
  if (head.id > 0) text += fmt::format(", \"{}\": \"{}\"", kHashKey, head.hash);
  return text + "}\n}\n";
}

Expected<std::optional<NotedHead>> take_noted_head(json& document, const std::string& file) {
  if (!document.is_object() || !document.contains(kLedgerKey)) return std::optional<NotedHead>();
  const json note = std::exchange(document[kLedgerKey], json());
  document.erase(kLedgerKey);
  NotedHead head;
  const bool is_recorded = note.is_object() && note.contains(kRecordedAfter);
  head.use = is_recorded ? NotedHead::Use::RecordedAfter : NotedHead::Use::Head;
  std::vector<std::string_view> keys = {noted_use(head.use)};
  const bool has_hash = note.is_object() && note.contains(kHashKey);
  if (has_hash) keys.push_back(kHashKey);
  PANELCAL_TRY(const StrictObject object,
               StrictObject::make(note, "\"ledger\"", keys, Code::CalibrationInvalid, file));
  const json& id = object.member(noted_use(head.use));
  if (has_hash) {
    PANELCAL_TRY(head.hash, object.text(kHashKey));
  }
  const bool is_id = id.is_number_unsigned() && id.get<std::uint64_t>() <= kMaxEntries;
  const bool is_whole = is_id && (id == 0 ? !has_hash : is_ledger_hash(head.hash));
  if (!is_whole) {
    return failure({Code::CalibrationInvalid,
                    {file, 0, 0},
                    "\"ledger\" is " + quoted(note.dump()),
                    "an entry's number and its hash of 64 hexadecimal digits, or 0 and no hash"});
  }
  head.id = id.get<std::int64_t>();
  return std::optional(std::move(head));
}

Expected<json> parse_calibration_json(std::string_view text, const std::string& file) {
  PANELCAL_TRY(json document, parse_strict_json(text, file));
  PANELCAL_CHECK(take_noted_head(document, file));
  return document;
}

}  // namespace panelcal::internal
