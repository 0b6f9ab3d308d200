// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/diagnostic.h"
#include "machine/job/summary/truth_comparison.h"
#include "program/judge/depth_verdict.h"
#include "program/judge/job_verdict.h"
#include "program/judge/tally.h"
#include "program/walk/survey.h"
#include "tools/report/input/budget.h"
#include "tools/report/input/input.h"
#include "tools/report/input/views.h"

namespace panelcal {

/// One self-contained HTML page: verdict first, then the panel with holes and residual arrows,
/// every fiducial's picture, the fits with their uncertainties in words and numbers, and what was
/// refused.
///
/// Out    well-formed XML as well as HTML; no scripts, nothing loaded from elsewhere
/// Cost   O(measurements + sampled holes); 20,000 holes take about 250 kB
/// See    tests/tools/report/html_test.cc, html_tolerance_test.cc
std::string report_html(const ReportInput& input);

}  // namespace panelcal
