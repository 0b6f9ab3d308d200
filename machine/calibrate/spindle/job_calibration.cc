// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/spindle/job_calibration.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/drift/night_gates.h"
#include "machine/calibrate/spindle/coupon.h"
#include "machine/look/picture_locator.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

std::string offset_text(const SpindleCameraOffset& offset) {
  return fmt::format("({:.4f}, {:.4f}) mm, sigma ({:.2f}, {:.2f}) um",
                     offset.offset.in_mm().x(),
                     offset.offset.in_mm().y(),
                     std::sqrt(offset.cov_mm2(0, 0)) * 1e3,
                     std::sqrt(offset.cov_mm2(1, 1)) * 1e3);
}

std::string shift_text(const Displacement<frame::Machine>& shift) {
  const Eigen::Vector2d shift_um = shift.in_mm() * 1e3;
  return fmt::format("({:+.1f}, {:+.1f}) um", shift_um.x(), shift_um.y());
}

Diagnostic of_order(Diagnostic problem, const CalibrationOrder& order) {
  problem.what += ", for " + describe(order);
  return problem;
}

/// A job that calibrates is as unattended as a night.
NightLimits limits_of(const MachineConfig& config) {
  return config.nightly ? config.nightly->limits : NightLimits{};
}

double largest_sigma_mm(const Eigen::Matrix2d& cov_mm2) {
  return std::sqrt(std::max(0.0, internal::plane_eigenvalues(cov_mm2).maxCoeff()));
}

std::string zoom_text(const std::optional<double>& zoom) {
  return zoom ? fmt::format("zoom {}", *zoom) : "no zoom";
}

Expected<void> check_structure(const SpindleCameraFit& fit,
                               const Coupon& coupon,
                               double least_chance,
                               const CalibrationOrder& order) {
  if (!fit.over_coupon || fit.over_coupon->chance >= least_chance) return {};
  return failure({Code::CalibrationRefused,
                  coupon.place,
                  fmt::format("coupon {} turned by {:+.3f} mrad and grew by {:+.0f} ppm between "
                              "drilling and looking (chance {:.1e}, limit {}), for {}",
                              quoted(coupon.name),
                              fit.over_coupon->rotation_rad * 1e3,
                              fit.over_coupon->scale_ppm,
                              fit.over_coupon->chance,
                              least_chance,
                              describe(order)),
                  "a coupon that is held fast"});
}

}  // namespace

JobCalibration::JobCalibration(const MachineConfig& config)
    : config_(config),
      at_{config.spindle_setting.spindle, config.spindle_setting.station},
      offsets_(config.spindle_setting.calibration.offsets) {
  offsets_.set(at_, config.spindle_camera);
  measured_with_ = offsets_;
}

Expected<MachineConfig> JobCalibration::config_at(const CalibrationOrder& order) const {
  MachineConfig config = config_;
  if (!order.zoom) return config;
  const auto zoomed = config_.zooms.find(*order.zoom);
  if (zoomed == config_.zooms.end()) {
    return failure(
        {Code::ConfigValue,
         {config_.file.string(), 0, 0},
         fmt::format(
             "{} is at zoom {}, for which no camera is calibrated", describe(order), *order.zoom),
         fmt::format("[[camera.zoom]] with level = {}", *order.zoom)});
  }
  config.camera = zoomed->second;
  return config;
}

/// The measurements behind it have no other check on the offset.
Expected<void> JobCalibration::check(const SpindleCameraOffset& offset,
                                     const Displacement<frame::Machine>& shift,
                                     const CalibrationOrder& order) const {
  const NightLimits limits = limits_of(config_);
  const auto refused = [&](std::string what, std::string expected) {
    return failure(of_order({Code::CalibrationRefused,
                             {config_.file.string(), 0, 0},
                             std::move(what),
                             std::move(expected)},
                            order));
  };
  const double shift_mm = shift.in_mm().norm();
  if (!(shift_mm <= limits.change)) {
    return refused(
        fmt::format("the spindle-camera offset would move by {} = {:.1f} um, limit {:.1f} um",
                    shift_text(shift),
                    shift_mm * 1e3,
                    limits.change * 1e3),
        "an unmoved machine, or an attended calibration: panelcal calibrate spindle-camera; "
        "[nightly.gates] change_um is the limit");
  }
  const double sigma_mm = largest_sigma_mm(offset.cov_mm2);
  if (sigma_mm <= limits.sigma) return {};
  return refused(fmt::format("sigma of the spindle-camera offset is {:.2f} um, limit {:.2f} um",
                             sigma_mm * 1e3,
                             limits.sigma * 1e3),
                 "more holes; [nightly.gates] sigma_um is the limit");
}

