// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/spindle_answer.h"

#include <cmath>
#include <string_view>

#include "calib/base/json/json_string.h"
#include "calib/base/statistics/linear_algebra.h"
#include <fmt/format.h>

namespace panelcal::calibrate {
namespace {

using facts::Json;
using facts::number;
using facts::point;

Json scatter(const ScatterEstimate& estimate) {
  return {number(estimate.sigma[0].in_um()), number(estimate.sigma[1].in_um())};
}

Json backlash(const BacklashEstimate& estimate) {
  return estimate.is_determined ? number(estimate.value.in_um()) : Json();
}

Json trend(const std::optional<ResidualTrend>& trend) {
  if (!trend) return {};
  return {{"turn_mrad", number(1e3 * trend->rotation_rad)},
          {"turn_sigma_mrad", number(1e3 * trend->rotation_sigma_rad)},
          {"growth_ppm", number(trend->scale_ppm)},
          {"growth_sigma_ppm", number(trend->scale_sigma_ppm)},
          {"chance", number(trend->chance)},
          {"significant", trend->is_significant}};
}

Json coupon_holes_json(const SpindleCameraRun& run) {
  Json out = Json::array();
  for (std::size_t i = 0; i < run.fit.holes.size(); ++i) {
    out.push_back({{"drilled_mm", point(run.sights.holes[i].drilled.in_mm())},
                   {"residual_um", point(1e3 * run.fit.holes[i].residual.in_mm())},
                   {"left_out", run.fit.holes[i].is_outlier}});
  }
  return out;
}

Json missed(const SpindleCameraRun& run) {
  Json out = Json::array();
  for (const MissedLook& look : run.sights.missed) {
    out.push_back({{"drilled_mm", point(run.places[look.i_place].in_mm())},
                   {"look", look.i_look + 1},
                   {"reason", look.reason}});
  }
  return out;
}

std::string comparison_line(const SpindleAnswer& answer) {
  const Eigen::Vector2d& before_mm = answer.before.offset.in_mm();
  if (answer.is_first) {
    return fmt::format(
        "begun from ({:.4f}, {:.4f}) mm, which was no calibration; off by ({:+.2f}, "
        "{:+.2f}) um\n",
        before_mm.x(),
        before_mm.y(),
        answer.shift_um.x(),
        answer.shift_um.y());
  }
  return fmt::format(
      "it was ({:.4f}, {:.4f}) mm; moved by ({:+.2f}, {:+.2f}) um, ({:.1f}, {:.1f}) sigmas, chance "
      "{:.2g} if nothing moved\n",
      before_mm.x(),
      before_mm.y(),
      answer.shift_um.x(),
      answer.shift_um.y(),
      std::abs(answer.shift_um.x()) / answer.sigma_um.x(),
      std::abs(answer.shift_um.y()) / answer.sigma_um.y(),
      answer.chance.value_or(1));
}

}  // namespace

SpindleAnswer compare(const MachineConfig& config, const SpindleCameraRun& run) {
  SpindleAnswer answer;
  answer.spindle = config.spindle_setting.spindle;
  answer.station = config.spindle_setting.station;
  answer.is_first = !config.spindle_setting.is_calibrated;
  answer.before = config.spindle_camera;
  answer.shift_um = 1e3 * (run.fit.offset.offset - config.spindle_camera.offset).in_mm();
  const Eigen::Matrix2d cov_um2 = 1e6 * (run.fit.offset.cov_mm2 + config.spindle_camera.cov_mm2 +
                                         config.walk.uncertainty.drift_mm2);
  answer.sigma_um = cov_um2.diagonal().cwiseSqrt();
  if (answer.is_first) return answer;
  const double distance2 =
      answer.shift_um.dot(internal::solve_plane_symmetric(cov_um2, answer.shift_um));
  if (std::isfinite(distance2)) answer.chance = std::exp(-0.5 * distance2);
  return answer;
}

std::string trend_words(const SpindleCameraFit& fit) {
  if (fit.over_coupon && fit.over_coupon->is_significant) {
    return fmt::format(
        "the residuals show a trend over the coupon (chance {:.2g}): it moved "
        "between drilling and looking",
        fit.over_coupon->chance);
  }
  if (fit.over_picture && fit.over_picture->is_significant) {
    return fmt::format(
        "the residuals show a trend over the picture (chance {:.2g}): the camera's "
        "calibration is turned or scaled",
        fit.over_picture->chance);
  }
  return {};
}

std::string text(const SpindleAnswer& answer, const SpindleCameraRun& run) {
  std::string out = fmt::format("spindle {} station {}: ", answer.spindle, answer.station);
  out += report_text(run) + comparison_line(answer);
  if (answer.is_installed) {
    return out + fmt::format("installed: ledger entry {}\n", *answer.ledger_id);
  }
  if (answer.refusal.empty()) return out + "nothing was installed\n";
  return out +
         fmt::format("not installed (ledger entry {}): {}; --force installs it all the same\n",
                     *answer.ledger_id,
                     answer.refusal);
}

Json spindle_facts(const SpindleAnswer& answer, const SpindleCameraRun& run) {
  const SpindleCameraFit& fit = run.fit;
  return {
      {"spindle", answer.spindle},
      {"station", answer.station},
      {"holes", fit.n_used},
      {"looks", fit.n_views},
      {"left_out", fit.n_outliers()},
      {"row", run.i_row + 1},
      {"wander_um", scatter(fit.wander)},
      {"repeatability_um", fit.is_separated ? scatter(fit.repeatability) : Json()},
      {"backlash_um", {backlash(fit.backlash[0]), backlash(fit.backlash[1])}},
      {"trend_over_coupon", trend(fit.over_coupon)},
      {"trend_over_picture", trend(fit.over_picture)},
      {"more_holes_to_halve", fit.more_holes_to_halve},
      {"more_looks_to_halve", fit.more_views_to_halve ? Json(*fit.more_views_to_halve) : Json()},
      {"before_mm", point(answer.before.offset.in_mm())},
      {"first", answer.is_first},
      {"shift_um", point(answer.shift_um)},
      {"shift_sigma_um", point(answer.sigma_um)},
      {"shift_chance", number(answer.chance)},
      {"gates", answer.gates},
      {"residuals", coupon_holes_json(run)},
      {"missed", missed(run)}};
}

}  // namespace panelcal::calibrate
