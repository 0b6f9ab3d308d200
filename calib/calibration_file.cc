// SPDX-License-Identifier: Apache-2.0
#include "panelcal/calib/calibration_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "panelcal/calib/base/atomic_file.h"
#include "panelcal/calib/base/clock.h"
#include "panelcal/calib/strict_json.h"

namespace panelcal {
namespace {

using internal::StrictObject;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

constexpr std::string_view kKind = "camera";
constexpr int kVersion = 1;
constexpr int kMaxPicture_px = 100000;
/// Rounding that a covariance may have suffered on its way through other programs.
constexpr double kCovarianceRounding = 1e-9;

Diagnostic invalid(const std::string& file, std::string what, std::string expected) {
  return {Code::CalibrationInvalid, {file, 0, 0}, std::move(what), std::move(expected)};
}

bool is_symmetric(const Matrix5d& cov) {
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < i; ++j) {
      const double size = std::sqrt(std::abs(cov(i, i))) * std::sqrt(std::abs(cov(j, j)));
      if (!(std::abs(cov(i, j) - cov(j, i)) <= kCovarianceRounding * size)) return false;
    }
  }
  return true;
}

/// Judged on correlations, since the five variances differ by twenty orders of magnitude.
bool is_positive_semidefinite(const Matrix5d& cov) {
  Matrix5d correlation = Matrix5d::Identity();
  for (int i = 0; i < 5; ++i) {
    if (!(cov(i, i) >= 0)) return false;
    for (int j = 0; j < i; ++j) {
      const double size = std::sqrt(cov(i, i)) * std::sqrt(cov(j, j));
      if (size == 0 && cov(i, j) != 0) return false;
      correlation(i, j) = correlation(j, i) = size == 0 ? 0 : cov(i, j) / size;
    }
  }
  if (!correlation.allFinite()) return false;
  const Eigen::SelfAdjointEigenSolver<Matrix5d> solver(correlation, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().minCoeff() >= -kCovarianceRounding;
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

/// What the types of the file cannot say.
Expected<void> check(const CameraCalibration& c, const std::string& file) {
  const CameraMapping::Parameters& p = c.parameters;
  if (!std::isfinite(p.scale_mm_per_px) || p.scale_mm_per_px <= 0) {
    return failure(invalid(file,
                           fmt::format("scale_mm_per_px is {}", p.scale_mm_per_px),
                           "a number above 0 (directions are in rotation_rad)"));
  }
  if (!std::isfinite(p.rotation_rad) || !p.axis_px.allFinite() || !std::isfinite(p.k1_per_px2)) {
    return failure(invalid(file, "a parameter is not finite", "finite numbers"));
  }
  for (const int side_px : {c.picture_width_px, c.picture_height_px}) {
    if (side_px >= 1 && side_px <= kMaxPicture_px) continue;
    return failure(invalid(file,
                           fmt::format("a side of picture_px is {}", side_px),
                           fmt::format("1 to {}", kMaxPicture_px)));
  }
  const double slope = 1 + 3 * p.k1_per_px2 * farthest_corner_px2(c);
  if (!(slope > 0)) {
    return failure(invalid(file,
                           fmt::format("k1_per_px2 is {}: the lens model folds over inside the "
                                       "picture (1 + 3 k1 r^2 is {:.3g} at a corner)",
                                       p.k1_per_px2,
                                       slope),
                           "1 + 3 k1 r^2 above 0 everywhere in the picture"));
  }
  if (!c.covariance.allFinite() || !is_symmetric(c.covariance)) {
    return failure(invalid(file, "the covariance is not symmetric", "a symmetric matrix"));
  }
  if (!is_positive_semidefinite(c.covariance)) {
    return failure(invalid(file,
                           "the covariance is not positive semidefinite",
                           "variances of at least 0 and correlations that fit together"));
  }
  return {};
}

Expected<void> check_units(const StrictObject& top, const std::string& file) {
  constexpr std::array<std::string_view, 3> kKeys = {"length", "angle", "picture"};
  PANELCAL_TRY(
      const StrictObject units,
      StrictObject::make(top.member("units"), "units", kKeys, Code::CalibrationInvalid, file));
  PANELCAL_CHECK(units.constant("length", "mm"));
  PANELCAL_CHECK(units.constant("angle", "rad"));
  return units.constant("picture", "px");
}

Expected<CameraMapping::Parameters> read_parameters(const StrictObject& top,
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

Expected<std::chrono::sys_seconds> read_date(const StrictObject& top, const std::string& file) {
  PANELCAL_TRY(const std::string text, top.text("date"));
  if (const std::optional<std::chrono::sys_seconds> date = from_iso_8601(text)) return *date;
  return failure(
      invalid(file, "\"date\" is " + quoted(text), "a time such as 2026-11-21T08:37:38Z"));
}

}  // namespace

Expected<CameraCalibration> parse_camera_calibration(std::string_view text,
                                                     const std::string& file) {
  constexpr std::array<std::string_view, 8> kKeys = {
      "kind", "version", "date", "provenance", "units", "picture_px", "parameters", "covariance"};
  PANELCAL_TRY(const nlohmann::json document, internal::parse_strict_json(text, file));
  PANELCAL_TRY(
      const StrictObject top,
      StrictObject::make(document, "the calibration", kKeys, Code::CalibrationInvalid, file));
  PANELCAL_CHECK(top.constant("kind", kKind));
  PANELCAL_TRY(const int version, top.integer("version", kVersion, kVersion));
  static_cast<void>(version);
  PANELCAL_CHECK(check_units(top, file));

  CameraCalibration c;
  PANELCAL_TRY(c.date, read_date(top, file));
  PANELCAL_TRY(c.provenance, top.text("provenance"));
  PANELCAL_TRY(c.parameters, read_parameters(top, file));
  PANELCAL_TRY(const std::vector<double> picture_px, top.numbers("picture_px", 2));
  for (const double side_px : picture_px) {
    if (side_px == std::floor(side_px) && std::abs(side_px) <= kMaxPicture_px) continue;
    return failure(
        invalid(file, fmt::format("a side of picture_px is {}", side_px), "whole pixels"));
  }
  c.picture_width_px = static_cast<int>(picture_px[0]);
  c.picture_height_px = static_cast<int>(picture_px[1]);
  PANELCAL_TRY(const std::vector<double> covariance, top.matrix("covariance", 5, 5));
  c.covariance = Eigen::Map<const Eigen::Matrix<double, 5, 5, Eigen::RowMajor>>(covariance.data());
  PANELCAL_CHECK(check(c, file));
  return c;
}

Expected<CameraCalibration> read_camera_calibration(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxCalibrationBytes));
  return parse_camera_calibration(text, path.string());
}

