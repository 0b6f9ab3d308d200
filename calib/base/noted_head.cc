// SPDX-License-Identifier: Apache-2.0
#include "calib/base/noted_head.h"

#include <array>
#include <utility>

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
  return text + fmt::format(",\n  \"{}\": {{\"{}\": {}, \"{}\": \"{}\"}}\n}}\n",
                            kLedgerKey,
                            noted_use(head.use),
                            head.id,
                            kHashKey,
                            head.hash);
}

Expected<std::optional<NotedHead>> take_noted_head(json& document, const std::string& file) {
  if (!document.is_object() || !document.contains(kLedgerKey)) return std::optional<NotedHead>();
  const json note = std::exchange(document[kLedgerKey], json());
  document.erase(kLedgerKey);
  NotedHead head;
  const bool is_recorded = note.is_object() && note.contains(kRecordedAfter);
  head.use = is_recorded ? NotedHead::Use::RecordedAfter : NotedHead::Use::Head;
  const std::array<std::string_view, 2> keys = {noted_use(head.use), kHashKey};
  PANELCAL_TRY(const StrictObject object,
               StrictObject::make(note, "\"ledger\"", keys, Code::CalibrationInvalid, file));
  const json& id = object.member(noted_use(head.use));
  PANELCAL_TRY(head.hash, object.text(kHashKey));
  const bool is_id = id.is_number_unsigned() && id.get<std::uint64_t>() <= kMaxEntries;
  if (!is_id || !is_ledger_hash(head.hash)) {
    return failure({Code::CalibrationInvalid,
                    {file, 0, 0},
                    "\"ledger\" is " + quoted(note.dump()),
                    "an entry's number and its hash of 64 hexadecimal digits"});
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
