// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/exchange/lens.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "calib/camera/exchange/lens_fields.h"
#include <fmt/format.h>

namespace panelcal {
namespace internal {
namespace {

constexpr int kMaxPicture_px = 100'000;
constexpr double kLargestCoefficient = 1e9;

/// A model by its name, and the number of its coefficients, k1 k2 p1 p2 k3 ahead of others.
struct LensModelRow {
  std::string_view name;
  std::size_t n_coefficients;
};
constexpr std::array<LensModelRow, 5> kMrcalModels = {{{"LENSMODEL_PINHOLE", 0},
                                                       {"LENSMODEL_OPENCV4", 4},
                                                       {"LENSMODEL_OPENCV5", 5},
                                                       {"LENSMODEL_OPENCV8", 8},
                                                       {"LENSMODEL_OPENCV12", 12}}};
/// Coefficients that OpenCV writes: none, plumb bob, rational, thin prism, tilted sensor.
constexpr std::array<std::size_t, 6> kOpenCvCounts = {0, 4, 5, 8, 12, 14};

/// Names of coefficients behind k3 that Lens does not have.
constexpr std::array<std::string_view, 9> kFurther = {
    "k4", "k5", "k6", "s1", "s2", "s3", "s4", "tau x", "tau y"};

Diagnostic bad_lens(const Place& place, std::string what, std::string expected) {
  return {Code::MeasurementFile, place, std::move(what), std::move(expected)};
}

Expected<double> lens_number(const LensField& field, std::size_t i) {
  const std::string& text = field.texts[i];
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  double value = 0;
  const auto [stop, error] = std::from_chars(begin, text.data() + text.size(), value);
  const bool is_number = error == std::errc() && stop == text.data() + text.size() &&
                         std::abs(value) <= kLargestCoefficient;
  if (is_number) return value;
  return failure(bad_lens(field.place, quoted(text), "a number"));
}

/// The fields of one file by any of their names.
class LensKeys {
 public:
  LensKeys(LensFields fields, const std::string& file) : fields_(std::move(fields)), file_(file) {}

  const LensField* find(std::span<const std::string_view> names) const {
    for (const std::string_view name : names) {
      const auto found = fields_.find(name);
      if (found != fields_.end()) return &found->second;
    }
    return nullptr;
  }
  const LensField* find(std::string_view name) const { return find(std::span(&name, 1)); }

  Expected<const LensField*> require(std::span<const std::string_view> names) const {
    const LensField* const field = find(names);
    if (field != nullptr) return field;
    return failure(bad_lens({file_, 0, 0},
                            fmt::format("a camera model without {}", names.front()),
                            std::string(names.front())));
  }

  Expected<int> pixels(std::span<const std::string_view> names) const {
    PANELCAL_TRY(const LensField* const field, require(names));
    int value = 0;
    const std::string& text = field->texts.empty() ? file_ : field->texts.front();
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool is_size = !field->is_list && error == std::errc() &&
                         stop == text.data() + text.size() && value >= 1 && value <= kMaxPicture_px;
    if (is_size) return value;
    return failure(bad_lens(field->place, quoted(text), fmt::format("1 to {} px", kMaxPicture_px)));
  }

  Expected<std::vector<double>> numbers(const LensField& field) const {
    std::vector<double> out;
    for (std::size_t i = 0; i < field.texts.size(); ++i) {
      PANELCAL_TRY(out.emplace_back(), lens_number(field, i));
    }
    return out;
  }

