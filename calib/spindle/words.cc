// SPDX-License-Identifier: Apache-2.0
// Words of a fit of the spindle-camera offset for people.
#include <cmath>
#include <string_view>

#include "calib/base/amount.h"
#include "calib/spindle/fit.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

double sigma_um(const SpindleCameraFit& fit, Eigen::Index axis) {
  return 1e3 * std::sqrt(fit.offset.cov_mm2(axis, axis));
}

std::string of_both(const std::array<Length, 2>& lengths, bool are_unequal) {
  if (!are_unequal) return fmt::format("{:.2f}", lengths[0].in_um());
  return fmt::format("x {:.2f}, y {:.2f}", lengths[0].in_um(), lengths[1].in_um());
}

std::string scatter_line(std::string_view name, const ScatterEstimate& scatter, bool are_unequal) {
  if (scatter.sigma[0] == Length() && scatter.sigma[1] == Length()) {
    return fmt::format(
        "{}: none seen, at most about {} um\n", name, of_both(scatter.high, are_unequal));
  }
  return fmt::format("{}: {} um, 95 % within {} to {} um\n",
                     name,
                     of_both(scatter.sigma, are_unequal),
                     of_both(scatter.low, are_unequal),
                     of_both(scatter.high, are_unequal));
}

std::string scatter_lines(const SpindleCameraFit& fit) {
  if (fit.is_separated) {
    return scatter_line("between holes (drill wander)", fit.wander, fit.has_unequal_axes) +
           scatter_line("between looks (repeatability)", fit.repeatability, fit.has_unequal_axes);
  }
  return scatter_line("drill wander and repeatability together", fit.wander, fit.has_unequal_axes) +
         "each hole was looked at once, so that they cannot be separated\n";
}

std::string backlash_line(const BacklashEstimate& backlash, char axis) {
  if (!backlash.is_determined) {
    return fmt::format("backlash along {}: not determined, no looks from several sides\n", axis);
  }
  return fmt::format("backlash along {}: {:.2f} um, sigma {:.2f} um\n",
                     axis,
                     backlash.value.in_um(),
                     backlash.sigma.in_um());
}

std::string trend_line(const std::optional<ResidualTrend>& trend,
                       std::string_view where,
                       std::string_view cause) {
  if (!trend) return fmt::format("trend over {}: not determined\n", where);
  return fmt::format(
      "trend over {}: turn {:.3f} +- {:.3f} mrad, growth {:.0f} +- {:.0f} ppm, chance {:.2g}{}\n",
      where,
      1e3 * trend->rotation_rad,
      1e3 * trend->rotation_sigma_rad,
      trend->scale_ppm,
      trend->scale_sigma_ppm,
      trend->chance,
      trend->is_significant ? fmt::format(": {}", cause) : "");
}

std::string hole_lines(const SpindleCameraFit& fit) {
  std::string lines;
  for (std::size_t i = 0; i < fit.holes.size(); ++i) {
    const CouponHoleResidual& hole = fit.holes[i];
    const Eigen::Vector2d residual_um = 1e3 * hole.residual.in_mm();
    lines += fmt::format("hole {}: {:+.2f}, {:+.2f} um", i + 1, residual_um.x(), residual_um.y());
    if (hole.chance) lines += fmt::format(", chance {:.2g}", *hole.chance);
    lines += hole.is_outlier ? ", left out\n" : "\n";
  }
  return lines;
}

std::string outlook_lines(const SpindleCameraFit& fit) {
  std::string lines =
      fmt::format("{} would halve the uncertainty\n", amount(fit.more_holes_to_halve, "more hole"));
  if (fit.more_views_to_halve) {
    lines += fmt::format("so would {} more looks at each hole\n", *fit.more_views_to_halve);
  } else if (fit.is_separated) {
    lines += "more looks at the same holes could not\n";
  }
  return lines;
}

}  // namespace

std::string text(SpindleCameraFailure failure) {
  switch (failure) {
    case SpindleCameraFailure::BadOptions:
      return "an option of the fit is outside its bounds";
    case SpindleCameraFailure::BadInput:
      return "a hole has no look, or a look's numbers are not finite or its covariance is not "
             "positive definite";
    case SpindleCameraFailure::TooFewHoles:
      return fmt::format(
          "too few holes: {} or more are needed, more if axes or sides are to be "
          "separated",
          kLeastHoles);
    case SpindleCameraFailure::BacklashUnknown:
      return "all looks came from another side than the drill, and the backlash is not known: look "
             "from the drill's side as well";
    case SpindleCameraFailure::TooManyOutliers:
      return "more holes disagree than may be left out: look at the coupon and at the drill";
  }
  return "";
}

std::string SpindleCameraFit::summary() const {
  const Eigen::Vector2d& d_mm = offset.offset.in_mm();
  return fmt::format(
      "spindle-camera offset ({:.4f}, {:.4f}) mm, sigma ({:.2f}, {:.2f}) um, from {} and {}{}",
      d_mm.x(),
      d_mm.y(),
      sigma_um(*this, 0),
      sigma_um(*this, 1),
      amount(n_used, "hole"),
      amount(n_views, "look"),
      n_outliers() == 0 ? "" : fmt::format(", {} left out", n_outliers()));
}

std::string SpindleCameraFit::report() const {
  std::string lines = summary() + "\n" + scatter_lines(*this);
  lines += backlash_line(backlash[0], 'x') + backlash_line(backlash[1], 'y');
  lines += fmt::format("chi-square {:.1f} for {} degrees of freedom\n", chi_square, n_free);
  if (chance_as_expected) {
    lines += fmt::format("chance of so much scatter as machine.toml has it: {:.2g}\n",
                         *chance_as_expected);
  }
  lines += trend_line(
      over_coupon, "the coupon", "it moved between drilling and looking, and the offset with it");
  lines += trend_line(over_picture, "the picture", "the camera's calibration is turned or scaled");
  return lines + hole_lines(*this) + outlook_lines(*this);
}

}  // namespace panelcal
