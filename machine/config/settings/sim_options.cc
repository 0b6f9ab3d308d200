// SPDX-License-Identifier: Apache-2.0
#include "machine/config/settings/sim_options.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

bool is_finite(Length length) {
  return std::isfinite(length.in_mm());
}

Expected<void> invalid(std::string what, std::string expected) {
  return failure({Code::ConfigValue, {}, std::move(what), std::move(expected)});
}

}  // namespace

Expected<void> SimulatedProbeOptions::validate() const {
  const bool all_finite = is_finite(height) && is_finite(bow) && bow_center.in_mm().allFinite() &&
                          std::isfinite(slope_x_ppm) && std::isfinite(slope_y_ppm) &&
                          std::ranges::all_of(axis_offsets, is_finite);
  if (!all_finite) {
    return invalid("height, slope, bow, bow_center or an axis_offset is not finite",
                   "finite numbers");
  }
  if (!is_finite(bow_radius) || !(bow_radius > Length())) {
    return invalid(fmt::format("bow_radius is {} mm", bow_radius.in_mm()), "more than 0");
  }
  if (!is_finite(noise_sigma) || !(noise_sigma >= Length())) {
    return invalid(fmt::format("noise_sigma is {} um", noise_sigma.in_um()), "0 or more");
  }
  if (chip && !(chip->place.in_mm().allFinite() && is_finite(chip->radius) &&
                chip->radius > Length() && is_finite(chip->depth) && chip->depth > Length())) {
    return invalid("the chip has no place, radius or depth", "radius and depth above 0");
  }
  if (axis_offsets.empty()) return invalid("axis_offsets is empty", "one for each Z axis");
  return {};
}

Eigen::Vector2d SimTable::error_mm(const Position<frame::Machine>& command) const {
  const Eigen::Vector2d at_mm = (command - center).in_mm();
  const Eigen::Vector2d part = at_mm / bow_radius.in_mm();
  return {scale_x_ppm * 1e-6 * at_mm.x() + squareness.in_rad() * at_mm.y() +
              bow_y.in_mm() * part.y() * part.y(),
          scale_y_ppm * 1e-6 * at_mm.y() + bow_x.in_mm() * part.x() * part.x()};
}

}  // namespace panelcal
