// SPDX-License-Identifier: Apache-2.0
#include "vision/template/noise.h"

#include "vision/fit/raster_filter.h"

namespace panelcal::internal {
namespace {

constexpr int kSide = 65;
constexpr int kMiddle = kSide / 2;

/// Two equal rows: the smallest raster in which a spline along x is one.
Raster impulse() {
  Raster raster(kSide, 2);
  raster.at(kMiddle, 0) = raster.at(kMiddle, 1) = 1;
  return raster;
}

Raster second_difference(const Raster& in) {
  Raster out(in.width, in.height);
  for (int y = 0; y < in.height; ++y) {
    for (int x = 1; x + 1 < in.width; ++x) {
      out.at(x, y) = in.at(x - 1, y) - 2 * in.at(x, y) + in.at(x + 1, y);
    }
  }
  return out;
}

}  // namespace

TemplateNoiseTable::TemplateNoiseTable() {
  const Raster smooth_impulse = blurred(impulse(), kTemplateSmoothingPx);
  const Raster raw = spline_coefficients(impulse());
  const Raster smooth = spline_coefficients(smooth_impulse);
  const Raster curvature = spline_coefficients(second_difference(smooth_impulse));
  for (std::size_t i = 0; i < table_.size(); ++i) {
    const double fraction = static_cast<double>(i) / kSteps;
    Products& p = table_[i];
    // One pixel seen from all places is as good as all pixels seen from one.
    for (int k = 4; k < kSide - 4; ++k) {
      const SplineWeights weights(k + fraction);
      double r = 0;
      double s = 0;
      double slope = 0;
      double raw_slope = 0;
      double c = 0;
      for (std::size_t j = 0; j < 4; ++j) {
        const int x = weights.first + static_cast<int>(j);
        r += weights.value[j] * raw.at(x, 0);
        s += weights.value[j] * smooth.at(x, 0);
        raw_slope += weights.slope[j] * raw.at(x, 0);
        slope += weights.slope[j] * smooth.at(x, 0);
        c += weights.value[j] * curvature.at(x, 0);
      }
      p.raw_raw += r * r;
      p.raw_smooth += r * s;
      p.raw_slope += r * slope;
      p.raw_curvature += r * c;
      p.slope_slope += raw_slope * slope;
      p.curvature_curvature += c * c;
    }
  }
}

}  // namespace panelcal::internal
