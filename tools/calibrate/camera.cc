// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "machine/calibrate/camera/run.h"
#include "machine/calibrate/kinds/kinds.h"
#include "machine/devices/table_stage.h"
#include "machine/plate/pictures.h"
#include "tools/calibrate/devices.h"
#include "tools/calibrate/session.h"
#include "tools/figures/arrow_plot.h"
#include "vision/picture/files/folder.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace panelcal::calibrate {
namespace {

constexpr std::string_view kCalibrateCamera = "panelcal calibrate camera";

Diagnostic camera_usage(std::string what, std::string expected) {
  return usage(std::move(what), std::move(expected), kCalibrateCamera);
}

/// As --form and calibration files have it.
std::string word_of(CameraForm form) {
  std::string word(name(form));
  std::ranges::replace(word, ' ', '-');
  return word;
}

/// A form by its word on the command line; absent for "auto".
Expected<std::optional<CameraForm>> form_of(const std::string& word) {
  if (word.empty() || word == "auto") return std::nullopt;
  for (const CameraForm form : kCameraForms) {
    if (word == word_of(form)) return form;
  }
  return failure(camera_usage("--form " + quoted(word),
                              "auto, flat, radial, tilted, tilted-radial or tangential"));
}

Expected<CameraRunOptions> run_options(const CalibrateOptions& options) {
  CameraRunOptions run;
  PANELCAL_TRY(run.form, form_of(options.form));
  run.views.tool = options.tool;
  run.views.zoom = options.zoom;
  run.views.per_side = options.per_side;
  if (!options.focal_px) return run;
  run.focal_px = options.focal_px;
  if (*run.focal_px > 0 && std::isfinite(*run.focal_px)) return run;
  return failure(camera_usage(fmt::format("--focal-px {}", *run.focal_px), "a number above 0"));
}

/// Drives a mark over the picture.
Expected<CameraRun> drive(const CalibrateOptions& options,
                          const MachineConfig& config,
                          const CameraRunOptions& run_options,
                          Console& console) {
  PANELCAL_TRY(PlaceDevices at, PlaceDevices::open(options, config));
  console.progress("looking at the mark");
  return calibrate_camera(config, at.devices(), at.place(), run_options);
}

/// From recorded pictures of one mark, or of a plate.
Expected<CameraRun> look(const CalibrateOptions& options,
                         const MachineConfig& config,
                         const CameraRunOptions& run_options) {
  if (options.plate.empty()) {
    PANELCAL_TRY(const PictureFolder folder, read_picture_folder(options.images));
    return calibrate_camera(config, folder, run_options);
  }
  PANELCAL_TRY(const CalibrationPlate plate, read_plate(options.plate));
  PANELCAL_TRY(const auto folders, read_plate_folders(options.images, plate));
  PANELCAL_TRY(MarkSights sights, look_at_plate(config, plate, folders, options.zoom));
  PANELCAL_CHECK(correct_views(config, sights));
  PANELCAL_TRY(LedgerInput input, input_of(options.plate, kMaxPlateBytes));
  sights.inputs.push_back(std::move(input));
  return fit_camera_run(config, std::move(sights), run_options);
}

std::string camera_svg(const CameraRun& run) {
  ArrowPlot plot;
  plot.title = run.fit.summary();
  plot.place_unit = plot.arrow_unit = "px";
  plot.high = Eigen::Vector2d(run.sights.width_px, run.sights.height_px);
  plot.y_is_down = true;
  for (std::size_t i = 0; i < run.sights.data.seen.size(); ++i) {
    plot.arrows.push_back(
        {run.sights.data.seen[i].seen.position.in_px(), run.fit.residuals[i].in_px()});
  }
  return arrow_svg(plot);
}

nlohmann::ordered_json camera_json(const CameraRun& run,
                                   const std::string& calibration,
                                   const Session& session) {
  nlohmann::ordered_json json;
  json["calibration"] = nlohmann::ordered_json::parse(calibration);
  json["views"] = run.sights.data.seen.size();
  json["missed"] = nlohmann::ordered_json::array();
  for (const MissedPicture& missed : run.sights.missed) {
    json["missed"].push_back({{"picture", missed.picture}, {"reason", missed.reason}});
  }
  json["left_out"] = run.n_left_out;
  json["pictures_left_out"] = nlohmann::ordered_json::array();
  for (const MissedPicture& picture : run.sights.left_out) {
    json["pictures_left_out"].push_back({{"picture", picture.picture}, {"reason", picture.reason}});
  }
  json["pictures_without_tag"] = run.sights.without_tag;
  json["skipped"] = run.sights.n_skipped;
  json["chi_square"] = run.fit.chi_square;
  json["degrees_of_freedom"] = run.fit.degrees_of_freedom;
  json["rms_px"] = run.fit.rms_px;
  if (run.fit.held_out_rms_px) json["held_out_rms_px"] = *run.fit.held_out_rms_px;
  json["excess"] = run.excess;
  json["sigma_factor"] = run.sigma_factor;
  json["sufficient_form"] = word_of(run.fit.sufficient);
  json["corner_sigma_um"] = run.corner_sigma_um;
  session.put_verdict(json);
  json["residuals_px"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < run.fit.residuals.size(); ++i) {
    const Eigen::Vector2d& at_px = run.sights.data.seen[i].seen.position.in_px();
    const Eigen::Vector2d& residual_px = run.fit.residuals[i].in_px();
    json["residuals_px"].push_back({{"view", run.sights.names[run.sights.data.seen[i].i_view]},
                                    {"at", {at_px.x(), at_px.y()}},
                                    {"residual", {residual_px.x(), residual_px.y()}}});
  }
  return json;
}

}  // namespace

Expected<Answer> camera(const CalibrateOptions& options, CommandContext& context) {
  PANELCAL_TRY(const CameraRunOptions run_options, calibrate::run_options(options));
  PANELCAL_TRY(Session session, Session::begin(options));
  const MachineConfig& config = *session.config();
  PANELCAL_CHECK(session.check_install("camera", config.camera_file));
  if (options.install && options.zoom) {
    return failure(camera_usage("--install and --zoom together",
                                "--output: what [camera] names is the camera without a zoom"));
  }
  const bool drives = options.images.empty();
  PANELCAL_CHECK(session.lock(drives));
  PANELCAL_CHECK(session.open_ledger());
  PANELCAL_TRY(const CameraRun run,
               drives ? drive(options, config, run_options, context.console)
                      : look(options, config, run_options));
  if (!options.plot.empty()) PANELCAL_CHECK(write_file(options.plot, camera_svg(run)));
  PANELCAL_TRY(const LedgerDraft draft, camera_draft(config, run, session.words()));
  PANELCAL_CHECK(
      session.finish(draft, *camera_kind(session.config(), {}, options.zoom), refusal(run)));
  if (options.json) return session.answer(camera_json(run, draft.result, session));
  return session.answer(report(run) + session.verdict_line());
}

}  // namespace panelcal::calibrate
