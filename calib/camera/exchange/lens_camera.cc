// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/exchange/lens_camera.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "calib/base/statistics/linear_algebra.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Steps of the lattice of pixels along each side on which lenses are compared.
constexpr int kCompared = 40;
constexpr int kMaxInversions = 50;
constexpr double kInverted = 1e-13;

using Vector2d = Eigen::Vector2d;

Diagnostic no_match(std::string what, std::string expected) {
  return {Code::CalibrationInvalid, {}, std::move(what), std::move(expected)};
}

/// Pixels over the whole picture, its rim included, relative to a center and in units of `focal`.
std::vector<Vector2d> lattice_of(int width_px,
                                 int height_px,
                                 const Vector2d& center_px,
                                 double focal_px) {
  std::vector<Vector2d> out;
  for (int row = 0; row <= kCompared; ++row) {
    for (int column = 0; column <= kCompared; ++column) {
      const Vector2d u_px(width_px * static_cast<double>(column) / kCompared - 0.5,
                          height_px * static_cast<double>(row) / kCompared - 0.5);
      out.push_back((u_px - center_px) / focal_px);
    }
  }
  return out;
}

Vector2d bent(const Lens& lens, const Vector2d& p) {
  const double rr = p.squaredNorm(), xy = p.x() * p.y();
  const double radial = 1 + rr * (lens.k1 + rr * (lens.k2 + rr * lens.k3));
  return radial * p + Vector2d(2 * lens.p1 * xy + lens.p2 * (rr + 2 * p.x() * p.x()),
                               lens.p1 * (rr + 2 * p.y() * p.y()) + 2 * lens.p2 * xy);
}

Eigen::Matrix2d bend_slope(const Lens& lens, const Vector2d& p) {
  const double rr = p.squaredNorm(), x = p.x(), y = p.y();
  const double radial = 1 + rr * (lens.k1 + rr * (lens.k2 + rr * lens.k3));
  const double by_rr = lens.k1 + rr * (2 * lens.k2 + rr * 3 * lens.k3);
  Eigen::Matrix2d out = radial * Eigen::Matrix2d::Identity() + 2 * by_rr * p * p.transpose();
  out(0, 0) += 2 * lens.p1 * y + 6 * lens.p2 * x;
  out(1, 1) += 6 * lens.p1 * y + 2 * lens.p2 * x;
  out(0, 1) += 2 * lens.p1 * x + 2 * lens.p2 * y;
  out(1, 0) += 2 * lens.p1 * x + 2 * lens.p2 * y;
  return out;
}

/// The ray that the lens bends to `q`, by Newton's method; empty where it folds over on the way.
std::optional<Vector2d> straightened(const Lens& lens, const Vector2d& q) {
  Vector2d p = q;
  for (int i = 0; i < kMaxInversions; ++i) {
    const Eigen::Matrix2d slope = bend_slope(lens, p);
    const double determinant = slope.determinant();
    if (!(determinant > 0) || !(slope.trace() > 0)) return std::nullopt;
    const Vector2d miss = q - bent(lens, p);
    const Vector2d step(slope(1, 1) * miss.x() - slope(0, 1) * miss.y(),
                        slope(0, 0) * miss.y() - slope(1, 0) * miss.x());
    p += step / determinant;
    if (!p.allFinite()) return std::nullopt;
    if (step.norm() / determinant < kInverted) return p;
  }
  return std::nullopt;
}

