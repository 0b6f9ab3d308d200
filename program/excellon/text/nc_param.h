// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "calib/base/expected.h"
#include "program/text/source_text.h"
#include "program/walk/options.h"

namespace panelcal::excellon {

/// Name of the file in which Allegro PCB Editor keeps the format of the drill files beside it.
inline constexpr std::string_view kNcParamName = "nc_param.txt";

/// Reads OUTPUT-UNITS, INTEGER-PLACES, DECIMAL-PLACES, SUPPRESS-LEAD-ZEROES, SUPPRESS-TRAIL-ZEROES
/// and COORDINATES; other lines are passed over. Neither and both of the two on zeros leave
/// these open: numbers with all their digits are the same with either.
///
/// Fails  argument-invalid: one of them with another value than the editor writes, twice, or in
///        another spelling; INTEGER-PLACES or DECIMAL-PLACES without the other
/// See    tests/program/excellon/text/nc_param_test.cc
Expected<FormatBeside> read_nc_param(const SourceText& source);

}  // namespace panelcal::excellon
