// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/raster_filter.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace panelcal::internal {
namespace {

/// Without a copy.
cv::Mat mat_of(Raster& raster) {
  return {raster.height, raster.width, CV_64F, raster.values.data()};
}
const cv::Mat mat_of(const Raster& raster) {
  return {raster.height, raster.width, CV_64F, const_cast<double*>(raster.values.data())};
}

}  // namespace

Raster blurred(const Raster& in, double sigma_px) {
  if (!(sigma_px > 0) || in.values.empty()) return in;
  const int side = 2 * std::max(1, static_cast<int>(std::ceil(4 * sigma_px))) + 1;
  Raster out(in.width, in.height);
  cv::Mat to = mat_of(out);
  cv::GaussianBlur(mat_of(in), to, {side, side}, sigma_px, sigma_px, cv::BORDER_REFLECT_101);
  return out;
}

Raster averaged(const Raster& in, int factor) {
  if (factor <= 1) return in;
  Raster out(in.width / factor, in.height / factor);
  if (out.values.empty()) return out;
  const cv::Rect part(0, 0, out.width * factor, out.height * factor);
  cv::Mat to = mat_of(out);
  cv::resize(mat_of(in)(part), to, to.size(), 0, 0, cv::INTER_AREA);
  return out;
}

Raster laplacian(const Raster& in) {
  Raster out(in.width, in.height);
  cv::Mat to = mat_of(out);
  cv::Laplacian(mat_of(in), to, CV_64F, 1, 1, 0, cv::BORDER_REPLICATE);
  return out;
}

}  // namespace panelcal::internal
