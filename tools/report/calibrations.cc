// SPDX-License-Identifier: Apache-2.0
#include "tools/report/calibrations.h"

#include <algorithm>
#include <cstddef>

#include "tools/figures/text.h"
#include <fmt/format.h>

namespace panelcal::report {
namespace {

/// More rows do not help.
constexpr std::size_t kMaxCalibrationRows = 50;

std::string calibration_row(const CalibrationAnswer& calibration) {
  return fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                     calibration.order.line,
                     escaped(calibration.order.command),
                     escaped(calibration.text));
}

}  // namespace

std::string calibrations_section(const Survey& survey) {
  const std::size_t n = survey.calibrations.size();
  if (n == 0) return {};
  std::string out =
      "<h2 id=\"calibrations\">Calibrations in this job</h2>\n<section>\n<p>What was measured "
      "behind each of them counts with its offset and its uncertainty. Nothing is installed: the "
      "next job begins with the machine's file again.</p>\n<table><tr><th>line</th><th>order</th>"
      "<th>found</th></tr>\n";
  for (std::size_t i = 0; i < std::min(n, kMaxCalibrationRows); ++i)
    out += calibration_row(survey.calibrations[i]);
  out += "</table>\n";
  if (n > kMaxCalibrationRows) {
    out += fmt::format("<p class=\"quiet\">And {} more.</p>\n", n - kMaxCalibrationRows);
  }
  return out + "</section>\n";
}

}  // namespace panelcal::report
