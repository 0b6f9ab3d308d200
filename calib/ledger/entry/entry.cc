// SPDX-License-Identifier: Apache-2.0
#include "calib/ledger/entry/entry.h"

#include <array>

namespace panelcal {
namespace {

/// In the order of the enumerators.
constexpr std::array<std::string_view, 11> kKinds = {"spindle-camera",
                                                     "camera",
                                                     "table",
                                                     "probe",
                                                     "focus",
                                                     "surface",
                                                     "self-test",
                                                     "night",
                                                     "light",
                                                     "settle",
                                                     "coupon"};
constexpr std::array<std::string_view, 4> kVerdicts = {
    "measured", "installed", "refused", "rolled-back"};

template <class Enumeration, std::size_t kN>
std::optional<Enumeration> find(const std::array<std::string_view, kN>& words,
                                std::string_view word) {
  for (std::size_t i = 0; i < kN; ++i) {
    if (words[i] == word) return static_cast<Enumeration>(i);
  }
  return std::nullopt;
}

}  // namespace

std::string_view word(LedgerKind kind) {
  return kKinds[static_cast<std::size_t>(kind)];
}

std::string_view word(LedgerVerdict verdict) {
  return kVerdicts[static_cast<std::size_t>(verdict)];
}

std::optional<LedgerKind> ledger_kind(std::string_view word) {
  return find<LedgerKind>(kKinds, word);
}

std::optional<LedgerVerdict> ledger_verdict(std::string_view word) {
  return find<LedgerVerdict>(kVerdicts, word);
}

std::span<const std::string_view> ledger_kind_words() {
  return kKinds;
}

}  // namespace panelcal
