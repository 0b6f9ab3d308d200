// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/record/night_record.h"

#include <array>

namespace panelcal {
namespace {

/// In the order of the enumerators.
constexpr std::array<std::string_view, 6> kStates = {
    "installed", "kept old", "hold", "failed", "not reached", "would run"};

}  // namespace

std::string_view name(NightState state) {
  return kStates[static_cast<std::size_t>(state)];
}

std::optional<NightState> night_state(std::string_view word) {
  for (std::size_t i = 0; i < kStates.size(); ++i) {
    if (kStates[i] == word) return static_cast<NightState>(i);
  }
  return std::nullopt;
}

int exit_code(const NightRecord& record) {
  switch (record.outcome) {
    case NightOutcome::AllInstalled:
      return 0;
    case NightOutcome::Refused:
      return 1;
    case NightOutcome::Failed:
      break;
  }
  return 3;
}

}  // namespace panelcal
