// SPDX-License-Identifier: Apache-2.0
#include "vision/template/symmetry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/fit/raster_filter.h"
#include "vision/fit/spline_image.h"

namespace panelcal::internal {
namespace {

constexpr int kMostParts = 12;
constexpr int kLargestSide = 256;  // px: finer structure than 1/256 of a template is not compared
constexpr double kMark = 0.25;     // of the contrast: farther from the background is the mark
/// Differences are averaged over this number of px, that noise and edges a fraction of a pixel
/// aside do not count, and have to stay below this part of the contrast.
constexpr double kAveraged = 1.5;
constexpr double kSame = 0.25;

bool is_mark(const TemplateModel& model, double level) {
  return std::abs(level - model.background) > kMark;
}

const SplineImage& small_enough(const TemplateModel& model) {
  const SplineImage* image = &model.smooth;
  for (const SplineImage& reduced : model.reduced) {
    if (std::max(image->width(), image->height()) <= kLargestSide) break;
    image = &reduced;
  }
  return *image;
}

double template_level_at(const SplineImage& image, double x, double y) {
  return image(Eigen::Vector2d(x, y)).value;
}

Eigen::Vector2d middle_of_mark(const TemplateModel& model, const SplineImage& image) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weight = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double level = template_level_at(image, x, y);
      if (!is_mark(model, level)) continue;
      const double w = std::abs(level - model.background);
      sum += w * Eigen::Vector2d(x, y);
      weight += w;
    }
  }
  return weight > 0 ? Eigen::Vector2d(sum / weight) : Eigen::Vector2d::Zero();
}

/// A part of the mark that would be turned out of the picture makes it another one.
bool looks_the_same(const TemplateModel& model,
                    const SplineImage& image,
                    const Eigen::Vector2d& middle,
                    double turn_rad) {
  const double c = std::cos(turn_rad);
  const double s = std::sin(turn_rad);
  Raster difference(image.width(), image.height());
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double level = template_level_at(image, x, y);
      const double dx = x - middle.x();
      const double dy = y - middle.y();
      const double turned_x = middle.x() + c * dx - s * dy;
      const double turned_y = middle.y() + s * dx + c * dy;
      const bool is_inside = turned_x >= 0 && turned_x <= image.width() - 1 && turned_y >= 0 &&
                             turned_y <= image.height() - 1;
      if (is_inside) {
        difference.at(x, y) = template_level_at(image, turned_x, turned_y) - level;
      } else if (is_mark(model, level)) {
        return false;
      }
    }
  }
  const Raster averaged = blurred(difference, kAveraged);
  return std::ranges::all_of(averaged.values, [](double v) { return std::abs(v) < kSame; });
}

}  // namespace

std::optional<double> self_turn(const TemplateModel& model, double limit_rad) {
  const double smallest = 2 * std::numbers::pi / kMostParts;
  if (limit_rad <= smallest) return std::nullopt;
  const SplineImage& image = small_enough(model);
  const Eigen::Vector2d middle = middle_of_mark(model, image);
  for (int n_parts = kMostParts; n_parts >= 2; --n_parts) {
    const double turn_rad = 2 * std::numbers::pi / n_parts;
    if (turn_rad < limit_rad && looks_the_same(model, image, middle, turn_rad)) return turn_rad;
  }
  return std::nullopt;
}

}  // namespace panelcal::internal
