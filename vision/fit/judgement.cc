// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/judgement.h"

#include <cmath>

#include <fmt/format.h>

namespace panelcal::internal {

Problem contrast_problem(double contrast, double least) {
  if (contrast >= least) return std::nullopt;
  return fmt::format(
      "its contrast is {:.1f} grey levels, at least {:.1f} are asked for (min_contrast)",
      contrast,
      least);
}

Problem score_problem(double score, double least) {
  if (!(score < least)) return std::nullopt;
  return fmt::format("its score is {:.2f}, at least {:.2f} is asked for (min_score)", score, least);
}

Problem turn_problem(double turn_rad, double sigma_rad, double tolerance_rad) {
  constexpr double kSigmas = 3;
  if (!(std::abs(turn_rad) > tolerance_rad + kSigmas * sigma_rad)) return std::nullopt;
  return fmt::format("it is turned by {:+.2f} degrees; {:.2f} are allowed",
                     rad(turn_rad).in_deg(),
                     rad(tolerance_rad).in_deg());
}

Problem size_problem(const FitFrame& fit_frame,
                     std::string_view what,
                     double seen,
                     double asked,
                     double tolerance,
                     double slack) {
  const double deviation = seen / asked - 1;
  if (std::abs(deviation) <= tolerance + slack) return std::nullopt;
  const double unit = fit_frame.unit();
  return fmt::format("{} is {:.4g} {}, {:+.1f} % from {:.4g}; {:.1f} % are allowed",
                     what,
                     seen * unit,
                     fit_frame.mapping() ? "mm" : "px",
                     100 * deviation,
                     asked * unit,
                     100 * tolerance);
}

}  // namespace panelcal::internal
