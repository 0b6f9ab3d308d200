// SPDX-License-Identifier: Apache-2.0
#include "vision/template/model.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/base/statistics/median.h"
#include "vision/fit/raster_filter.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr int kMinTemplateSide = 8;  // px
/// Larger ones would take seconds and gigabytes; no camera sees as much.
constexpr double kMaxPixels = 2e7;
constexpr double kFineEnough = 0.75;       // px of the picture per px of the template
constexpr double kLocal = 1.5;             // px: neighbourhood in which structure is looked for
constexpr double kWide = 2.5;              // px: sigma of the mean where there is none
constexpr double kModelRounding = 0.2887;  // sigma of rounding to whole levels
/// Local variance over that of the noise from which structure begins, and is sure.
constexpr double kPerhaps = 2;
constexpr double kSureStructure = 6;
/// Contrast over noise that a template needs.
constexpr double kMinContrast = 8;
/// Least over largest gradient energy: below, it is only known across one direction.
constexpr double kMinBalance = 0.01;

Raster raster_of(const Image& image) {
  Raster raster(image.width(), image.height());
  std::copy(image.pixels().begin(), image.pixels().end(), raster.values.begin());
  return raster;
}

/// Sigma of the noise that differs from pixel to pixel: a mask blind to planes, and the median's
/// little sister, blind to a share of edges.
double noise_of(const Raster& t) {
  constexpr double kShare = 0.3;
  constexpr double kQuantile = 0.38532;  // of |normal| at kShare
  std::vector<double> values;
  values.reserve(t.values.size());
  const auto row_sum = [&](int x, int y) {
    return t.at(x - 1, y) - 2 * t.at(x, y) + t.at(x + 1, y);
  };
  for (int y = 1; y + 1 < t.height; ++y) {
    for (int x = 1; x + 1 < t.width; ++x) {
      values.push_back(std::abs(row_sum(x, y - 1) - 2 * row_sum(x, y) + row_sum(x, y + 1)));
    }
  }
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(kShare * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at / kQuantile / 6;
}

/// Sum of the squares of a Gaussian kernel: what is left of white noise's variance behind it.
double kept_variance(double sigma_px) {
  Raster impulse(17, 17);
  impulse.at(8, 8) = 1;
  double sum = 0;
  for (const double v : blurred(impulse, sigma_px).values) sum += v * v;
  return sum;
}

/// A little blurred; where only noise is seen, the local mean. Which it is goes to `structure`.
Raster smoothed_template(const Raster& t, double noise, Raster& structure) {
  const Raster fine = blurred(t, kTemplateSmoothingPx);
  const Raster wide = blurred(t, kWide);
  Raster mean = blurred(fine, kLocal);
  Raster square = fine;
  for (double& v : square.values) v *= v;
  square = blurred(square, kLocal);
  const double noise_variance = noise * noise * kept_variance(kTemplateSmoothingPx);
  Raster out(t.width, t.height);
  structure = Raster(t.width, t.height);
  for (std::size_t i = 0; i < out.values.size(); ++i) {
    const double variance = square.values[i] - mean.values[i] * mean.values[i];
    const double ratio = variance / std::max(noise_variance, 1e-12);
    const double share = std::clamp((ratio - kPerhaps) / (kSureStructure - kPerhaps), 0.0, 1.0);
    structure.values[i] = share;
    out.values[i] = wide.values[i] + share * (fine.values[i] - wide.values[i]);
  }
  return out;
}

double border_median(const Raster& t) {
  std::vector<double> values;
  for (int x = 0; x < t.width; ++x) {
    values.push_back(t.at(x, 0));
    values.push_back(t.at(x, t.height - 1));
  }
  for (int y = 0; y < t.height; ++y) {
    values.push_back(t.at(0, y));
    values.push_back(t.at(t.width - 1, y));
  }
  return median(std::move(values));
}

/// Reason why the template's edges do not determine its place.
std::string structure_problem(const Raster& smooth, double noise, double contrast) {
  if (!(contrast > kMinContrast * noise)) {
    return fmt::format(
        "its levels differ by {:.1f} at a noise of {:.1f}: it is as good as flat", contrast, noise);
  }
  Eigen::Matrix2d energy = Eigen::Matrix2d::Zero();
  for (int y = 1; y + 1 < smooth.height; ++y) {
    for (int x = 1; x + 1 < smooth.width; ++x) {
      const Eigen::Vector2d g(0.5 * (smooth.at(x + 1, y) - smooth.at(x - 1, y)),
                              0.5 * (smooth.at(x, y + 1) - smooth.at(x, y - 1)));
      energy += g * g.transpose();
    }
  }
  // Noise has gradients as well: 1 / (8 pi s^4) of its variance behind a blur of sigma s.
  constexpr double kNoiseShare = 0.2;
  const double of_noise = kNoiseShare * noise * noise * static_cast<double>(smooth.values.size());
  const Eigen::Vector2d eigenvalues = plane_eigensystem(energy).values;
  if (eigenvalues[0] - of_noise < kMinBalance * eigenvalues[1]) {
    return "it shows parallel edges only, which do not determine the place along them";
  }
  return {};
}

std::vector<SplineImage> reduced_levels(const Raster& smooth) {
  std::vector<SplineImage> levels;
  for (int factor = 2; std::min(smooth.width, smooth.height) / factor >= kMinTemplateSide;
       factor *= 2) {
    levels.emplace_back(averaged(smooth, factor));
  }
  return levels;
}

}  // namespace