 private:
  LensFields fields_;
  const std::string& file_;
};

/// Sets k1 k2 p1 p2 k3; what stands behind them must be 0.
Expected<void> set_coefficients(const Place& place, std::span<const double> values, Lens& lens) {
  const std::array<double*, 5> of = {&lens.k1, &lens.k2, &lens.p1, &lens.p2, &lens.k3};
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i < of.size()) {
      *of[i] = values[i];
    } else if (values[i] != 0) {
      return failure(
          bad_lens(place,
                   fmt::format("a lens with {} = {}", kFurther[i - of.size()], values[i]),
                   "Brown's k1, k2, p1, p2, k3 alone, the others 0"));
    }
  }
  return {};
}

Expected<Lens> checked_lens(Lens lens, const Place& place) {
  const bool is_good =
      lens.focal_px.minCoeff() > 0 && lens.focal_px.allFinite() && lens.center_px.allFinite();
  if (is_good) return lens;
  return failure(bad_lens(place,
                          fmt::format("fx, fy are {}, {}", lens.focal_px.x(), lens.focal_px.y()),
                          "focal lengths above 0"));
}

Expected<Lens> yaml_lens(std::string_view text, const std::string& file) {
  PANELCAL_TRY(LensFields fields, read_yaml_fields(text, file));
  const LensKeys keys(std::move(fields), file);
  constexpr std::array<std::string_view, 4> kWidth = {
      "image_width", "width", "image_Width", "imageWidth"};
  constexpr std::array<std::string_view, 4> kHeight = {
      "image_height", "height", "image_Height", "imageHeight"};
  constexpr std::array<std::string_view, 6> kMatrix = {"camera_matrix.data",
                                                       "K",
                                                       "k",
                                                       "Camera_Matrix.data",
                                                       "cameraMatrix.data",
                                                       "intrinsic_matrix.data"};
  constexpr std::array<std::string_view, 6> kLens = {"distortion_coefficients.data",
                                                     "D",
                                                     "d",
                                                     "Distortion_Coefficients.data",
                                                     "distCoeffs.data",
                                                     "distortion.data"};
  Lens lens;
  PANELCAL_TRY(lens.width_px, keys.pixels(kWidth));
  PANELCAL_TRY(lens.height_px, keys.pixels(kHeight));
  PANELCAL_TRY(const LensField* const matrix, keys.require(kMatrix));
  PANELCAL_TRY(const std::vector<double> k, keys.numbers(*matrix));
  const bool is_matrix =
      k.size() == 9 && k[1] == 0 && k[3] == 0 && k[6] == 0 && k[7] == 0 && k[8] == 1;
  if (!is_matrix) {
    return failure(bad_lens(matrix->place,
                            fmt::format("a camera matrix [{:g}]", fmt::join(k, ", ")),
                            "fx 0 cx, 0 fy cy, 0 0 1: a pinhole without skew"));
  }
  lens.focal_px = {k[0], k[4]};
  lens.center_px = {k[2], k[5]};
  const LensField* const model = keys.find("distortion_model");
  lens.format = model != nullptr ? LensFormat::RosCameraInfo : LensFormat::OpenCvYaml;
  if (model != nullptr) {
    const std::string name = model->texts.empty() ? std::string() : model->texts.front();
    if (name != "plumb_bob" && name != "rational_polynomial" && !name.empty()) {
      return failure(bad_lens(
          model->place, "the lens model " + quoted(name), "plumb_bob or rational_polynomial"));
    }
  }
  const LensField* const fisheye = keys.find("fisheye_model");
  if (fisheye != nullptr && fisheye->texts != std::vector<std::string>{"0"}) {
    return failure(
        bad_lens(fisheye->place, "a fisheye model", "OpenCV's pinhole with Brown's lens"));
  }
  PANELCAL_TRY(const LensField* const bend, keys.require(kLens));
  PANELCAL_TRY(const std::vector<double> d, keys.numbers(*bend));
  if (std::ranges::find(kOpenCvCounts, d.size()) == kOpenCvCounts.end()) {
    return failure(bad_lens(
        bend->place, fmt::format("{} distortion coefficients", d.size()), "4, 5, 8, 12 or 14"));
  }
  PANELCAL_CHECK(set_coefficients(bend->place, d, lens));
  return checked_lens(lens, matrix->place);
}

Expected<Lens> mrcal_lens(std::string_view text, const std::string& file) {
  PANELCAL_TRY(LensFields fields, read_mrcal_fields(text, file));
  const LensKeys keys(std::move(fields), file);
  constexpr std::array<std::string_view, 1> kModel = {"lensmodel"}, kIntrinsics = {"intrinsics"},
                                            kSize = {"imagersize"};
  PANELCAL_TRY(const LensField* const model, keys.require(kModel));
  PANELCAL_TRY(const LensField* const intrinsics, keys.require(kIntrinsics));
  PANELCAL_TRY(const LensField* const size, keys.require(kSize));
  const std::string name = model->texts.empty() ? std::string() : model->texts.front();
  const auto row = std::ranges::find(kMrcalModels, name, &LensModelRow::name);
  if (row == kMrcalModels.end()) {
    return failure(
        bad_lens(model->place,
                 "the lens model " + quoted(name),
                 "LENSMODEL_PINHOLE, or LENSMODEL_OPENCV4, 5, 8 or 12 without k4 to s4"));
  }
  Lens lens{.format = LensFormat::MrcalCameraModel};
  PANELCAL_TRY(const std::vector<double> values, keys.numbers(*intrinsics));
  if (values.size() != 4 + row->n_coefficients) {
    return failure(bad_lens(intrinsics->place,
                            fmt::format("{} intrinsics", values.size()),
                            fmt::format("{} of {}", 4 + row->n_coefficients, name)));
  }
  PANELCAL_TRY(const std::vector<double> pixels, keys.numbers(*size));
  const auto is_size = [](double n) { return n >= 1 && n <= kMaxPicture_px && n == std::floor(n); };
  if (pixels.size() != 2 || !is_size(pixels[0]) || !is_size(pixels[1])) {
    return failure(bad_lens(size->place,
                            "the imagersize",
                            fmt::format("width and height, 1 to {} px", kMaxPicture_px)));
  }
  lens.width_px = static_cast<int>(pixels[0]);
  lens.height_px = static_cast<int>(pixels[1]);
  lens.focal_px = {values[0], values[1]};
  lens.center_px = {values[2], values[3]};
  PANELCAL_CHECK(set_coefficients(intrinsics->place, std::span(values).subspan(4), lens));
  return checked_lens(lens, intrinsics->place);
}

}  // namespace
}  // namespace internal

