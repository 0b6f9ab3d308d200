// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "program/walk/survey.h"

namespace panelcal::report {

/// The causes why a series may not fit, likeliest first, and the targets left out of its
/// fit; empty for a healthy one.
///
/// See    tests/tools/report/fits/causes_test.cc
std::string causes_block(const Survey& survey, const SeriesResult& series);

}  // namespace panelcal::report
