// SPDX-License-Identifier: Apache-2.0
#include "surface/map/height_tolerance.h"

#include <cmath>
#include <cstddef>

#include <fmt/format.h>

namespace panelcal {
namespace {

/// A deviation of just the tolerance is allowed, however the difference is rounded.
constexpr double kRounding_mm = 1e-9;

bool fits(std::size_t n_values, std::size_t n_axes) {
  return n_values == 1 || n_values == n_axes;
}

double of_axis_mm(std::span<const Length> values, std::size_t axis) {
  return (values.size() == 1 ? values.front() : values[axis]).in_mm();
}

}  // namespace

tl::expected<void, std::string> check_height(std::string_view command,
                                             std::span<const HeightEstimate> measured,
                                             std::span<const Length> reference,
                                             std::span<const Length> tolerance) {
  const std::size_t n_axes = measured.size();
  if (n_axes == 0 || !fits(reference.size(), n_axes) || !fits(tolerance.size(), n_axes)) {
    return tl::unexpected(
        fmt::format("there are {} heights, {} references and {} tolerances ({}); expected one for "
                    "each Z axis",
                    n_axes,
                    reference.size(),
                    tolerance.size(),
                    command));
  }
  std::string worst;
  double worst_excess_mm = 0;
  for (std::size_t axis = 0; axis < n_axes; ++axis) {
    const double height_mm = measured[axis].height.in_mm();
    const double reference_mm = of_axis_mm(reference, axis);
    const double tolerance_mm = of_axis_mm(tolerance, axis);
    const double excess_mm = std::abs(height_mm - reference_mm) - tolerance_mm;
    // Written so that a NaN is an excess.
    if (excess_mm <= kRounding_mm || excess_mm <= worst_excess_mm) continue;
    worst_excess_mm = excess_mm;
    worst = fmt::format(
        "the surface under zaxis {} is at {:.4f} mm, {:+.4f} mm off its reference; "
        "expected at most {:.4f} mm ({})",
        axis,
        height_mm,
        height_mm - reference_mm,
        tolerance_mm,
        command);
  }
  if (worst.empty()) return {};
  return tl::unexpected(worst);
}

}  // namespace panelcal
