// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/gates.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace panelcal {
namespace {

int decimals_of(std::string_view unit) {
  return unit == "mm" || unit == "mrad" ? 3 : 1;
}

GateVerdict verdict(std::string_view gate, double value, double limit, std::string_view unit) {
  // Written so that a NaN is refused.
  return {gate, value, limit, unit, value <= limit, std::nullopt};
}

GateVerdict residual_verdict(std::span<const double> residual_lengths_mm, Length limit) {
  std::size_t worst = 0;
  for (std::size_t i = 1; i < residual_lengths_mm.size(); ++i) {
    // A NaN stays the worst.
    if (!(residual_lengths_mm[i] <= residual_lengths_mm[worst])) worst = i;
    if (std::isnan(residual_lengths_mm[worst])) break;
  }
  const bool none = residual_lengths_mm.empty();
  const double value_mm = none ? 0 : residual_lengths_mm[worst];
  GateVerdict out = verdict("residual", value_mm * 1e3, limit.in_um(), "um");
  if (!none) out.i_target = worst;
  return out;
}

double stretch_ppm(const PanelDeformation& d) {
  // Not std::max, which can lose a NaN.
  double worst = 0;
  for (const double part : {d.scale_x - 1, d.scale_y - 1, d.shear}) {
    if (!(std::abs(part) <= worst)) worst = std::abs(part);
    if (std::isnan(worst)) break;
  }
  return worst * 1e6;
}

}  // namespace

std::string GateVerdict::text() const {
  std::string subject(gate);
  if (i_target) subject += fmt::format(" of target {}", *i_target + 1);
  // More decimals where a refused value would otherwise print as its limit.
  int decimals = decimals_of(unit);
  std::string shown = fmt::format("{:.{}f}", value, decimals);
  std::string bound = fmt::format("{:.{}f}", limit, decimals);
  while (!accepted && shown == bound && decimals < 12) {
    ++decimals;
    shown = fmt::format("{:.{}f}", value, decimals);
    bound = fmt::format("{:.{}f}", limit, decimals);
  }
  return fmt::format("{} is {} {}, limit {} {}", subject, shown, unit, bound, unit);
}

GateLimits share_false_alarm(GateLimits limits, std::size_t n_series) {
  if (limits.false_alarm && n_series > 1) {
    limits.false_alarm = *limits.false_alarm / static_cast<double>(n_series);
  }
  return limits;
}

bool all_accepted(std::span<const GateVerdict> verdicts) {
  return std::all_of(
      verdicts.begin(), verdicts.end(), [](const GateVerdict& v) { return v.accepted; });
}

std::vector<GateVerdict> internal::check_gates_raw(const Eigen::Matrix2d& linear,
                                                   const Eigen::Vector2d& mean_deviation_mm,
                                                   std::span<const double> residual_lengths_mm,
                                                   const GateLimits& limits) {
  const PanelDeformation deformation = deformation_of(linear);
  std::vector<GateVerdict> verdicts;
  if (limits.residual) {
    verdicts.push_back(residual_verdict(residual_lengths_mm, *limits.residual));
  }
  if (limits.rotation) {
    const double rotation_rad = std::abs(deformation.rotation_rad);
    verdicts.push_back(
        verdict("rotation", rotation_rad * 1e3, limits.rotation->in_rad() * 1e3, "mrad"));
  }
  if (limits.stretch_ppm) {
    verdicts.push_back(verdict("stretch", stretch_ppm(deformation), *limits.stretch_ppm, "ppm"));
  }
  if (limits.offset) {
    verdicts.push_back(verdict("offset", mean_deviation_mm.norm(), limits.offset->in_mm(), "mm"));
  }
  return verdicts;
}

}  // namespace panelcal
