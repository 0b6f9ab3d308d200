// SPDX-License-Identifier: Apache-2.0
#include <numbers>
#include <string>
#include <string_view>
#include <utility>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "calib/camera/exchange/lens_camera.h"
#include "tools/calibrate/session.h"
#include "tools/cli/commands.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/process/version.h"
#include <fmt/format.h>

namespace panelcal::calibrate {
namespace {

constexpr std::string_view kCameraImport = "panelcal calibrate camera-import";
constexpr double kRadiansPerDegree = std::numbers::pi / 180;

std::string exchange_line(std::string_view what, const std::string& text) {
  return fmt::format("{:<11}{}\n", what, text);
}

Expected<LensMount> mount_of(const CalibrateOptions& options, const Lens& lens) {
  LensMount mount;
  mount.scale_mm_per_px =
      options.scale_mm_per_px ? *options.scale_mm_per_px : *options.distance_mm / lens.focal_px.x();
  mount.rotation_rad = options.rotation_deg * kRadiansPerDegree;
  mount.corner_sigma = um(*options.corner_sigma_um);
  mount.max_error_px = options.max_lens_error_px;
  return mount;
}

Expected<std::chrono::sys_seconds> date_of(const CalibrateOptions& options) {
  if (options.clock.empty()) return system_clock()();
  const auto date = from_iso_8601(options.clock);
  if (date) return *date;
  return failure(usage(
      "--clock " + quoted(options.clock), "a time such as 2026-11-21T02:00:00Z", kCameraImport));
}

Diagnostic named(Diagnostic problem, const std::string& file) {
  if (problem.place.file.empty()) problem.place.file = file;
  return problem;
}

std::string import_text(const CalibrateOptions& options,
                        const Lens& lens,
                        const LensCamera& camera) {
  const CameraModel::Parameters& p = camera.calibration.full->parameters;
  return exchange_line(
             "read",
             fmt::format("{}: format {}, {} x {} px, fx {:g}, fy {:g}, center ({:g}, {:g}) px",
                         options.exchange_file,
                         name_of(lens.format),
                         lens.width_px,
                         lens.height_px,
                         lens.focal_px.x(),
                         lens.focal_px.y(),
                         lens.center_px.x(),
                         lens.center_px.y())) +
         exchange_line("lens",
                       fmt::format("k1 {:g}, k2 {:g}, p1 {:g}, p2 {:g}, k3 {:g}; followed within "
                                   "{:.2g} px in the picture",
                                   lens.k1,
                                   lens.k2,
                                   lens.p1,
                                   lens.p2,
                                   lens.k3,
                                   camera.error_px)) +
         exchange_line("mount",
                       fmt::format("{:g} mm/px, turned by {:g} deg, as stated; sigma of {:g} um at "
                                   "the farthest corner, assumed",
                                   p.scale_mm_per_px,
                                   options.rotation_deg,
                                   *options.corner_sigma_um)) +
         exchange_line("written", options.output);
}

}  // namespace

Expected<Answer> camera_import(const CalibrateOptions& options, CommandContext&) {
  PANELCAL_CHECK(check_extension(std::string(kCameraImport), options.output, ".json"));
  PANELCAL_TRY(const auto date, date_of(options));
  PANELCAL_TRY(const std::string text, read_file(options.exchange_file, kMaxLensBytes));
  PANELCAL_TRY(const Lens lens, parse_lens(text, options.exchange_file));
  PANELCAL_TRY(const LensMount mount, mount_of(options, lens));
  auto camera = camera_of_lens(lens, mount);
  if (!camera) return failure(named(std::move(camera).error(), options.exchange_file));
  CameraCalibration& calibration = camera->calibration;
  calibration.date = date;
  calibration.provenance =
      fmt::format("camera model of {} ({}); scale and rotation stated, sigma assumed",
                  options.exchange_file,
                  name_of(lens.format));
  PANELCAL_CHECK(write_camera_calibration(options.output, calibration));
  return Answer{import_text(options, lens, *camera)};
}

Expected<Answer> camera_export(const CalibrateOptions& options, CommandContext& context) {
  PANELCAL_TRY(const CameraCalibration calibration, read_camera_calibration(options.exchange_file));
  auto found = lens_of_camera(calibration, options.focal_px, options.max_lens_error_px);
  if (!found) return failure(named(std::move(found).error(), options.exchange_file));
  Lens& lens = found->lens;
  lens.format = options.exchange_format == "ros"     ? LensFormat::RosCameraInfo
                : options.exchange_format == "mrcal" ? LensFormat::MrcalCameraModel
                                                     : LensFormat::OpenCvYaml;
  const CameraModel::Parameters p = calibration.model().parameters();
  const std::string mount = fmt::format("{:g} mm/px, turned by {:g} deg: no lens model has these",
                                        p.scale_mm_per_px,
                                        p.rotation_rad / kRadiansPerDegree);
  const std::string text = lens_text(
      lens,
      fmt::format(
          "made by: panelcal {} from {}; {}", kVersion, quoted(options.exchange_file, 200), mount));
  std::string said = exchange_line("lens",
                                   fmt::format("{}, followed within {:.2g} px in the picture",
                                               name_of(lens.format),
                                               found->error_px)) +
                     exchange_line("mount", mount);
  if (options.output == "-") {
    context.console.say(said);
    return Answer{text};
  }
  PANELCAL_CHECK(write_file(options.output, text));
  return Answer{said + exchange_line("written", options.output)};
}

}  // namespace panelcal::calibrate