/// Brown's coefficients k1, k2, p1, p2, k3 that carry `from` to `to` by least squares.
///
/// In     n_radial: 0, 2 or 3; without is_tangential p1 and p2 are 0
Lens fitted(const std::vector<Vector2d>& from,
            const std::vector<Vector2d>& to,
            int n_radial,
            bool is_tangential) {
  const auto n = static_cast<Eigen::Index>(from.size());
  const Eigen::Index n_columns = n_radial + (is_tangential ? 2 : 0);
  Eigen::MatrixXd a(2 * n, n_columns), b(2 * n, 1);
  double largest = 0;
  for (const Vector2d& p : from) largest = std::max(largest, p.norm());
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector2d& p = from[static_cast<std::size_t>(i)];
    b.block<2, 1>(2 * i, 0) = to[static_cast<std::size_t>(i)] - p;
    // In units of the largest distance, so that no column vanishes beside another.
    const Vector2d u = p / largest;
    const double rr = u.squaredNorm(), xy = u.x() * u.y();
    double power = 1;
    for (int k = 0; k < n_radial; ++k) a.block<2, 1>(2 * i, k) = (power *= rr) * u;
    if (!is_tangential) continue;
    a.block<2, 1>(2 * i, n_radial) = Vector2d(2 * xy, rr + 2 * u.y() * u.y());
    a.block<2, 1>(2 * i, n_radial + 1) = Vector2d(rr + 2 * u.x() * u.x(), 2 * xy);
  }
  Lens out;
  if (n_columns == 0) return out;
  const Eigen::MatrixXd x = internal::solve_least_squares(a, b);
  const double square = largest * largest;
  if (n_radial > 0) out.k1 = x(0, 0) / (square * largest);
  if (n_radial > 1) out.k2 = x(1, 0) / (square * square * largest);
  if (n_radial > 2) out.k3 = x(2, 0) / (square * square * square * largest);
  if (is_tangential) {
    out.p1 = x(n_radial, 0) / square;
    out.p2 = x(n_radial + 1, 0) / square;
  }
  return out;
}

double greatest_error(const Lens& lens,
                      const std::vector<Vector2d>& from,
                      const std::vector<Vector2d>& to) {
  double out = 0;
  for (std::size_t i = 0; i < from.size(); ++i)
    out = std::max(out, (bent(lens, from[i]) - to[i]).norm());
  return out;
}

Expected<void> check_error(double error_px, double max_error_px, std::string_view model) {
  if (error_px <= max_error_px) return {};
  return failure(
      no_match(fmt::format("{} misses the lens by {:.3g} px in the picture", model, error_px),
               fmt::format("at most {:g} px", max_error_px)));
}

CameraForm form_of(const CameraModel::Parameters& p) {
  if (p.p1_per_px != 0 || p.p2_per_px != 0) return CameraForm::Tangential;
  if (p.k2_per_px4 != 0) return CameraForm::TiltedRadial;
  return p.k1_per_px2 != 0 ? CameraForm::Radial : CameraForm::Flat;
}

double farthest_px(const Lens& lens) {
  double out = 0;
  for (const double x_px : {-0.5, lens.width_px - 0.5}) {
    for (const double y_px : {-0.5, lens.height_px - 0.5}) {
      out = std::max(out, (Vector2d(x_px, y_px) - lens.center_px).norm());
    }
  }
  return out;
}

FullCamera mounted(const Lens& lens, const Lens& inverse, const LensMount& mount) {
  const double f = lens.focal_px.x();
  FullCamera out;
  CameraModel::Parameters& p = out.parameters;
  p.scale_mm_per_px = mount.scale_mm_per_px;
  p.rotation_rad = mount.rotation_rad;
  p.axis_px = lens.center_px;
  p.focal_px = f;
  p.k1_per_px2 = inverse.k1 / (f * f);
  p.k2_per_px4 = inverse.k2 / (f * f * f * f);
  p.p1_per_px = inverse.p1 / f;
  p.p2_per_px = inverse.p2 / f;
  out.form = form_of(p);
  for (const CameraParameter one : free_parameters(out.form)) {
    if (one != CameraParameter::Scale && one != CameraParameter::Rotation)
      out.undetermined.push_back(one);
  }
  const double sigma_mm_per_px = mount.corner_sigma.in_mm() / (std::sqrt(2.0) * farthest_px(lens));
  out.covariance(0, 0) = sigma_mm_per_px * sigma_mm_per_px;
  out.covariance(1, 1) = out.covariance(0, 0) / (mount.scale_mm_per_px * mount.scale_mm_per_px);
  return out;
}

}  // namespace