std::string_view name_of(LensFormat format) {
  switch (format) {
    case LensFormat::OpenCvYaml:
      return "opencv";
    case LensFormat::RosCameraInfo:
      return "ros";
    case LensFormat::MrcalCameraModel:
      break;
  }
  return "mrcal";
}

Expected<Lens> parse_lens(std::string_view text, const std::string& file) {
  const auto has = [&](std::string_view word) { return text.find(word) != std::string_view::npos; };
  const bool is_mrcal = has("intrinsics") && has("imagersize");
  const bool is_yaml = has("camera_matrix") || has("Camera_Matrix") || has("cameraMatrix") ||
                       has("distortion_model") || has("intrinsic_matrix");
  if (is_mrcal && !is_yaml) return internal::mrcal_lens(text, file);
  if (is_yaml) return internal::yaml_lens(text, file);
  return failure(internal::bad_lens({file, 1, 1},
                                    "no camera model",
                                    "OpenCV's YAML (camera_matrix), ROS' camera_info (YAML) or "
                                    "mrcal's .cameramodel"));
}

namespace {

/// With a point: YAML 1.1 takes 1e-05 for a text.
std::string lens_number_text(double value) {
  std::string out = fmt::format("{}", value);
  if (out.find('.') == std::string::npos) out.insert(std::min(out.find('e'), out.size()), ".0");
  return out;
}

std::string joined_numbers(std::initializer_list<double> values) {
  std::string out;
  for (const double value : values) out += (out.empty() ? "" : ", ") + lens_number_text(value);
  return out;
}

}  // namespace

std::string lens_text(const Lens& lens, std::string_view comment) {
  const Eigen::Vector2d &f = lens.focal_px, &c = lens.center_px;
  const std::string matrix = joined_numbers({f.x(), 0, c.x(), 0, f.y(), c.y(), 0, 0, 1});
  const std::string bend = joined_numbers({lens.k1, lens.k2, lens.p1, lens.p2, lens.k3});
  switch (lens.format) {
    case LensFormat::OpenCvYaml:
      return fmt::format(
          "%YAML:1.0\n---\n# {}\nimage_width: {}\nimage_height: {}\n"
          "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ {} ]\n"
          "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n"
          "   data: [ {} ]\n",
          comment,
          lens.width_px,
          lens.height_px,
          matrix,
          bend);
    case LensFormat::RosCameraInfo:
      return fmt::format(
          "# {}\nimage_width: {}\nimage_height: {}\ncamera_name: panelcal\n"
          "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [{}]\n"
          "distortion_model: plumb_bob\n"
          "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [{}]\n"
          "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [{}]\n"
          "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [{}]\n",
          comment,
          lens.width_px,
          lens.height_px,
          matrix,
          bend,
          joined_numbers({1, 0, 0, 0, 1, 0, 0, 0, 1}),
          joined_numbers({f.x(), 0, c.x(), 0, 0, f.y(), c.y(), 0, 0, 0, 1, 0}));
    case LensFormat::MrcalCameraModel:
      break;
  }
  return fmt::format(
      "# {}\n{{\n    'lensmodel': 'LENSMODEL_OPENCV5',\n    'intrinsics': [ {}, {} ],\n"
      "    'extrinsics': [ 0, 0, 0, 0, 0, 0 ],\n    'imagersize': [ {}, {} ],\n}}\n",
      comment,
      joined_numbers({f.x(), f.y(), c.x(), c.y()}),
      bend,
      lens.width_px,
      lens.height_px);
}

}  // namespace panelcal
