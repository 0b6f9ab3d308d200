// SPDX-License-Identifier: Apache-2.0
#pragma once

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

namespace panelcal {

/// Places that a run drills that begins at `first`, which G39 says: rows_per_run rows of columns,
/// row by row; from right to left in every other row, so that no way is long.
std::vector<Position<frame::Machine>> places_from(const Coupon& coupon,
                                                  const Position<frame::Machine>& first);

/// The same at a row of the coupon, from 0.
std::vector<Position<frame::Machine>> places_of_row(const Coupon& coupon, int i_row);

/// "rows 4 to 10 of coupon "A" are free (7 of 10): 2 runs of 3 rows".
std::string free_rows_text(const Coupon& coupon, int n_used);

/// Number of rows of the coupon that are used up; 0 if it is unused.
///
/// Fails  json-syntax, calibration-invalid (the state file is damaged: which rows are free is not
///        guessed at); file-unreadable
Expected<int> used_rows(const Coupon& coupon);

/// Takes the rows of one run, and writes that down before anybody drills: whatever happens then,
/// no row is drilled twice.
///
/// Out    the first row, from 0
/// Fails  as used_rows; config-value (too few rows are left); device-write
/// See    tests/machine/calibrate/spindle/coupon_test.cc
Expected<int> take_rows(const Coupon& coupon);

}  // namespace panelcal
