// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "calib/camera/calibration/calibration_file.h"
#include "machine/calibrate/camera/run.h"
#include "machine/calibrate/kinds/kinds.h"
#include "machine/calibrate/kinds/parts.h"
#include "machine/devices/cameras/camera_settings.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Value in which drift is watched: the place at which the picture's farthest corner is seen, in mm
/// from the axis. A scale and an angle by themselves have no common unit, and no limit that a hole
/// cares for.
///
///   radius = r scale,   turn = r scale rotation,   r = half of the picture's diagonal, px
LedgerValues picture_corner(double radius_px,
                            double scale_mm_per_px,
                            double rotation_rad,
                            const Eigen::Matrix2d& cov) {
  Eigen::Matrix2d by_parameters;
  by_parameters << radius_px, 0, radius_px * rotation_rad, radius_px * scale_mm_per_px;
  const Eigen::Vector2d value(radius_px * scale_mm_per_px,
                              radius_px * scale_mm_per_px * rotation_rad);
  return {value, by_parameters * cov * by_parameters.transpose()};
}

/// Of the picture; 0 of a camera that is not calibrated yet.
double half_diagonal_px(const CameraCalibration* camera) {
  return camera == nullptr ? 0
                           : 0.5 * std::hypot(camera->picture_width_px, camera->picture_height_px);
}

/// The camera as it stands, or at a zoom level.
class CameraKind final : public Calibration {
 public:
  CameraKind(std::shared_ptr<MachineConfig> config,
             const NightlyConfig& nightly,
             const std::optional<double>& zoom)
      : config_(std::move(config)),
        zoom_(zoom),
        mark_(nightly.mark.value_or(Position<frame::Machine>())),
        tool_(nightly.mark_tool),
        limits_(nightly.limits),
        radius_px_(half_diagonal_px(camera_at(*config_, zoom_))) {}

  LedgerKey key() const override { return camera_key(*config_, zoom_); }
  std::vector<std::string> axes() const override { return {"corner radius", "corner turn"}; }
  std::filesystem::path file() const override {
    return zoom_ ? config_->zoom_files.at(*zoom_) : config_->camera_file;
  }
  std::optional<Eigen::VectorXd> present() const override {
    const CameraModel::Parameters parameters = camera().model().parameters();
    return picture_corner(radius_px_,
                          parameters.scale_mm_per_px,
                          parameters.rotation_rad,
                          Eigen::Matrix2d::Zero())
        .value;
  }
  int n_qualities() const override { return 1; }
  std::optional<LedgerValues> value_of(const LedgerEntry& entry) const override;
  Expected<CalibrationResult> measure(const CalibrationDevices& devices,
                                      const RecordWords& words) override;
  Expected<std::chrono::sys_seconds> date_of(const std::string& bytes,
                                             const std::string& name) const override {
    return internal::date_by(parse_camera_calibration, bytes, name);
  }

 protected:
  std::string_view thing() const override { return "a camera"; }
  Expected<void> begin_there(const Ledger& ledger) override;

 private:
  const CameraCalibration& camera() const { return *camera_at(*config_, zoom_); }
  std::vector<NightGate> gates_of(const CameraRun& run) const;

  std::shared_ptr<MachineConfig> config_;
  std::optional<double> zoom_;
  Position<frame::Machine> mark_;
  int tool_;
  NightLimits limits_;
  double radius_px_;  ///< the same all night, so that a new picture size changes no scale
};

std::optional<LedgerValues> CameraKind::value_of(const LedgerEntry& entry) const {
  constexpr std::array<std::string_view, 2> kNames = {"scale", "rotation"};
  const auto found = values_of(entry.record, kNames);
  if (!found) return std::nullopt;
  return picture_corner(radius_px_, found->value[0], found->value[1], found->cov);
}

/// By how much the two see the farthest corner elsewhere, tilt and lens included.
double corners_moved_mm(const CameraCalibration& before, const CameraCalibration& now) {
  const CameraModel old_model = before.model();
  const CameraModel new_model = now.model();
  double farthest_mm = 0;
  for (const double x_px : {0.0, now.picture_width_px - 1.0}) {
    for (const double y_px : {0.0, now.picture_height_px - 1.0}) {
      const auto corner = position_px<frame::Image>(Eigen::Vector2d(x_px, y_px));
      const double moved_mm = (new_model(corner).in_mm() - old_model(corner).in_mm()).norm();
      // One that is no number has to fail.
      if (!(moved_mm <= farthest_mm)) farthest_mm = moved_mm;
    }
  }
  return farthest_mm;
}

