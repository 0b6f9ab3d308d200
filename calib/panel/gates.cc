// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/gates.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

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

/// From where the panel is meant to lie. A panel that was turned over left to right is one that was
/// turned over top to bottom and then by 180 degrees: either is meant.
PanelDeformation deformation_from_meant(const Eigen::Matrix2d& linear, const GateLimits& limits) {
  Eigen::Matrix2d from_meant;
  for (int column = 0; column < 2; ++column) {
    from_meant.col(column) = turned_by(linear.col(column), 360 - limits.turned_deg);
  }
  PanelDeformation deformation = deformation_of(from_meant);
  if (limits.refuses_mirror || !(deformation.scale_y < 0)) return deformation;
  deformation.scale_y = -deformation.scale_y;
  const double half_turn = std::copysign(std::numbers::pi, deformation.rotation_rad);
  if (std::abs(deformation.rotation_rad) > std::numbers::pi / 2) {
    deformation.rotation_rad -= half_turn;
  }
  return deformation;
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

GateLimits default_gate_limits() {
  return {.residual = um(100), .rotation = deg(3), .stretch_ppm = 2000, .false_alarm = 1e-3};
}

std::vector<std::string_view> gates_off(const GateLimits& limits) {
  std::vector<std::string_view> off;
  if (!limits.residual) off.push_back("residual");
  if (!limits.rotation) off.push_back("rotation");
  if (!limits.stretch_ppm) off.push_back("stretch");
  if (!limits.false_alarm) off.push_back("false alarm");
  if (!limits.refuses_mirror) off.push_back("mirror");
  return off;
}

std::string gates_text(const GateLimits& limits) {
  std::vector<std::string> on;
  if (limits.residual) on.push_back(fmt::format("residual {:.6g} um", limits.residual->in_um()));
  if (limits.rotation) {
    on.push_back(fmt::format("rotation {:.6g} mrad", limits.rotation->in_rad() * 1e3));
    if (limits.turned_deg != 0) on.back() += fmt::format(" from {} degrees", limits.turned_deg);
  }
  if (limits.stretch_ppm) on.push_back(fmt::format("stretch {:.6g} ppm", *limits.stretch_ppm));
  if (limits.offset) on.push_back(fmt::format("offset {:.6g} mm", limits.offset->in_mm()));
  if (limits.false_alarm) on.push_back(fmt::format("false alarm {:.3g}", *limits.false_alarm));
  if (limits.refuses_mirror) on.push_back("no mirror");
  std::string out = fmt::format("{}", fmt::join(on, ", "));
  const std::vector<std::string_view> off = gates_off(limits);
  if (off.empty()) return out;
  return fmt::format("{}{}off: {}", out, out.empty() ? "" : "; ", fmt::join(off, ", "));
}

Eigen::Vector2d turned_by(const Eigen::Vector2d& place_mm, int turned_deg) {
  switch (turned_deg % 360) {
    case 90:
      return {-place_mm.y(), place_mm.x()};
    case 180:
      return -place_mm;
    case 270:
      return {place_mm.y(), -place_mm.x()};
    default:
      return place_mm;
  }
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
  const PanelDeformation deformation = deformation_from_meant(linear, limits);
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
