// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/calibration/model_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "calib/base/append_format.h"
#include "calib/base/statistics/covariance_check.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Steps of the lattice of pixels on which a lens is looked at for folds, along each side. A lens
/// that is this smooth and folds between two of them folds at one of them too, or at the rim.
constexpr int kLatticeSteps = 32;

Diagnostic invalid_camera_model(const std::string& file, std::string what, std::string expected) {
  return {Code::CalibrationInvalid, {file, 0, 0}, std::move(what), std::move(expected)};
}

/// A number, or null for "there is none".
Expected<std::optional<double>> optional_number(const StrictObject& object, std::string_view key) {
  if (object.member(key).is_null()) return std::nullopt;
  PANELCAL_TRY(const double value, object.number(key));
  return std::optional(value);
}

std::string number_or_null(const std::optional<double>& number) {
  return number ? fmt::format("{}", *number) : "null";
}

/// A form as the file has it: one word.
std::string word_of(CameraForm form) {
  std::string word(name(form));
  std::ranges::replace(word, ' ', '-');
  return word;
}

Expected<CameraForm> read_form(const StrictObject& top, const std::string& file) {
  PANELCAL_TRY(const std::string word, top.text("form"));
  std::string all;
  for (const CameraForm form : kCameraForms) {
    if (word == word_of(form)) return form;
    all += (all.empty() ? "" : ", ") + word_of(form);
  }
  return failure(invalid_camera_model(file, "\"form\" is " + quoted(word), "one of " + all));
}

Expected<CameraModel::Parameters> read_model_parameters(const StrictObject& top,
                                                        const std::string& file) {
  constexpr std::array<std::string_view, 9> kKeys = {"scale_mm_per_px",
                                                     "rotation_rad",
                                                     "axis_px",
                                                     "tilt",
                                                     "k1_per_px2",
                                                     "k2_per_px4",
                                                     "p1_per_px",
                                                     "p2_per_px",
                                                     "focal_px"};
  PANELCAL_TRY(const StrictObject object,
               StrictObject::make(
                   top.member("parameters"), "parameters", kKeys, Code::CalibrationInvalid, file));
  CameraModel::Parameters p;
  PANELCAL_TRY(p.scale_mm_per_px, object.number("scale_mm_per_px"));
  PANELCAL_TRY(p.rotation_rad, object.number("rotation_rad"));
  PANELCAL_TRY(p.k1_per_px2, object.number("k1_per_px2"));
  PANELCAL_TRY(p.k2_per_px4, object.number("k2_per_px4"));
  PANELCAL_TRY(p.p1_per_px, object.number("p1_per_px"));
  PANELCAL_TRY(p.p2_per_px, object.number("p2_per_px"));
  PANELCAL_TRY(const std::vector<double> axis_px, object.numbers("axis_px", 2));
  p.axis_px << axis_px[0], axis_px[1];
  PANELCAL_TRY(const std::vector<double> tilt, object.numbers("tilt", 2));
  p.tilt << tilt[0], tilt[1];
  PANELCAL_TRY(const auto focal_px, optional_number(object, "focal_px"));
  p.focal_px = focal_px.value_or(std::numeric_limits<double>::infinity());
  return p;
}

Expected<std::vector<CameraParameter>> read_undetermined_parameters(const StrictObject& top,
                                                                    const std::string& file) {
  const nlohmann::json& list = top.member("undetermined");
  std::vector<CameraParameter> out;
  if (!list.is_array())
    return failure(invalid_camera_model(file, "\"undetermined\" is no array", "[...]"));
  for (const nlohmann::json& element : list) {
    const auto* word = element.get_ptr<const std::string*>();
    bool is_known = false;
    for (int i = 0; word != nullptr && i < kCameraParameters; ++i) {
      const auto parameter = static_cast<CameraParameter>(i);
      if (*word != name(parameter) || std::ranges::find(out, parameter) != out.end()) continue;
      out.push_back(parameter);
      is_known = true;
    }
    if (is_known) continue;
    return failure(invalid_camera_model(
        file,
        "\"undetermined\" names something that is no camera parameter, or twice",
        "scale, rotation, tilt x, tilt y, k1, k2, p1, p2, each once at most"));
  }
  return out;
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

bool is_share(const std::optional<double>& number) {
  return !number || (std::isfinite(*number) && *number >= 0);
}

}  // namespace

