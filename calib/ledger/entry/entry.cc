// SPDX-License-Identifier: Apache-2.0
#include "calib/ledger/entry/entry.h"

#include <algorithm>
#include <array>

namespace panelcal {
namespace {

/// In the order of the enumerators.
constexpr std::string_view kKinds[] = {
#define PANELCAL_KIND(enumerator, word) word,
#include "calib/ledger/entry/kinds.def"
};
constexpr CalibrationWords kCalibrationWords[] = {
#define PANELCAL_CALIBRATION(enumerator, word, step, at_mark, calibrations) {word, at_mark},
#include "calib/ledger/entry/kinds.def"
};
constexpr std::array<std::string_view, 4> kVerdicts = {
    "measured", "installed", "refused", "rolled-back"};

template <class Enumeration>
std::optional<Enumeration> find(std::span<const std::string_view> words, std::string_view word) {
  for (std::size_t i = 0; i < words.size(); ++i) {
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

std::span<const CalibrationWords> calibration_words() {
  return kCalibrationWords;
}

std::optional<std::size_t> LedgerRecord::find(std::string_view name) const {
  const auto found = std::ranges::find(parameters, name, &LedgerParameter::name);
  if (found == parameters.end()) return std::nullopt;
  return static_cast<std::size_t>(found - parameters.begin());
}

std::optional<LedgerValues> values_of(const LedgerRecord& record,
                                      std::span<const std::string_view> names) {
  if (!record.covariance) return std::nullopt;
  LedgerValues out;
  out.value.resize(static_cast<Eigen::Index>(names.size()));
  std::vector<Eigen::Index> rows;
  for (const std::string_view name : names) {
    const auto i = record.find(name);
    if (!i) return std::nullopt;
    out.value[static_cast<Eigen::Index>(rows.size())] = record.parameters[*i].value;
    rows.push_back(static_cast<Eigen::Index>(*i));
  }
  out.cov = (*record.covariance)(rows, rows);
  return out;
}

}  // namespace panelcal
