// SPDX-License-Identifier: Apache-2.0
#include "vision/render/scene_picture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace panelcal::internal {
namespace {

constexpr int kMostPoints = 8;

/// Index of a sample beyond an end, by reflection in the end samples.
int reflected(int i, int n) {
  if (n == 1) return 0;
  const int period = 2 * (n - 1);
  i = std::abs(i) % period;
  return i < n ? i : period - i;
}

}  // namespace

PictureSampler::PictureSampler(const Feature& feature, const SceneProjection& projection)
    : projection_(projection),
      center_mm_(feature.center.in_mm()),
      reference_px_(feature.picture->reference_px),
      width_(feature.picture->image.width()),
      height_(feature.picture->image.height()) {
  const double px_per_mm = width_ / feature.size.in_mm();
  const double c = px_per_mm * std::cos(feature.angle.in_rad());
  const double s = px_per_mm * std::sin(feature.angle.in_rad());
  picture_from_board_ << c, s, s, -c;  // y is down in a picture
  const double ratio = px_per_mm * projection.scale_mm_per_px();
  n_points_ = static_cast<int>(std::clamp(std::round(ratio), 1.0, double{kMostPoints}));

  const Image& image = feature.picture->image;
  const double to_share = 1 / image.full_scale();
  Raster levels(width_, height_);
  std::ranges::transform(image.pixels(), levels.values.begin(), [to_share](float v) {
    return to_share * static_cast<double>(v);
  });
  coefficients_ = spline_coefficients(levels);
}

double PictureSampler::level(const Eigen::Vector2d& u_px) const {
  double sum = 0;
  for (int j = 0; j < n_points_; ++j) {
    for (int i = 0; i < n_points_; ++i) {
      const Eigen::Vector2d part((i + 0.5) / n_points_ - 0.5, (j + 0.5) / n_points_ - 0.5);
      const Eigen::Vector2d on_board_mm = projection_.board_of(u_px + part) - center_mm_;
      sum += spline(reference_px_ + picture_from_board_ * on_board_mm);
    }
  }
  return sum / (n_points_ * n_points_);
}

double PictureSampler::spline(const Eigen::Vector2d& at_px) const {
  // Pixels at the rim of the picture reach beyond it, but not far.
  const double x = std::clamp(at_px.x(), -1.0, static_cast<double>(width_));
  const double y = std::clamp(at_px.y(), -1.0, static_cast<double>(height_));
  const SplineWeights weights_x(x);
  const SplineWeights weights_y(y);
  double sum = 0;
  for (int j = 0; j < 4; ++j) {
    double row = 0;
    for (int i = 0; i < 4; ++i) {
      row += weights_x.value[static_cast<std::size_t>(i)] *
             coefficients_.at(reflected(weights_x.first + i, width_),
                              reflected(weights_y.first + j, height_));
    }
    sum += weights_y.value[static_cast<std::size_t>(j)] * row;
  }
  return sum;
}

}  // namespace panelcal::internal
