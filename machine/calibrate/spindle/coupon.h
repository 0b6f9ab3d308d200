// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/diagnostic.h"
#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/spindle/fit.h"
#include "machine/config/settings/coupon_options.h"
#include "machine/config/settings/machine.h"
#include "machine/devices/calibration_devices.h"

namespace panelcal {

/// Places that a run drills that begins at `first`, which G39 says: rows_per_run rows of columns,
/// row by row; from right to left in every other row, so that no way is long.
std::vector<Position<frame::Machine>> places_from(const Coupon& coupon,
                                                  const Position<frame::Machine>& first);

/// The same at a row of the coupon, from 0.
std::vector<Position<frame::Machine>> places_of_row(const Coupon& coupon, int i_row);

/// "rows 4 to 10 of coupon "A" are free (7 of 10): 2 runs of 3 rows".
std::string free_rows_text(const Coupon& coupon, int n_used);

/// Number of rows of a coupon that are used up: by its state file, and by the ledger.
struct UsedRows {
  int by_file = 0;               ///< 0 if it is of another coupon, or not there
  std::optional<int> by_ledger;  ///< absent: no ledger, or no coupon of this name in it

  /// The larger: an older state file put back, or a deleted one, frees no drilled row.
  int count() const { return std::max(by_file, by_ledger.value_or(0)); }
};

/// Of [coupon], and of [ledger] if machine.toml names one.
///
/// Precondition: there is a [coupon]
/// Fails  json-syntax, calibration-invalid (the state file is damaged: which rows are free is not
///        guessed at); file-unreadable; what the ledger reports
Expected<UsedRows> used_rows(const MachineConfig& config);

/// "", or that the state file has fewer rows than the ledger.
std::string missing_rows_text(const Coupon& coupon, const UsedRows& used);

/// Takes the rows of one run, and writes that down before the first hole, first into the ledger (a
/// `coupon` entry with the state as its result), then into the state file: whatever happens then,
/// no row is drilled twice.
///
/// Out    the first row, from 0
/// Fails  as TakenBy::check_ledger and used_rows; config-value (too few rows are left);
/// ledger-entry-invalid (no clock);
///        device-write
/// See    tests/machine/calibrate/spindle/coupon_test.cc
Expected<int> take_rows(const MachineConfig& config, const TakenBy& by);

}  // namespace panelcal