Expected<CalibrationAnswer> JobCalibration::calibrate(const CalibrationOrder& order,
                                                      const CalibrationDevices& devices) {
  PANELCAL_TRY(const MachineConfig config, config_at(order));
  auto run = order.first_hole && config.coupon
                 ? calibrate_spindle_camera_at(
                       config, devices, places_from(*config.coupon, *order.first_hole))
                 : calibrate_spindle_camera(config, devices);
  if (!run) return failure(of_order(std::move(run).error(), order));
  const SpindleCameraFit& fit = run->fit;
  const Displacement<frame::Machine> shift = fit.offset.offset - config_.spindle_camera.offset;
  PANELCAL_CHECK(check_structure(fit, *config.coupon, limits_of(config_).structure_chance, order));
  PANELCAL_CHECK(check(fit.offset, shift, order));
  CalibrationAnswer answer;
  answer.order = order;
  answer.offset = fit.offset;
  answer.text = fmt::format(
      "spindle-camera offset {} from {} holes in {} looks, {} of holes left "
      "out; it moved by {}",
      offset_text(fit.offset),
      fit.n_used,
      fit.n_views,
      fit.n_outliers(),
      shift_text(shift));
  config_.spindle_camera = fit.offset;
  offsets_.set(at_, fit.offset);
  by_camera_ = fit.by_camera;
  calibrated_by_ = order;
  is_measured_with_ = false;
  return answer;
}

Expected<std::optional<CalibrationAnswer>> JobCalibration::correct(const CalibrationOrder& order) {
  const OffsetCorrection& correction = *order.correction;
  SpindleOffsets corrected = measured_with_;
  const int n_moved = corrected.correct(correction.order, correction.deviation, correction.cov_mm2);
  if (n_moved == 0) return std::nullopt;
  PANELCAL_CHECK(check({{}, correction.cov_mm2}, correction.deviation, order));
  CalibrationAnswer answer;
  answer.order = order;
  for (const auto& [at, offset] : corrected.all()) {
    const SpindleCameraOffset* const before = measured_with_.find(at);
    const bool is_moved = before->offset != offset.offset || before->cov_mm2 != offset.cov_mm2;
    if (!is_moved) continue;
    offsets_.set(at, offset);
    if (at == at_) answer.offset = offset;
  }
  answer.text = fmt::format("{} spindle-camera offset(s) corrected by ({:+.1f}, {:+.1f}) um",
                            n_moved,
                            -correction.deviation.in_mm().x() * 1e3,
                            -correction.deviation.in_mm().y() * 1e3);
  if (!answer.offset) {
    answer.text += fmt::format(
        "; not that of spindle {} at station {}, which drills", at_.spindle, at_.station);
    return answer;
  }
  answer.text += "; that of the spindle that drills is " + offset_text(*answer.offset);
  config_.spindle_camera = *answer.offset;
  by_camera_ = measured_by_camera_ - correction.by_camera;
  calibrated_by_.reset();  // the language has no zoom
  is_measured_with_ = false;
  return answer;
}

Expected<Measurement> JobCalibration::complete(Measurement measurement) {
  const MachineUncertainty& machine = config_.walk.uncertainty;
  const MeasurementRequest& request = measurement.request;
  if (calibrated_by_ &&
      machine.camera_index(request.settings.zoom) != machine.camera_index(calibrated_by_->zoom)) {
    return failure({Code::CommandMisplaced,
                    {request.file, request.line, 0},
                    fmt::format("{} is seen at {}, with an offset that {} found at {}",
                                describe(request),
                                zoom_text(request.settings.zoom),
                                describe(*calibrated_by_),
                                zoom_text(calibrated_by_->zoom)),
                    "one zoom for both, or a calibration at each zoom before its targets"});
  }
  if (!std::exchange(is_measured_with_, true)) {
    measured_with_ = offsets_;
    measured_by_camera_ = by_camera_;
  }
  if (measurement.status == MeasurementStatus::Found && measurement.by_camera) {
    *measurement.by_camera += by_camera_;
  }
  return measurement;
}

}  // namespace panelcal