tl::expected<TemplateModel, std::string> make_template_model(const TemplatePicture& picture,
                                                             double width,
                                                             double y_sign) {
  const auto refused = [&](const std::string& why) {
    return tl::make_unexpected(fmt::format("the template {} will not do: {}", picture.file, why));
  };
  const Image& image = picture.image;
  if (image.width() < kMinTemplateSide || image.height() < kMinTemplateSide) {
    return refused(fmt::format("it has {} x {} px, at least {} either way are needed",
                               image.width(),
                               image.height(),
                               kMinTemplateSide));
  }
  if (static_cast<double>(image.width()) * image.height() > kMaxPixels) {
    return refused(fmt::format("it has {} x {} px, at most {:.0f} million are read",
                               image.width(),
                               image.height(),
                               1e-6 * kMaxPixels));
  }
  if (!picture.reference_px.allFinite()) return refused("its reference is nowhere");
  if (std::ranges::any_of(image.pixels(), [](float v) { return !std::isfinite(v); })) {
    return refused("some of its pixels are no numbers");
  }
  TemplateModel model;
  model.y_sign = y_sign;
  const double px_per_px = width / image.width();
  const int factor = px_per_px < kFineEnough ? static_cast<int>(1 / px_per_px + 0.5) : 1;
  if (image.width() / factor < kMinTemplateSide || image.height() / factor < kMinTemplateSide) {
    return refused(fmt::format(
        "it would be {:.0f} px wide in pictures, at least {} are needed", width, kMinTemplateSide));
  }
  Raster levels = averaged(raster_of(image), factor);
  model.pitch = px_per_px * factor;
  model.reference = (picture.reference_px.array() + 0.5) / factor - 0.5;
  const double noise = std::max(noise_of(levels), kModelRounding / factor);
  Raster smooth = smoothed_template(levels, noise, model.structure);
  const auto [low, high] = std::ranges::minmax(smooth.values);
  model.contrast = high - low;
  if (std::string why = structure_problem(smooth, noise, model.contrast); !why.empty()) {
    return refused(why);
  }
  for (const double v : smooth.values) model.mean += v / static_cast<double>(smooth.values.size());
  model.background = (border_median(smooth) - model.mean) / model.contrast;
  model.noise = noise / model.contrast;
  for (Raster* raster : {&levels, &smooth}) {
    for (double& v : raster->values) v = (v - model.mean) / model.contrast;
  }
  model.raw = SplineImage(levels);
  model.smooth = SplineImage(smooth);
  model.curvature = SplineImage(laplacian(smooth));
  model.reduced = reduced_levels(smooth);
  return model;
}

}  // namespace panelcal::internal
