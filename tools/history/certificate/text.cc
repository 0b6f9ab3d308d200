// SPDX-License-Identifier: Apache-2.0

#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "calib/base/amount.h"
#include "calib/base/clock.h"
#include "calib/base/diagnostic.h"
#include "tools/cli/place_text.h"
#include "tools/history/certificate/facts.h"
#include <fmt/format.h>

namespace panelcal::history {
namespace {

using report::fixed;
using report::one_line;

/// Words for the keys of the facts.
std::string certificate_word(std::string_view key) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 9> kWords = {{
      {"offset", "spindle-camera offset"},
      {"nights", "from night to night"},
      {"look", "look at a target"},
      {"drill", "drill and stage at a hole"},
      {"map", "map of the table"},
      {"table", "error of the table, unmapped"},
      {"reversal", "reversal value B"},
      {"repeatability", "unidirectional repeatability R (4 s)"},
      {"range", "range of the mean deviations"},
  }};
  for (const auto& [one, words] : kWords) {
    if (one == key) return std::string(words);
  }
  std::string words(key);
  for (char& c : words) {
    if (c == '_') c = ' ';
  }
  return words;
}

std::string degrees_text(const std::optional<double>& degrees) {
  return degrees ? fixed(*degrees, 1) : "-";
}

void add_repeatability(const Certificate& certificate, std::string& out) {
  out += "\nrepeatability, type A, over the nights\n";
  out += fmt::format("  {:<26} {:>10} {:>8} {:>19} {:>7}\n", "", "sigma", "dof", "95 %", "nights");
  std::string_view subject;
  for (const Repeatability& one : certificate.repeatability) {
    if (one.subject != subject) out += "  " + one_line(one.subject) + "\n";
    subject = one.subject;
    const bool is_length = one.unit == "mm";
    const double factor = is_length ? 1e3 : 1;
    const auto interval = one.scatter.interval();
    out += fmt::format("    {:<24} {:>7} {:<2} {:>8} {:>19} {:>7}\n",
                       one_line(one.name),
                       fixed(factor * one.scatter.sigma(), 3),
                       is_length ? "um" : one_line(one.unit),
                       fixed(one.scatter.degrees_of_freedom, 0),
                       fixed(factor * interval[0], 3) + " to " + fixed(factor * interval[1], 3),
                       one.n_nights);
  }
}

void add_gauge(const GaugeStudy& gauge, std::string& out) {
  const auto row = [&](std::string_view name, double variance, double degrees) {
    out += fmt::format("    {:<40} {:>8} um {:>8}\n",
                       name,
                       fixed(1e3 * std::sqrt(variance), 3),
                       fixed(degrees, 1));
  };
  out += fmt::format("  {:<42} {:>11} {:>8}\n", "gauge R&R of the camera", "sigma", "dof");
  row("repeatability (looks at a hole)",
      gauge.repeatability.variance,
      gauge.repeatability.degrees_of_freedom);
  row("reproducibility (from night to night)",
      gauge.reproducibility_variance(),
      gauge.over_nights.degrees_of_freedom);
  const Scatter both = gauge.both();
  row("R&R", both.variance, both.degrees_of_freedom);
  if (gauge.percent_of_tolerance) {
    out += fmt::format("    {:<40} {:>8} %\n",
                       "6 R&R of the tolerance 2 T",
                       fixed(*gauge.percent_of_tolerance, 1));
  }
}

void add_budget(const UncertaintyBudget& budget, std::string& out) {
  out += fmt::format("  {:<30} {:>5} {:>9} {:>9} {:>8}  {}\n",
                     "uncertainty budget of a hole",
                     "type",
                     "x um",
                     "y um",
                     "dof",
                     "from");
  for (const BudgetRow& row : budget.rows) {
    out += fmt::format("    {:<28} {:>5} {:>9} {:>9} {:>8}  {}\n",
                       certificate_word(row.source),
                       row.type,
                       fixed(1e3 * row.sigma_mm[0], 3),
                       fixed(1e3 * row.sigma_mm[1], 3),
                       degrees_text(row.degrees_of_freedom),
                       one_line(row.origin));
  }
  const auto combined = budget.combined_mm();
  const auto degrees = budget.degrees_of_freedom();
  const auto factor = budget.coverage_factor();
  const auto line = [&](std::string_view name, double x, double y, int n_decimals) {
    out += fmt::format(
        "    {:<28} {:>5} {:>9} {:>9}\n", name, "", fixed(x, n_decimals), fixed(y, n_decimals));
  };
  line("combined u", 1e3 * combined[0], 1e3 * combined[1], 3);
  out += fmt::format("    {:<28} {:>5} {:>9} {:>9}\n",
                     "effective dof",
                     "",
                     degrees_text(degrees[0]),
                     degrees_text(degrees[1]));
  line(fmt::format("coverage factor k ({} %)", fixed(100 * kCoverage, 2)), factor[0], factor[1], 2);
  line("expanded U = k u", 1e3 * factor[0] * combined[0], 1e3 * factor[1] * combined[1], 2);
  for (const std::string& source : budget.missing) {
    out += fmt::format("    without: {}\n", certificate_word(source));
  }
}

void add_spindle(const SpindleCertificate& spindle, std::string& out) {
  out += fmt::format("\n{}: {}", one_line(spindle.subject), amount(spindle.nights.size(), "night"));
  if (!spindle.nights.empty()) {
    out += fmt::format(
        ", {} to {}", iso_8601(spindle.nights.front().time), iso_8601(spindle.nights.back().time));
  }
  if (spindle.fresh_start) out += fmt::format(", since the fresh start {}", *spindle.fresh_start);
  if (spindle.n_refused > 0) out += fmt::format("; {} refused, left out", spindle.n_refused);
  if (spindle.n_rolled_back > 0) {
    out += fmt::format("; {} rolled back, left out", spindle.n_rolled_back);
  }
  out += "\n";
  if (spindle.gauge) add_gauge(*spindle.gauge, out);
  if (spindle.budget) add_budget(*spindle.budget, out);
}

void add_stage(const Certificate& certificate, std::string& out) {
  if (certificate.stage.empty()) return;
  out += fmt::format("\n{:<48} {:>10} {:>12} {:>7}  from\n", "stage", "value", "sigma", "nights");
  for (const StageFigure& figure : certificate.stage) {
    const bool is_length = figure.unit == "mm";
    const double factor = is_length ? 1e3 : 1e6;
    const std::string_view unit = is_length ? "um" : figure.unit == "rad" ? "urad" : "ppm";
    out += fmt::format("  {:<2} {:<40} {:>10} {:<4} {:>9} {:>7}  {}\n",
                       figure.axis,
                       certificate_word(figure.quantity),
                       fixed(factor * figure.value, 3),
                       unit,
                       figure.sigma ? fixed(factor * *figure.sigma, 3) : "-",
                       figure.n_nights,
                       one_line(figure.origin));
  }
}

void add_plate(const PlateTrace& trace, std::string& out) {
  const CalibrationPlate& plate = trace.plate;
  out += fmt::format("\nplate {}, of the table in entry {}: {}",
                     quoted(plate.name),
                     trace.entry,
                     plate.is_certified ? "certified" : "not certified");
  if (!plate.certificate.empty()) out += ", " + quoted(plate.certificate);
  if (plate.expanded_uncertainty) {
    out += fmt::format(", U {} um with k = {}",
                       fixed(plate.expanded_uncertainty->in_um(), 3),
                       fixed(plate.coverage_factor, 2));
  }
  out += fmt::format("\n  {}, sha256 {}\n", quoted(plate.file.string(), 200), trace.sha256);
}

}  // namespace

std::string certificate_text(const Certificate& certificate, const std::string& verified) {
  std::string out =
      fmt::format("quality certificate of {}\nledger: {}", one_line(certificate.machine), verified);
  if (certificate.tolerance_mm) {
    out += fmt::format("tolerance: T = {} um, {}\n",
                       fixed(1e3 * *certificate.tolerance_mm, 1),
                       certificate.tolerance_origin);
  }
  add_repeatability(certificate, out);
  for (const SpindleCertificate& spindle : certificate.spindles) add_spindle(spindle, out);
  add_stage(certificate, out);
  if (certificate.plate) add_plate(*certificate.plate, out);
  out += "\nnot measured\n";
  for (const NotMeasured& one : certificate.not_measured) {
    out += fmt::format("  {}: {}\n", one_line(one.what), one_line(one.why));
  }
  return out;
}

}  // namespace panelcal::history
