// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "calib/base/fields/field.h"
#include <nlohmann/json.hpp>

// Not installed: what a calibration's file notes of the ledger.
namespace panelcal::internal {

/// The newest entry of a ledger when a file was written. Held against the ledger later, it proves
/// that no entry up to there was deleted or rewritten.
struct NotedHead {
  enum class Use : std::uint8_t {
    Head,          ///< "head": the file is no entry's result
    RecordedAfter  ///< "recorded_after": the file is the result of a later entry, byte for byte
  };
  Use use = Use::Head;
  std::int64_t id = 0;  ///< 0: the ledger had no entry
  std::string hash;     ///< 64 hexadecimal digits; empty with 0

  friend bool operator==(const NotedHead&, const NotedHead&) = default;
};

/// A calibration's text with a last member "ledger": {"head": 7, "hash": "..."}, or {"head": 0} of
/// a ledger without entries.
///
/// In     text: an object of JSON that has members and no "ledger"
std::string with_noted_head(std::string text, const NotedHead& head);

/// Takes that member out of a parsed calibration; nothing if it has none.
///
/// Fails  calibration-invalid, with the file
Expected<std::optional<NotedHead>> take_noted_head(nlohmann::json& document,
                                                   const std::string& file);

/// The two forms of that member, for pages and schemas.
std::array<const TableDescription*, 2> noted_head_tables();

/// parse_strict_json of a calibration, whose readers need no ledger: without that member.
///
/// Fails  json-syntax; calibration-invalid
Expected<nlohmann::json> parse_calibration_json(std::string_view text, const std::string& file);

/// True for a hash as the ledger writes it.
bool is_ledger_hash(std::string_view text);

}  // namespace panelcal::internal
