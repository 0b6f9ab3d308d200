// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/camera/run.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "calib/base/statistics/linear_algebra.h"
#include "machine/calibrate/camera/outliers.h"
#include "machine/calibrate/camera/scatter.h"
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal {
namespace {

/// A mark in so few places says nothing of a camera.
constexpr std::size_t kFewestViews = 5;
/// A limit of refusal(): a quarter of a pixel where the detector says a hundredth.
constexpr double kMaxCameraExcess = 25;
/// The same, of what the calibration errs where no view was used: more than a stage wanders.
constexpr double kMaxCameraHeldOut_um = 5;
/// The same: one in this number of observations left out is one too many.
constexpr int kMaxCameraLeftOut = 4;

tl::unexpected<Diagnostic> camera_refused(const MachineConfig& config,
                                          std::string what,
                                          std::string expected) {
  return failure(
      {Code::CalibrationData, {config.file.string(), 0, 0}, std::move(what), std::move(expected)});
}

/// Tells where: a fit knows of no file.
Diagnostic in_config(const MachineConfig& config, Diagnostic diagnostic) {
  if (diagnostic.place.file.empty()) diagnostic.place.file = config.file.string();
  return diagnostic;
}

CameraFitOptions fit_options_of(const MachineConfig& config,
                                const MarkSights& sights,
                                const CameraRunOptions& options) {
  CameraFitOptions fit;
  if (options.focal_px) fit.focal_px = *options.focal_px;
  const CameraCalibration* const present = camera_at(config, options.views.zoom);
  const Eigen::Vector2d middle_px(0.5 * (sights.width_px - 1), 0.5 * (sights.height_px - 1));
  fit.axis_px = middle_px;
  if (present == nullptr) return fit;
  // The axis is a convention that the spindle-camera offset goes with: another one would move every
  // hole by what they differ.
  const bool is_same_picture = present->picture_width_px == sights.width_px &&
                               present->picture_height_px == sights.height_px;
  if (is_same_picture) fit.axis_px = present->parameters.axis_px;
  if (!options.focal_px) fit.focal_px = present->model().parameters().focal_px;
  fit.scale_mm_per_px = present->parameters.scale_mm_per_px;
  fit.rotation_rad = present->parameters.rotation_rad;
  return fit;
}

/// The form that was asked for, or the softest that the views determine.
Expected<CameraFit> fit_form(const CameraData& data,
                             CameraFitOptions options,
                             const std::optional<CameraForm>& asked) {
  if (!asked) return choose_camera(data, options);
  options.form = *asked;
  return fit_camera(data, options);
}

/// What observations tell, px^-2.
double information(const CameraData& data) {
  double sum = 0;
  for (const CameraObservation& seen : data.seen) sum += seen.seen.cov.inverse().trace();
  return sum;
}

/// Enlarges the covariances by the scatter that the form that is fitted leaves. A variance that nu
/// degrees of freedom estimate is as good as one that is nu / (nu - 2) times as large and known.
Expected<void> count_scatter(CameraFitOptions options,
                             const std::optional<CameraForm>& asked,
                             CameraRun& run) {
  options.held_out_every = 0;
  const auto fitter = [&](const CameraData& data) { return fit_form(data, options, asked); };
  CameraData& data = run.sights.data;
  PANELCAL_TRY(internal::ScatteredFit scattered,
               internal::fit_scattered(data, fitter, [](int nu) { return nu - 2.0; }));
  const CameraFit& stated = scattered.stated;
  if (stated.degrees_of_freedom < kFewestCameraFreedoms) return {};
  run.excess = std::sqrt(std::max(1.0, stated.chi_square / stated.degrees_of_freedom));
  run.sigma_factor = std::sqrt(information(data) / information(scattered.data));
  data = std::move(scattered.data);
  return {};
}

/// A mark without a size in mm has one as soon as there is a scale.
void give_radius(const MachineConfig& config,
                 const MarkViews& views,
                 double scale_mm,
                 CameraData& data) {
  const auto tool = config.vision_tools.find(views.tool);
  if (tool == config.vision_tools.end() || !tool->second.size_px) return;
  for (PlateDot& dot : data.dots) {
    if (dot.radius > Length()) continue;
    dot.radius = mm(0.5 * tool->second.size_px->in_px() * scale_mm);
  }
}

Expected<void> check_count(const MachineConfig& config, const MarkSights& sights) {
  const std::size_t n_seen = sights.data.seen.size();
  if (n_seen >= kFewestViews) return {};
  const std::string why = sights.missed.empty() ? "" : ": " + sights.missed.front().reason;
  return camera_refused(
      config,
      fmt::format("{} of {} pictures show the mark{}", n_seen, n_seen + sights.missed.size(), why),
      fmt::format("{} or more", kFewestViews));
}

/// A result that could not be read again is no calibration.
Expected<void> check_readable(const MachineConfig& config, const CameraRun& run) {
  auto read =
      parse_camera_calibration(camera_calibration_text(run.calibration), config.file.string());
  if (read) return {};
  Diagnostic flaw = std::move(read).error();
  // Of a soft form as a rule, whose lens nothing holds where no view is.
  flaw.expected += fmt::format(
      ": views nearer the corners (a smaller mark), or a stiffer form than {}", name(run.fit.form));
  return failure(std::move(flaw));
}

double corner_sigma_um(const CameraCalibration& camera) {
  const CameraModel model = camera.model();
  double worst_mm2 = 0;
  for (const double x_px : {0.0, camera.picture_width_px - 1.0}) {
    for (const double y_px : {0.0, camera.picture_height_px - 1.0}) {
      const CameraModelJacobian j =
          model.by_parameters(position_px<frame::Image>(Eigen::Vector2d(x_px, y_px)));
      const Eigen::Matrix2d cov = j * camera.full->covariance * j.transpose();
      worst_mm2 = std::max(worst_mm2, internal::plane_eigenvalues(cov).maxCoeff());
    }
  }
  return std::sqrt(worst_mm2) * 1e3;
}

/// Parameters in the order of the covariance.
Eigen::Matrix<double, kCameraParameters, 1> values_of(const CameraModel::Parameters& p) {
  Eigen::Matrix<double, kCameraParameters, 1> v;
  v << p.scale_mm_per_px, p.rotation_rad, p.tilt.x(), p.tilt.y(), p.k1_per_px2, p.k2_per_px4,
      p.p1_per_px, p.p2_per_px;
  return v;
}

std::string underscored(std::string_view name) {
  std::string out(name);
  std::ranges::replace(out, ' ', '_');
  return out;
}

bool is_held(const CameraFit& fit, CameraParameter parameter) {
  const auto free = free_parameters(fit.form);
  return std::ranges::find(free, parameter) == free.end() ||
         std::ranges::find(fit.undetermined, parameter) != fit.undetermined.end();
}

/// True of the two that moves of the stage show, and no place can be told without.
bool is_from_stage(CameraParameter parameter) {
  return parameter == CameraParameter::Scale || parameter == CameraParameter::Rotation;
}

std::string camera_provenance(const CameraRun& run) {
  const MarkSights& sights = run.sights;
  const std::size_t n_dots = sights.data.dots.size();
  std::string text =
      fmt::format("{} of {} looks at {}",
                  sights.data.seen.size(),
                  sights.data.seen.size() + sights.missed.size(),
                  n_dots == 1 ? "one mark" : fmt::format("a plate of {} dots", n_dots));
  if (run.sigma_factor > 1) {
    text += fmt::format(", sigmas times {:.3g} by their scatter", run.sigma_factor);
  }
  return text;
}

/// The run's calibration with date and provenance.
CameraCalibration camera_calibration(const CameraRun& run, const RecordWords& words) {
  CameraCalibration calibration = run.calibration;
  calibration.date = words.date;
  calibration.provenance = camera_provenance(run);
  calibration.provenance += by_whom(words);
  return calibration;
}

}  // namespace

Expected<CameraRun> fit_camera_run(const MachineConfig& config,
                                   MarkSights sights,
                                   const CameraRunOptions& options) {
  PANELCAL_CHECK(check_count(config, sights));
  CameraRun run;
  run.sights = std::move(sights);
  CameraData& data = run.sights.data;
  CameraFitOptions fit_options = fit_options_of(config, run.sights, options);
  CameraFitOptions first_options = fit_options;
  first_options.huber_sigmas = internal::kHuberSigmas;
  auto first = fit_camera(data, first_options);
  if (!first) return failure(in_config(config, std::move(first).error()));
  give_radius(config, options.views, first->parameters.scale_mm_per_px, data);
  const auto n_left_out = internal::leave_out_outliers(fit_options, run.sights);
  if (!n_left_out) return failure(in_config(config, n_left_out.error()));
  run.n_left_out = *n_left_out;
  PANELCAL_CHECK(check_count(config, run.sights));
  auto counted = count_scatter(fit_options, options.form, run);
  if (!counted) return failure(in_config(config, std::move(counted).error()));
  auto fit = fit_form(data, fit_options, options.form);
  if (!fit) return failure(in_config(config, std::move(fit).error()));
  run.fit = *std::move(fit);
  run.calibration = calibration_of(
      full_camera(run.fit, options.views.zoom), run.sights.width_px, run.sights.height_px);
  PANELCAL_CHECK(check_readable(config, run));
  run.corner_sigma_um = corner_sigma_um(run.calibration);
  const CameraCalibration* const present = camera_at(config, options.views.zoom);
  if (present == nullptr) {
    std::ranges::copy_if(run.fit.undetermined, std::back_inserter(run.guessed), is_from_stage);
  }
  run.loses_tilt =
      present != nullptr && !present->model().parameters().tilt.isZero(0) &&
      (is_held(run.fit, CameraParameter::TiltX) || is_held(run.fit, CameraParameter::TiltY));
  return run;
}

Expected<CameraRun> calibrate_camera(const MachineConfig& config,
                                     const CalibrationDevices& devices,
                                     const Position<frame::Machine>& place,
                                     const CameraRunOptions& options) {
  PANELCAL_TRY(MarkSights sights, look_at_mark(config, devices, place, options.views));
  return fit_camera_run(config, std::move(sights), options);
}

Expected<CameraRun> calibrate_camera(const MachineConfig& config,
                                     const PictureFolder& folder,
                                     const CameraRunOptions& options) {
  PANELCAL_TRY(MarkSights sights, look_at_folder(config, folder, options.views));
  return fit_camera_run(config, std::move(sights), options);
}

std::string refusal(const CameraRun& run) {
  const auto n_left_out = static_cast<std::size_t>(run.n_left_out);
  const std::size_t n_all = run.sights.data.seen.size() + n_left_out;
  if (n_left_out * kMaxCameraLeftOut > n_all) {
    return fmt::format("{} of {} looks do not fit the others, more than one in {}",
                       n_left_out,
                       n_all,
                       kMaxCameraLeftOut);
  }
  if (!run.guessed.empty()) {
    std::string names;
    for (const CameraParameter parameter : run.guessed) {
      names += (names.empty() ? "" : " and the ") + std::string(name(parameter));
    }
    return fmt::format(
        "these views do not determine the {}, and no camera in force has it: several views of each "
        "pose at known places of the stage do",
        names);
  }
  if (run.loses_tilt) {
    return "the camera in force is tilted, and these views do not determine how much: without its "
           "focal "
           "length they cannot";
  }
  if (run.fit.held_out_rms_px) {
    const double held_out_um = 1e3 * *run.fit.held_out_rms_px * run.fit.parameters.scale_mm_per_px;
    if (!(held_out_um <= kMaxCameraHeldOut_um)) {
      return fmt::format(
          "looks that the fit did not see are {:.1f} um beside it, the limit is {} um",
          held_out_um,
          kMaxCameraHeldOut_um);
    }
  }
  if (run.excess <= kMaxCameraExcess) return {};
  return fmt::format(
      "looks scatter {:.1f} times more than the detector and [uncertainty] "
      "stage_repeatability_um state, the limit is {} times",
      run.excess,
      kMaxCameraExcess);
}

std::string report(const CameraRun& run) {
  std::string text = run.fit.summary() + "\n";
  const auto values = values_of(run.fit.parameters);
  for (int i = 0; i < kCameraParameters; ++i) {
    const auto parameter = static_cast<CameraParameter>(i);
    if (is_held(run.fit, parameter)) continue;
    text += fmt::format("  {:<9} {:>14.7g} +- {:.2g} {}\n",
                        name(parameter),
                        values[i],
                        std::sqrt(run.fit.covariance(i, i)),
                        unit(parameter));
  }
  for (const CameraParameter parameter : run.fit.undetermined) {
    text += fmt::format("  {:<9} undetermined by these views, held\n", name(parameter));
  }
  text += fmt::format("  sigma at the picture's corners: {:.2f} um\n", run.corner_sigma_um);
  text += fmt::format("  chi square {:.1f} of {} degrees of freedom",
                      run.fit.chi_square,
                      run.fit.degrees_of_freedom);
  if (run.fit.sufficient != run.fit.form) {
    text += fmt::format("; a {} camera would do", name(run.fit.sufficient));
  }
  if (run.fit.wants_views_for) {
    text += fmt::format("; too few views for a {} camera", name(*run.fit.wants_views_for));
  }
  if (run.excess > 1) {
    text += fmt::format("; views scatter {:.2f} times more than stated", run.excess);
  }
  if (run.sigma_factor > 1) {
    text += fmt::format("; sigmas grow {:.2f} times by the views' scatter and number",
                        run.sigma_factor);
  }
  text += "\n";
  text += pictures_report(run.sights.left_out, run.sights.without_tag);
  for (const MissedPicture& missed : run.sights.missed) {
    text += fmt::format("  without {}: {}\n", missed.picture, missed.reason);
  }
  return text;
}

LedgerKey camera_key(const MachineConfig& config, const std::optional<double>& zoom) {
  return {
      machine_name(config), LedgerKind::Camera, zoom ? fmt::format("zoom {}", *zoom) : "camera"};
}

Expected<LedgerDraft> camera_draft(const MachineConfig& config,
                                   const CameraRun& run,
                                   const RecordWords& words) {
  PANELCAL_TRY(LedgerDraft draft,
               draft_of(config, camera_key(config, run.calibration.full->zoom), words));
  LedgerRecord& record = draft.record;
  record.inputs.insert(record.inputs.end(), run.sights.inputs.begin(), run.sights.inputs.end());
  const auto values = values_of(run.fit.parameters);
  for (int i = 0; i < kCameraParameters; ++i) {
    const auto parameter = static_cast<CameraParameter>(i);
    record.parameters.push_back(
        {underscored(name(parameter)), values[i], std::string(unit(parameter))});
  }
  record.covariance = run.fit.covariance;
  draft.result = camera_calibration_text(camera_calibration(run, words));
  return draft;
}

}  // namespace panelcal
