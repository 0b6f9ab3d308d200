// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string_view>

#include "calib/base/fields/slots.h"
#include "machine/config/sections/sections.h"
#include "machine/config/toml/ranges.h"

namespace panelcal::internal {
namespace {

// A limit of 0 holds every panel: nothing measured is without error. More than a metre, half a turn
// or a tenth is no limit, but a wrong unit: "off" is one.
constexpr Range kRotation_mrad{.low = 0, .high = 3142, .low_is_open = true};
constexpr Range kStretch_ppm{.low = 0, .high = 1e5, .low_is_open = true};
constexpr Range kOffset_mm{.low = 0, .high = kMaxPlace_mm, .low_is_open = true};
constexpr Range kFalseAlarm{.low = 0, .high = 0.5, .low_is_open = true};

std::optional<bool> refusal_from_word(std::string_view word) {
  if (word == "refused") return true;
  if (word == "off") return false;
  return std::nullopt;
}

bool put_turned(GateLimits& limits, const FieldValue& value) {
  limits.turned_deg = static_cast<int>(value.whole);
  return limits.turned_deg % 90 == 0;
}

#include "machine/config/sections/gates.def"

Expected<void> read_gates(const TomlTable& top, MachineConfig& config) {
  GateLimits& base = config.walk.base_limits;
  GateLimits& nested = config.walk.nested_limits;
  PANELCAL_TRY(const auto table, top.read_table(kGates, base));
  if (!table) return {};
  if (!base.refuses_mirror && config.walk.bends_panel) {
    return failure(table->problem(
        "mirror", "\"refused\", or another model", "model = \"smooth\" fits no turned panel"));
  }
  nested = base;
  nested.refuses_mirror = true;
  nested.turned_deg = 0;
  PANELCAL_CHECK(table->read_table(kNestedGates, nested));
  return {};
}

}  // namespace

Section gate_section() {
  return {kGateTables, read_gates};
}

}  // namespace panelcal::internal
