// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "machine/calibrate/camera/run.h"
#include "machine/calibrate/kinds/kinds.h"
#include "machine/devices/table_stage.h"
#include "machine/plate/pictures.h"
#include "tools/calibrate/devices.h"
#include "tools/calibrate/session.h"
#include "vision/picture/files/folder.h"
#include <fmt/format.h>

namespace panelcal::calibrate {
namespace {

using facts::Json;
using facts::number;

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
  PANELCAL_TRY(PlaceDevices at, PlaceDevices::open(options, config, console));
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

Json pictures_facts(const std::vector<MissedPicture>& pictures) {
  Json out = Json::array();
  for (const MissedPicture& one : pictures) {
    out.push_back({{"picture", one.picture}, {"reason", one.reason}});
  }
  return out;
}

Json camera_facts(const CameraRun& run, const std::string& calibration) {
  const MarkSights& sights = run.sights;
  const CameraFit& fit = run.fit;
  Json out = {{"form", word_of(fit.form)},
              {"sufficient_form", word_of(fit.sufficient)},
              {"chi_square", number(fit.chi_square)},
              {"degrees_of_freedom", fit.degrees_of_freedom},
              {"rms_px", number(fit.rms_px)},
              {"held_out_rms_px", number(fit.held_out_rms_px)},
              {"excess", number(run.excess)},
              {"sigma_factor", number(run.sigma_factor)},
              {"corner_sigma_um", number(run.corner_sigma_um)},
              {"left_out", run.n_left_out},
              {"skipped", sights.n_skipped},
              {"missed", pictures_facts(sights.missed)},
              {"pictures_left_out", pictures_facts(sights.left_out)},
              {"pictures_without_tag", sights.without_tag},
              {"picture_px", {sights.width_px, sights.height_px}}};
  Json& residuals = out["residuals"] = Json::array();
  for (std::size_t i = 0; i < fit.residuals.size(); ++i) {
    const CameraObservation& seen = sights.data.seen[i];
    residuals.push_back({{"view", sights.names[seen.i_view]},
                         {"at_px", facts::point(seen.seen.position.in_px())},
                         {"residual_px", facts::point(fit.residuals[i].in_px())}});
  }
  out["calibration"] = Json::parse(calibration);
  return out;
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
  PANELCAL_TRY(const LedgerDraft draft, camera_draft(config, run, session.words()));
  PANELCAL_CHECK(
      session.finish(draft, *camera_kind(session.config(), {}, options.zoom), refusal(run)));
  return session.answer(
      report(run) + session.verdict_line(), camera_facts(run, draft.result), context);
}

}  // namespace panelcal::calibrate