/// What would make the corners surer: quieter views where a single one is off by more than the
/// limit, else views that come nearer to the corners.
std::string_view advice_for_corners(const CameraRun& run, double sigma_mm, double limit_mm) {
  if (sigma_mm <= limit_mm) return "";
  if (run.fit.rms_px * run.fit.parameters.scale_mm_per_px > limit_mm) {
    return "; the views scatter by more than that: see what moves stage, mark or camera";
  }
  return "; a mark that is smaller in the picture shows more of them";
}

/// Of the whole camera; its axes are scale and rotation only.
std::vector<NightGate> CameraKind::gates_of(const CameraRun& run) const {
  const double sigma_mm = um(run.corner_sigma_um).in_mm();
  std::vector<NightGate> gates = {
      internal::limit_gate(
          "corners", sigma_mm, limits_.sigma, "sigma at the picture's corners is {}, limit {}"),
      internal::reason_gate("views", refusal(run), "the views fit the camera"),
      internal::limit_gate("change",
                           corners_moved_mm(camera(), run.calibration),
                           limits_.change,
                           "a corner of the picture is {} from where the camera in force has it, "
                           "limit {}")};
  gates.front().text += advice_for_corners(run, sigma_mm, limits_.sigma);
  return gates;
}

Expected<CalibrationResult> CameraKind::measure(const CalibrationDevices& devices,
                                                const RecordWords& words) {
  CameraRunOptions options;
  options.views.tool = tool_;
  options.views.zoom = zoom_;
  Expected<CameraRun> made = calibrate_camera(*config_, devices, mark_, options);
  // Whatever came of it: the next calibration, and the first job, see as they did before.
  if (zoom_) {
    PANELCAL_CHECK(set_camera(*config_, devices, CameraSetting::Zoom, *usual_zoom(*config_)));
  }
  if (!made) return failure(std::move(made).error());
  const CameraRun run = *std::move(made);
  CalibrationResult out;
  PANELCAL_TRY(out.draft, camera_draft(*config_, run, words));
  const auto& parameters = run.fit.parameters;
  const LedgerValues found = picture_corner(radius_px_,
                                            parameters.scale_mm_per_px,
                                            parameters.rotation_rad,
                                            run.fit.covariance.topLeftCorner<2, 2>());
  out.result.point.value = found.value;
  out.result.point.cov = found.cov;
  const std::size_t n_seen = run.fit.residuals.size();
  out.result.used = "views";
  out.result.n_used = static_cast<int>(n_seen);
  out.result.n_outliers = static_cast<int>(run.sights.missed.size());
  const double degrees = run.fit.degrees_of_freedom;
  out.spreads = internal::fit_spread(
      {"views about the camera's fit", "px", 0, degrees}, run.fit.rms_px, n_seen);
  out.result.further = gates_of(run);
  out.report = internal::lines_of(report(run));
  return out;
}

Expected<void> CameraKind::begin_there(const Ledger& ledger) {
  PANELCAL_TRY(const std::optional<std::string> text, text_in_force(ledger));
  if (!text) return {};
  PANELCAL_TRY(CameraCalibration camera, parse_camera_calibration(*text, file().string()));
  if (zoom_) {
    config_->zooms[*zoom_] = std::move(camera);
  } else {
    config_->camera = std::move(camera);
  }
  return {};
}

}  // namespace

std::unique_ptr<Calibration> camera_kind(std::shared_ptr<MachineConfig> config,
                                         const NightlyConfig& nightly,
                                         const std::optional<double>& zoom) {
  return std::make_unique<CameraKind>(std::move(config), nightly, zoom);
}

namespace internal {

Expected<Calibrations> camera_calibrations(LedgerKind /*kind*/,
                                           const std::shared_ptr<MachineConfig>& config,
                                           const NightlyConfig& nightly) {
  const Missing missing = {nightly, "[nightly] calibrates the camera, and "};
  if (!config->camera) return missing("[camera] is missing", "[camera] calibration");
  if (!nightly.mark) return missing("there is no mark to see", "mark_mm = [x, y]");
  if (!config->vision_tools.contains(nightly.mark_tool)) {
    return missing("the mark's vision tool is not defined", "a [[vision.tool]]");
  }
  Calibrations all = only_calibration(camera_kind(config, nightly, std::nullopt));
  const std::optional<double> usual = usual_zoom(*config);
  for (const auto& [level, file] : config->zoom_files) {
    if (level == usual) continue;
    if (!usual) {
      return missing("the zoom to go back to is missing",
                     "a [[camera.zoom]] that names the file of [camera] calibration as well");
    }
    all.push_back(camera_kind(config, nightly, level));
  }
  return all;
}

}  // namespace internal

}  // namespace panelcal
