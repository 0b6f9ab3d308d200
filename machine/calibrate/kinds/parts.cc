// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/kinds/parts.h"

#include <sstream>

namespace panelcal::internal {

Calibrations only_calibration(std::unique_ptr<Calibration> one) {
  Calibrations out;
  out.push_back(std::move(one));
  return out;
}

tl::unexpected<Diagnostic> Missing::operator()(std::string_view what, std::string expected) const {
  return failure(
      {Code::ConfigValue, nightly.place, fmt::format("{}{}", begin, what), std::move(expected)});
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

NightGate limit_gate(std::string name,
                     double value,
                     double limit,
                     fmt::format_string<std::string, std::string> text,
                     const std::string& unit) {
  return {
      std::move(name), value <= limit, fmt::format(text, amount(value, unit), amount(limit, unit))};
}

NightGate reason_gate(std::string name, const std::string& reason, std::string_view passed) {
  return {std::move(name), reason.empty(), reason.empty() ? std::string(passed) : reason};
}

std::vector<NightSpread> fit_spread(NightSpread named, double rms, std::size_t n) {
  if (!(named.degrees_of_freedom > 0)) return {};
  named.variance = rms * rms * static_cast<double>(n) / named.degrees_of_freedom;
  return {std::move(named)};
}

}  // namespace panelcal::internal
