// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "machine/nightly/record/night_record.h"

// Reports of `panelcal nightly` on a night: five lines, a page, and the same as JSON.
namespace panelcal::nightly {

/// The origin of a report: key, value.
using Provenance = std::vector<std::pair<std::string, std::string>>;

/// A few lines for people who read mail: the verdict, what became of each calibration, what changed
/// since last week, the self-test, what is strange. Of nothing to say there is no line.
std::string night_text(const NightRecord& record);

/// All of a night as one JSON object with a line end (docs/formats/nightly.md). Numbers that are
/// none are null; any bytes in texts become valid UTF-8.
std::string night_json(const NightRecord& record, const Provenance& provenance);

/// The same for a person who has a minute: whether the machine may drill, what moved since last
/// week, then each calibration with its gates and charts.
///
/// Out    one HTML page, well-formed XML too; no scripts, nothing loaded from elsewhere
/// See    tests/tools/nightly/report_test.cc
std::string night_html(const NightRecord& record, const Provenance& provenance);

/// "2026-11-22 03:10 UTC"
std::string minute_text(std::chrono::sys_seconds time);

}  // namespace panelcal::nightly