Expected<LensCamera> camera_of_lens(const Lens& lens, const LensMount& mount) {
  const bool is_mount = mount.scale_mm_per_px > 0 && std::isfinite(mount.scale_mm_per_px) &&
                        std::isfinite(mount.rotation_rad) && mount.corner_sigma > Length() &&
                        std::isfinite(mount.corner_sigma.in_mm());
  if (!is_mount)
    return failure(no_match("a scale, rotation or sigma out of range", "finite, above 0"));
  const double f = lens.focal_px.x();
  const double aspect = lens.focal_px.y() / f;
  const double off_square_px = std::abs(aspect - 1) * std::max(lens.width_px, lens.height_px) / 2;
  if (off_square_px > mount.max_error_px) {
    return failure(no_match(
        fmt::format("fx is {} and fy {}: pixels that are not square", f, lens.focal_px.y()),
        fmt::format("the same within {:g} px over the picture", mount.max_error_px)));
  }
  std::vector<Vector2d> pixels = lattice_of(lens.width_px, lens.height_px, lens.center_px, f), rays;
  for (const Vector2d& pixel : pixels) {
    const auto ray = straightened(lens, {pixel.x(), pixel.y() / aspect});
    if (!ray)
      return failure(no_match("a lens that folds over in the picture", "one that does not"));
    rays.push_back(*ray);
  }
  const bool is_tangential = lens.p1 != 0 || lens.p2 != 0;
  const Lens inverse = fitted(pixels, rays, lens.is_bent() ? 2 : 0, is_tangential);
  LensCamera out;
  out.error_px = f * greatest_error(inverse, pixels, rays);
  PANELCAL_CHECK(check_error(out.error_px, mount.max_error_px, "the model of panelcal"));
  FullCamera camera = mounted(lens, inverse, mount);
  camera.rms_px = out.error_px;
  out.calibration = calibration_of(camera, lens.width_px, lens.height_px);
  return out;
}

Expected<CameraLens> lens_of_camera(const CameraCalibration& calibration,
                                    std::optional<double> focal_px,
                                    double max_error_px) {
  const CameraModel::Parameters p = calibration.model().parameters();
  if (!p.tilt.isZero(0)) {
    return failure(no_match(fmt::format("a tilt of ({:g}, {:g})", p.tilt.x(), p.tilt.y()),
                            "a camera that looks straight down: no lens model has a tilt"));
  }
  const double f = focal_px.value_or(p.focal_px);
  if (!(f > 0 && std::isfinite(f))) {
    return failure(no_match("a telecentric camera, which has no focal length", "--focal-px"));
  }
  const std::vector<Vector2d> pixels =
      lattice_of(calibration.picture_width_px, calibration.picture_height_px, p.axis_px, f);
  Lens ours;
  ours.k1 = p.k1_per_px2 * f * f;
  ours.k2 = p.k2_per_px4 * f * f * f * f;
  ours.p1 = p.p1_per_px * f;
  ours.p2 = p.p2_per_px * f;
  std::vector<Vector2d> rays;
  for (const Vector2d& pixel : pixels) rays.push_back(bent(ours, pixel));
  CameraLens out;
  out.lens = fitted(rays, pixels, ours.is_bent() ? 3 : 0, ours.p1 != 0 || ours.p2 != 0);
  out.error_px = f * greatest_error(out.lens, rays, pixels);
  PANELCAL_CHECK(check_error(out.error_px, max_error_px, "Brown's lens"));
  out.lens.width_px = calibration.picture_width_px;
  out.lens.height_px = calibration.picture_height_px;
  out.lens.focal_px = {f, f};
  out.lens.center_px = p.axis_px;
  return out;
}

}  // namespace panelcal