std::string camera_calibration_text(const CameraCalibration& c) {
  const CameraMapping::Parameters& p = c.parameters;
  const std::string provenance =
      nlohmann::json(c.provenance).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  std::string text = fmt::format(R"({{
  "kind": "{}",
  "version": {},
  "date": "{}",
  "provenance": {},
  "units": {{"length": "mm", "angle": "rad", "picture": "px"}},
  "picture_px": [{}, {}],
  "parameters": {{
    "scale_mm_per_px": {},
    "rotation_rad": {},
    "axis_px": [{}, {}],
    "k1_per_px2": {}
  }},
  "covariance": [
)",
                                 kKind,
                                 kVersion,
                                 iso_8601(c.date),
                                 provenance,
                                 c.picture_width_px,
                                 c.picture_height_px,
                                 p.scale_mm_per_px,
                                 p.rotation_rad,
                                 p.axis_px.x(),
                                 p.axis_px.y(),
                                 p.k1_per_px2);
  for (int i = 0; i < 5; ++i) {
    const Eigen::Matrix<double, 1, 5> row = c.covariance.row(i);
    text +=
        fmt::format("    [{}]{}\n", fmt::join(row.data(), row.data() + 5, ", "), i < 4 ? "," : "");
  }
  return text + "  ]\n}\n";
}

Expected<void> write_camera_calibration(const std::filesystem::path& path,
                                        const CameraCalibration& calibration) {
  PANELCAL_CHECK(check(calibration, path.string()));
  return write_file(path, camera_calibration_text(calibration));
}

}  // namespace panelcal
