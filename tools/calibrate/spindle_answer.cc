// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/spindle_answer.h"

#include <cmath>
#include <string_view>

#include "calib/base/json/json_string.h"
#include "calib/base/statistics/linear_algebra.h"
#include <fmt/format.h>

namespace panelcal::calibrate {
namespace {

/// Nine digits: enough for a nanometre on a metre, and the same on every processor.
std::string spindle_number(double value) {
  return std::isfinite(value) ? fmt::format("{:.9g}", value) : "null";
}

std::string pair(double x, double y) {
  return fmt::format("[{},{}]", spindle_number(x), spindle_number(y));
}

std::string pair(const Eigen::Vector2d& v) {
  return pair(v.x(), v.y());
}

std::string scatter(const ScatterEstimate& estimate) {
  return pair(estimate.sigma[0].in_um(), estimate.sigma[1].in_um());
}

std::string backlash(const BacklashEstimate& estimate) {
  return estimate.is_determined ? spindle_number(estimate.value.in_um()) : "null";
}

std::string trend(const std::optional<ResidualTrend>& trend) {
  if (!trend) return "null";
  return fmt::format(
      "{{\"turn_mrad\":{},\"turn_sigma_mrad\":{},\"growth_ppm\":{},\"growth_sigma_ppm\":{},"
      "\"chance\":{},\"significant\":{}}}",
      spindle_number(1e3 * trend->rotation_rad),
      spindle_number(1e3 * trend->rotation_sigma_rad),
      spindle_number(trend->scale_ppm),
      spindle_number(trend->scale_sigma_ppm),
      spindle_number(trend->chance),
      trend->is_significant);
}

std::string coupon_holes_json(const SpindleCameraRun& run) {
  std::string out;
  for (std::size_t i = 0; i < run.fit.holes.size(); ++i) {
    const CouponHoleResidual& hole = run.fit.holes[i];
    out += fmt::format("{}{{\"drilled_mm\":{},\"residual_um\":{},\"left_out\":{}}}",
                       out.empty() ? "" : ",",
                       pair(run.sights.holes[i].drilled.in_mm()),
                       pair(1e3 * hole.residual.in_mm()),
                       hole.is_outlier);
  }
  return out;
}

std::string missed(const SpindleCameraRun& run) {
  std::string out;
  for (const MissedLook& look : run.sights.missed) {
    out += fmt::format("{}{{\"drilled_mm\":{},\"look\":{},\"reason\":",
                       out.empty() ? "" : ",",
                       pair(run.places[look.i_place].in_mm()),
                       look.i_look + 1);
    append_json_string(out, look.reason);
    out += "}";
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

std::string json(const SpindleAnswer& answer, const SpindleCameraRun& run) {
  const SpindleCameraFit& fit = run.fit;
  const Eigen::Matrix2d& cov = fit.offset.cov_mm2;
  std::string out = fmt::format(
      "{{\"kind\":\"spindle-camera\",\"spindle\":{},\"station\":{},\"offset_mm\":{},"
      "\"covariance_mm2\":[{},{}],\"holes\":{},\"looks\":{},\"left_out\":{},\"row\":{}",
      answer.spindle,
      answer.station,
      pair(fit.offset.offset.in_mm()),
      pair(cov(0, 0), cov(0, 1)),
      pair(cov(1, 0), cov(1, 1)),
      fit.n_used,
      fit.n_views,
      fit.n_outliers(),
      run.i_row + 1);
  out += fmt::format(",\"wander_um\":{},\"repeatability_um\":{},\"backlash_um\":[{},{}]",
                     scatter(fit.wander),
                     fit.is_separated ? scatter(fit.repeatability) : "null",
                     backlash(fit.backlash[0]),
                     backlash(fit.backlash[1]));
  out += fmt::format(",\"trend_over_coupon\":{},\"trend_over_picture\":{}",
                     trend(fit.over_coupon),
                     trend(fit.over_picture));
  out += fmt::format(",\"more_holes_to_halve\":{},\"more_looks_to_halve\":{}",
                     fit.more_holes_to_halve,
                     fit.more_views_to_halve ? std::to_string(*fit.more_views_to_halve) : "null");
  out += fmt::format(
      ",\"before_mm\":{},\"first\":{},\"shift_um\":{},\"shift_sigma_um\":{},"
      "\"shift_chance\":{}",
      pair(answer.before.offset.in_mm()),
      answer.is_first,
      pair(answer.shift_um),
      pair(answer.sigma_um),
      answer.chance ? spindle_number(*answer.chance) : "null");
  out += fmt::format(",\"residuals\":[{}],\"missed\":[{}],\"installed\":{},\"ledger\":{}",
                     coupon_holes_json(run),
                     missed(run),
                     answer.is_installed,
                     answer.ledger_id ? std::to_string(*answer.ledger_id) : "null");
  out += ",\"refusal\":";
  append_json_string(out, answer.refusal);
  return out + "}\n";
}

}  // namespace panelcal::calibrate
