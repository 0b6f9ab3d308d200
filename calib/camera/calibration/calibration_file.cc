// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/calibration/calibration_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "calib/base/append_format.h"
#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/json/noted_head.h"
#include "calib/base/json/strict_json.h"
#include "calib/base/statistics/covariance_check.h"
#include "calib/camera/calibration/model_file.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::StrictObject;

constexpr std::string_view kCameraKind = "camera";
constexpr int kSimple = 1;  ///< version without a tilt, k2, p1 and p2
constexpr int kFull = 2;
constexpr int kMaxPicture_px = 100000;

Diagnostic invalid_camera_file(const std::string& file, std::string what, std::string expected) {
  return {Code::CalibrationInvalid, {file, 0, 0}, std::move(what), std::move(expected)};
}

double farthest_corner_px2(const CameraCalibration& c) {
  double farthest = 0;
  for (const double x_px : {-0.5, c.picture_width_px - 0.5}) {
    for (const double y_px : {-0.5, c.picture_height_px - 0.5}) {
      const Eigen::Vector2d d_px = Eigen::Vector2d(x_px, y_px) - c.parameters.axis_px;
      farthest = std::max(farthest, d_px.squaredNorm());
    }
  }
  return farthest;
}

Expected<void> check_picture(const CameraCalibration& c, const std::string& file) {
  for (const int side_px : {c.picture_width_px, c.picture_height_px}) {
    if (side_px >= 1 && side_px <= kMaxPicture_px) continue;
    return failure(invalid_camera_file(file,
                                       fmt::format("a side of picture_px is {}", side_px),
                                       fmt::format("1 to {}", kMaxPicture_px)));
  }
  return {};
}

/// Of a full camera too: its simple part is what targets are searched with.
Expected<void> check_fold(const CameraCalibration& c, const std::string& file) {
  const CameraMapping::Parameters& p = c.parameters;
  const double slope = 1 + 3 * p.k1_per_px2 * farthest_corner_px2(c);
  if (!(slope > 0)) {
    return failure(
        invalid_camera_file(file,
                            fmt::format("k1_per_px2 is {}: the lens model folds over inside the "
                                        "picture (1 + 3 k1 r^2 is {:.3g} at a corner)",
                                        p.k1_per_px2,
                                        slope),
                            "1 + 3 k1 r^2 above 0 everywhere in the picture"));
  }
  return {};
}

/// Checks what the types of the file cannot express.
Expected<void> check_camera_calibration(const CameraCalibration& c, const std::string& file) {
  if (c.full) {
    PANELCAL_CHECK(check_picture(c, file));
    PANELCAL_CHECK(
        internal::check_full_camera(*c.full, c.picture_width_px, c.picture_height_px, file));
    return check_fold(c, file);
  }
  const CameraMapping::Parameters& p = c.parameters;
  if (!std::isfinite(p.scale_mm_per_px) || p.scale_mm_per_px <= 0) {
    return failure(invalid_camera_file(file,
                                       fmt::format("scale_mm_per_px is {}", p.scale_mm_per_px),
                                       "a number above 0 (directions are in rotation_rad)"));
  }
  if (!std::isfinite(p.rotation_rad) || !p.axis_px.allFinite() || !std::isfinite(p.k1_per_px2)) {
    return failure(invalid_camera_file(file, "a parameter is not finite", "finite numbers"));
  }
  PANELCAL_CHECK(check_picture(c, file));
  PANELCAL_CHECK(check_fold(c, file));
  if (const auto flaw = internal::covariance_flaw(c.covariance)) {
    return failure(invalid_camera_file(file, std::string(flaw->what), std::string(flaw->expected)));
  }
  return {};
}

Expected<void> check_camera_units(const StrictObject& top, const std::string& file) {
  constexpr std::array<std::string_view, 3> kKeys = {"length", "angle", "picture"};
  PANELCAL_TRY(
      const StrictObject units,
      StrictObject::make(top.member("units"), "units", kKeys, Code::CalibrationInvalid, file));
  PANELCAL_CHECK(units.constant("length", "mm"));
  PANELCAL_CHECK(units.constant("angle", "rad"));
  return units.constant("picture", "px");
}

Expected<CameraMapping::Parameters> read_mapping_parameters(const StrictObject& top,
                                                            const std::string& file) {
  constexpr std::array<std::string_view, 4> kKeys = {
      "scale_mm_per_px", "rotation_rad", "axis_px", "k1_per_px2"};
  PANELCAL_TRY(const StrictObject object,
               StrictObject::make(
                   top.member("parameters"), "parameters", kKeys, Code::CalibrationInvalid, file));
  CameraMapping::Parameters p;
  PANELCAL_TRY(p.scale_mm_per_px, object.number("scale_mm_per_px"));
  PANELCAL_TRY(p.rotation_rad, object.number("rotation_rad"));
  PANELCAL_TRY(p.k1_per_px2, object.number("k1_per_px2"));
  PANELCAL_TRY(const std::vector<double> axis_px, object.numbers("axis_px", 2));
  p.axis_px << axis_px[0], axis_px[1];
  return p;
}

Expected<std::chrono::sys_seconds> read_camera_date(const StrictObject& top,
                                                    const std::string& file) {
  PANELCAL_TRY(const std::string text, top.text("date"));
  if (const std::optional<std::chrono::sys_seconds> date = from_iso_8601(text)) return *date;
  return failure(invalid_camera_file(
      file, "\"date\" is " + quoted(text), "a time such as 2026-11-21T08:37:38Z"));
}