std::span<const std::string_view> model_keys() {
  static constexpr std::array<std::string_view, 5> kKeys = {
      "form", "undetermined", "zoom", "rms_px", "held_out_rms_px"};
  return kKeys;
}

Expected<FullCamera> read_full_camera(const StrictObject& top, const std::string& file) {
  FullCamera camera;
  PANELCAL_TRY(camera.form, read_form(top, file));
  PANELCAL_TRY(camera.parameters, read_model_parameters(top, file));
  constexpr std::size_t kN = kCameraParameters;
  PANELCAL_TRY(const std::vector<double> covariance, top.matrix("covariance", kN, kN));
  camera.covariance = Eigen::Map<
      const Eigen::Matrix<double, kCameraParameters, kCameraParameters, Eigen::RowMajor>>(
      covariance.data());
  PANELCAL_TRY(camera.undetermined, read_undetermined_parameters(top, file));
  PANELCAL_TRY(camera.zoom, optional_number(top, "zoom"));
  PANELCAL_TRY(camera.rms_px, top.number("rms_px"));
  PANELCAL_TRY(camera.held_out_rms_px, optional_number(top, "held_out_rms_px"));
  return camera;
}

std::string full_camera_text(const FullCamera& camera) {
  const CameraModel::Parameters& p = camera.parameters;
  std::string text = fmt::format(R"(  "form": "{}",
  "parameters": {{
    "scale_mm_per_px": {},
    "rotation_rad": {},
    "axis_px": [{}, {}],
    "tilt": [{}, {}],
    "k1_per_px2": {},
    "k2_per_px4": {},
    "p1_per_px": {},
    "p2_per_px": {},
    "focal_px": {}
  }},
  "covariance": [
)",
                                 word_of(camera.form),
                                 p.scale_mm_per_px,
                                 p.rotation_rad,
                                 p.axis_px.x(),
                                 p.axis_px.y(),
                                 p.tilt.x(),
                                 p.tilt.y(),
                                 p.k1_per_px2,
                                 p.k2_per_px4,
                                 p.p1_per_px,
                                 p.p2_per_px,
                                 std::isinf(p.focal_px) ? "null" : fmt::format("{}", p.focal_px));
  for (int i = 0; i < kCameraParameters; ++i) {
    const Eigen::Matrix<double, 1, kCameraParameters> row = camera.covariance.row(i);
    text += fmt::format("    [{}]{}\n",
                        internal::joined({row.data(), kCameraParameters}, ", "),
                        i + 1 < kCameraParameters ? "," : "");
  }
  std::string undetermined;
  for (const CameraParameter parameter : camera.undetermined) {
    undetermined += fmt::format("{}\"{}\"", undetermined.empty() ? "" : ", ", name(parameter));
  }
  return text + fmt::format(R"(  ],
  "undetermined": [{}],
  "zoom": {},
  "rms_px": {},
  "held_out_rms_px": {}
)",
                            undetermined,
                            number_or_null(camera.zoom),
                            camera.rms_px,
                            number_or_null(camera.held_out_rms_px));
}

Expected<void> check_full_camera(const FullCamera& camera,
                                 int width_px,
                                 int height_px,
                                 const std::string& file) {
  if (!CameraModel::is_valid(camera.parameters)) {
    return failure(
        invalid_camera_model(file,
                             "a parameter is not finite, or the scale or focal length not above 0",
                             "finite numbers, positive lengths; focal_px null if telecentric"));
  }
  if (const auto u_px = unseen_px(CameraModel(camera.parameters), width_px, height_px)) {
    return failure(
        invalid_camera_model(file,
                             fmt::format("the camera model folds over, or looks past the panel, at "
                                         "pixel ({:.1f}, {:.1f}) of the picture",
                                         u_px->x(),
                                         u_px->y()),
                             "a lens and a tilt that see the panel everywhere in the picture"));
  }
  if (camera.zoom && !std::isfinite(*camera.zoom)) {
    return failure(invalid_camera_model(file, "\"zoom\" is not finite", "a zoom level, or null"));
  }
  if (!is_share(camera.rms_px) || !is_share(camera.held_out_rms_px)) {
    return failure(invalid_camera_model(
        file, "rms_px or held_out_rms_px is negative or not finite", "px, 0 or more"));
  }
  if (const auto flaw = covariance_flaw(camera.covariance)) {
    return failure(
        invalid_camera_model(file, std::string(flaw->what), std::string(flaw->expected)));
  }
  return {};
}

}  // namespace panelcal::internal
