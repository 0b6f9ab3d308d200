// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/expected.h"
#include "calib/drift/amount.h"
#include "machine/calibrate/calibration.h"
#include "machine/config/machine_config.h"
#include "machine/config/settings/nightly_options.h"
#include <fmt/format.h>

// Not installed: what the kinds of calibrations share.
namespace panelcal::internal {

using Calibrations = std::vector<std::unique_ptr<Calibration>>;

/// A list of this one.
Calibrations only_calibration(std::unique_ptr<Calibration> one);

/// Says that machine.toml lacks something that a night cannot do without (config-value).
struct Missing {
  const NightlyConfig& nightly;
  std::string_view begin;  ///< of the message: "[nightly] calibrates the table, and "

  /// In     what: what is wrong; expected: the key
  tl::unexpected<Diagnostic> operator()(std::string_view what, std::string expected) const;
};

/// A report's lines, without their ends.
std::vector<std::string> lines_of(const std::string& text);

/// The date of bytes that such a reader of calibration files takes.
template <class Parse>
Expected<std::chrono::sys_seconds> date_by(const Parse& parse,
                                           const std::string& bytes,
                                           const std::string& name) {
  const auto calibration = parse(bytes, name);
  if (!calibration) return failure(calibration.error());
  return calibration->date;
}

/// A number against its upper limit; both stand in the text.
NightGate limit_gate(std::string name,
                     double value,
                     double limit,
                     fmt::format_string<std::string, std::string> text,
                     const std::string& unit = "mm");

/// A gate that only a reason not to pass it speaks against.
NightGate reason_gate(std::string name, const std::string& reason, std::string_view passed);

/// The scatter of a fit's residuals; none where nothing is left to estimate it.
std::vector<NightSpread> fit_spread(NightSpread named, double rms, std::size_t n);

}  // namespace panelcal::internal