/// True if the file says that it is of version 2 or later; whatever else it says is judged as
/// version 1.
bool is_full(const nlohmann::json& document) {
  const auto version = document.is_object() ? document.find("version") : document.end();
  return version != document.end() && version->is_number() && version->get<double>() >= kFull;
}

Expected<void> read_picture_size(const StrictObject& top,
                                 const std::string& file,
                                 CameraCalibration& c) {
  PANELCAL_TRY(const std::vector<double> picture_px, top.numbers("picture_px", 2));
  for (const double side_px : picture_px) {
    if (side_px == std::floor(side_px) && std::abs(side_px) <= kMaxPicture_px) continue;
    return failure(invalid_camera_file(
        file, fmt::format("a side of picture_px is {}", side_px), "whole pixels"));
  }
  c.picture_width_px = static_cast<int>(picture_px[0]);
  c.picture_height_px = static_cast<int>(picture_px[1]);
  return {};
}

/// Sets the part of a full camera that has the simple form.
void set_simple_part(CameraCalibration& c) {
  const CameraModel::Parameters& p = c.full->parameters;
  c.parameters = {.scale_mm_per_px = p.scale_mm_per_px,
                  .rotation_rad = p.rotation_rad,
                  .axis_px = p.axis_px,
                  .k1_per_px2 = p.k1_per_px2};
  c.covariance = simple_covariance(c.full->covariance);
}

std::string head_text(const CameraCalibration& c, int version) {
  const std::string provenance =
      nlohmann::json(c.provenance).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  return fmt::format(R"({{
  "kind": "{}",
  "version": {},
  "date": "{}",
  "provenance": {},
  "units": {{"length": "mm", "angle": "rad", "picture": "px"}},
  "picture_px": [{}, {}],
)",
                     kCameraKind,
                     version,
                     iso_8601(c.date),
                     provenance,
                     c.picture_width_px,
                     c.picture_height_px);
}

}  // namespace

Expected<CameraCalibration> parse_camera_calibration(std::string_view text,
                                                     const std::string& file) {
  std::vector<std::string_view> keys = {
      "kind", "version", "date", "provenance", "units", "picture_px", "parameters", "covariance"};
  PANELCAL_TRY(const nlohmann::json document, internal::parse_calibration_json(text, file));
  const bool has_model = is_full(document);
  if (has_model)
    keys.insert(keys.end(), internal::model_keys().begin(), internal::model_keys().end());
  PANELCAL_TRY(
      const StrictObject top,
      StrictObject::make(document, "the calibration", keys, Code::CalibrationInvalid, file));
  PANELCAL_CHECK(top.constant("kind", kCameraKind));
  PANELCAL_CHECK(top.integer("version", kSimple, kFull));
  PANELCAL_CHECK(check_camera_units(top, file));

  CameraCalibration c;
  PANELCAL_TRY(c.date, read_camera_date(top, file));
  PANELCAL_TRY(c.provenance, top.text("provenance"));
  PANELCAL_CHECK(read_picture_size(top, file, c));
  if (has_model) {
    PANELCAL_TRY(c.full, internal::read_full_camera(top, file));
    set_simple_part(c);
    PANELCAL_CHECK(check_camera_calibration(c, file));
    return c;
  }
  PANELCAL_TRY(c.parameters, read_mapping_parameters(top, file));
  PANELCAL_TRY(const std::vector<double> covariance, top.matrix("covariance", 5, 5));
  c.covariance = Eigen::Map<const Eigen::Matrix<double, 5, 5, Eigen::RowMajor>>(covariance.data());
  PANELCAL_CHECK(check_camera_calibration(c, file));
  return c;
}

CameraCalibration calibration_of(const FullCamera& camera, int width_px, int height_px) {
  CameraCalibration c;
  c.full = camera;
  c.picture_width_px = width_px;
  c.picture_height_px = height_px;
  set_simple_part(c);
  return c;
}

FullCamera full_camera(const CameraFit& fit, const std::optional<double>& zoom) {
  return {.form = fit.form,
          .parameters = fit.parameters,
          .covariance = fit.covariance,
          .undetermined = fit.undetermined,
          .zoom = zoom,
          .rms_px = fit.rms_px,
          .held_out_rms_px = fit.held_out_rms_px};
}

Expected<CameraCalibration> read_camera_calibration(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxCalibrationBytes));
  return parse_camera_calibration(text, path.string());
}

std::string camera_calibration_text(const CameraCalibration& c) {
  if (c.full) return head_text(c, kFull) + internal::full_camera_text(*c.full) + "}\n";
  const CameraMapping::Parameters& p = c.parameters;
  std::string text = head_text(c, kSimple) + fmt::format(R"(  "parameters": {{
    "scale_mm_per_px": {},
    "rotation_rad": {},
    "axis_px": [{}, {}],
    "k1_per_px2": {}
  }},
  "covariance": [
)",
                                                         p.scale_mm_per_px,
                                                         p.rotation_rad,
                                                         p.axis_px.x(),
                                                         p.axis_px.y(),
                                                         p.k1_per_px2);
  for (int i = 0; i < 5; ++i) {
    const Eigen::Matrix<double, 1, 5> row = c.covariance.row(i);
    text += fmt::format("    [{}]{}\n", internal::joined({row.data(), 5}, ", "), i < 4 ? "," : "");
  }
  return text + "  ]\n}\n";
}

Expected<void> write_camera_calibration(const std::filesystem::path& path,
                                        const CameraCalibration& calibration) {
  PANELCAL_CHECK(check_camera_calibration(calibration, path.string()));
  return write_file(path, camera_calibration_text(calibration));
}

}  // namespace panelcal
