// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/ledger/ledger.h"

// Texts that `panelcal history` prints of a ledger.
namespace panelcal::history {

/// One JSON object on one line: the entry's content, its hash, whether it is in force, and the
/// calibration itself with every number as its digits are.
std::string entry_json(const LedgerEntry& entry, bool in_force, const std::string& result);

/// One line; entries in force are marked with a star.
std::string entry_line(const LedgerEntry& entry, bool in_force);

/// All there is to say of one entry but the calibration itself.
std::string entry_page(const LedgerEntry& entry, bool in_force);

/// One parameter in two entries.
struct ParameterChange {
  std::string name;
  std::string unit;
  std::optional<double> before;
  std::optional<double> after;
  /// Of after - before, taken as two independent measurements; empty if one is not known.
  std::optional<double> sigma;

  std::optional<double> change() const;
};

/// Every parameter of either entry, in the order of the first.
///
/// Fails  ledger-entry-invalid (the entries are of different kinds; a unit differs)
Expected<std::vector<ParameterChange>> changes_between(const LedgerEntry& before,
                                                       const LedgerEntry& after,
                                                       const std::string& file);
std::string changes_text(std::span<const ParameterChange> changes);

/// One parameter over time, a line for each entry that has it.
///
/// Fails  ledger-entry-unknown (no entry has it); names the file of `file`
Expected<std::string> series_text(const LedgerSeries& series,
                                  const LedgerKey& key,
                                  const std::string& parameter,
                                  const std::string& file);

}  // namespace panelcal::history
