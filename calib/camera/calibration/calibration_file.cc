// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/calibration/calibration_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "calib/base/fields/json.h"
#include "calib/base/fields/noted_head.h"
#include "calib/base/fields/slots.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/statistics/covariance_check.h"
#include "calib/json_files.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// What a file holds: of version 1 `camera` alone, of version 2 its head and `full`.
struct CameraFile {
  CameraCalibration camera;
  FullCamera full;
};

constexpr int kFull = 2;  ///< version with a tilt, k2, p1 and p2
/// Steps of the lattice of pixels on which a lens is looked at for folds, along each side. A lens
/// that is this smooth and folds between two of them folds at one of them too, or at the rim.
constexpr int kLatticeSteps = 32;

/// A form as the file has it: one word.
std::string word_of(CameraForm form) {
  std::string word(name(form));
  std::ranges::replace(word, ' ', '-');
  return word;
}

std::optional<CameraForm> camera_form(std::string_view word) {
  const auto form = std::ranges::find(kCameraForms, word, word_of);
  return form == kCameraForms.end() ? std::nullopt : std::optional(*form);
}

bool put_focal(CameraModel::Parameters& p, const FieldValue& value) {
  p.focal_px = value.is_off ? std::numeric_limits<double>::infinity() : value.number;
  return true;
}

bool get_focal(const CameraModel::Parameters& p, FieldValue& value) {
  value.number = p.focal_px;
  return !std::isinf(p.focal_px);
}

bool put_undetermined(CameraFile& file, const FieldValue& value) {
  std::vector<CameraParameter>& out = file.full.undetermined;
  for (const std::string& word : value.texts) {
    int i = 0;
    while (i < kCameraParameters && word != name(static_cast<CameraParameter>(i))) ++i;
    const auto parameter = static_cast<CameraParameter>(i);
    if (i == kCameraParameters || std::ranges::find(out, parameter) != out.end()) return false;
    out.push_back(parameter);
  }
  return true;
}

bool get_undetermined(const CameraFile& file, FieldValue& value) {
  for (const CameraParameter one : file.full.undetermined) value.texts.emplace_back(name(one));
  return true;
}

#include "calib/camera/calibration/calibration.def"

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

/// The first pixel of a lattice over the picture that the model does not see.
std::optional<Eigen::Vector2d> unseen_px(const CameraModel& model, int width_px, int height_px) {
  for (int row = 0; row <= kLatticeSteps; ++row) {
    for (int column = 0; column <= kLatticeSteps; ++column) {
      const Eigen::Vector2d u_px(width_px * static_cast<double>(column) / kLatticeSteps - 0.5,
                                 height_px * static_cast<double>(row) / kLatticeSteps - 0.5);
      if (!model.sees(position_px<frame::Image>(u_px))) return u_px;
    }
  }
  return std::nullopt;
}

/// Checks what the rows of the file cannot express.
Expected<void> check_camera_calibration(const CameraCalibration& c, const std::string& file) {
  const auto u_px =
      c.full ? unseen_px(c.model(), c.picture_width_px, c.picture_height_px) : std::nullopt;
  if (u_px) {
    return failure(
        invalid_camera_file(file,
                            fmt::format("the camera model folds over, or looks past the panel, at "
                                        "pixel ({:.1f}, {:.1f}) of the picture",
                                        u_px->x(),
                                        u_px->y()),
                            "a lens and a tilt that see the panel everywhere in the picture"));
  }
  const auto flaw = c.full ? covariance_flaw(c.full->covariance) : covariance_flaw(c.covariance);
  if (flaw) {
    return failure(invalid_camera_file(file, std::string(flaw->what), std::string(flaw->expected)));
  }
  return check_fold(c, file);
}

/// True if the file says that it is of version 2 or later; whatever else it says is judged as
/// version 1.
bool is_full(const nlohmann::json& document) {
  const auto version = document.is_object() ? document.find("version") : document.end();
  return version != document.end() && version->is_number() && version->get<double>() >= kFull;
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

}  // namespace

JsonFile camera_file() {
  return {"camera.cal.json",
          "The calibration of a camera: `panelcal calibrate camera` writes version 2, `[camera] "
          "calibration` of machine.toml names the file. A lens or a tilt that does not see the "
          "panel everywhere in the picture is refused.",
          {&kSimpleCamera, &kFullCamera},
          true};
}

}  // namespace panelcal::internal

namespace panelcal {

Expected<CameraCalibration> parse_camera_calibration(std::string_view text,
                                                     const std::string& file) {
  PANELCAL_TRY(const nlohmann::json document, internal::parse_calibration_json(text, file));
  const bool has_model = internal::is_full(document);
  PANELCAL_TRY(const internal::CameraFile read,
               internal::read_json(has_model ? internal::kFullCamera : internal::kSimpleCamera,
                                   document,
                                   Code::CalibrationInvalid,
                                   file));
  CameraCalibration c = read.camera;
  if (has_model) {
    c.full = read.full;
    internal::set_simple_part(c);
  }
  PANELCAL_CHECK(internal::check_camera_calibration(c, file));
  return c;
}

CameraCalibration calibration_of(const FullCamera& camera, int width_px, int height_px) {
  CameraCalibration c;
  c.full = camera;
  c.picture_width_px = width_px;
  c.picture_height_px = height_px;
  internal::set_simple_part(c);
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
  const internal::CameraFile file = {c, c.full.value_or(FullCamera())};
  return internal::json_text(
      c.full ? internal::kFullCamera : internal::kSimpleCamera, file, internal::JsonStyle::File);
}

Expected<void> write_camera_calibration(const std::filesystem::path& path,
                                        const CameraCalibration& calibration) {
  const std::string text = camera_calibration_text(calibration);
  PANELCAL_CHECK(parse_camera_calibration(text, path.string()));
  return write_file(path, text);
}

}  // namespace panelcal
