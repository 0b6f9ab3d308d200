// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/pattern_search.h"

#include <algorithm>
#include <cmath>

#include "vision/fit/local_maxima.h"
#include "vision/fit/regression.h"
#include "vision/picture/cv_bridge.h"
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace panelcal::internal {
namespace {

/// Best correlation at every pixel and the pattern that has it.
struct Best {
  cv::Mat correlation;
  cv::Mat pattern;
};

Best best_of(const cv::Mat& picture, std::span<const SearchPattern> patterns, bool is_inverted) {
  Best best{cv::Mat(picture.size(), CV_32F, cv::Scalar(-1)),
            cv::Mat(picture.size(), CV_32S, cv::Scalar(0))};
  cv::Mat padded;
  cv::Mat correlation;
  cv::Mat is_better;
  for (std::size_t i = 0; i < patterns.size(); ++i) {
    const cv::Mat pattern = pixels_of(patterns[i].picture);
    const int rx = pattern.cols / 2;
    const int ry = pattern.rows / 2;
    cv::copyMakeBorder(picture, padded, ry, ry, rx, rx, cv::BORDER_REPLICATE);
    cv::matchTemplate(padded, pattern, correlation, cv::TM_CCOEFF_NORMED);
    if (is_inverted) correlation = -correlation;
    is_better = correlation > best.correlation;
    correlation.copyTo(best.correlation, is_better);
    best.pattern.setTo(static_cast<int>(i), is_better);
  }
  return best;
}

/// Slope of the picture on the pattern.
double gain_at(const cv::Mat& picture, const cv::Mat& pattern, const cv::Point& at) {
  Regression sums;
  for (int y = 0; y < pattern.rows; ++y) {
    const int py = at.y + y - pattern.rows / 2;
    if (py < 0 || py >= picture.rows) continue;
    for (int x = 0; x < pattern.cols; ++x) {
      const int px = at.x + x - pattern.cols / 2;
      if (px < 0 || px >= picture.cols) continue;
      sums.add(pattern.at<float>(y, x), picture.at<float>(py, px));
    }
  }
  return sums.model_square() > 0 ? sums.gain() : 0;
}

/// Offset of a parabola's top through three values, -0.5 to 0.5.
double top_of(double before, double middle, double after) {
  const double bend = before - 2 * middle + after;
  return bend < 0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0;
}

Eigen::Vector2d refined(const cv::Mat& correlation, const cv::Point& at) {
  Eigen::Vector2d place(at.x, at.y);
  if (at.x > 0 && at.x + 1 < correlation.cols) {
    const float* row = correlation.ptr<float>(at.y) + at.x;
    place.x() += top_of(row[-1], row[0], row[1]);
  }
  if (at.y > 0 && at.y + 1 < correlation.rows) {
    place.y() += top_of(correlation.at<float>(at.y - 1, at.x),
                        correlation.at<float>(at),
                        correlation.at<float>(at.y + 1, at.x));
  }
  return place;
}

}  // namespace

ReducedPicture reduce(const Image& image, const PixelBox& box, int factor) {
  const auto up = [factor](int v) { return (v + factor - 1) / factor * factor; };
  ReducedPicture reduced;
  reduced.factor = factor;
  reduced.x0 = up(box.x0);
  reduced.y0 = up(box.y0);
  const int width = std::max(0, (box.x0 + box.width - reduced.x0) / factor);
  const int height = std::max(0, (box.y0 + box.height - reduced.y0) / factor);
  reduced.image = Image(width, height, image.full_scale());
  if (reduced.image.empty()) return reduced;
  const cv::Mat part =
      pixels_of(image)(cv::Rect(reduced.x0, reduced.y0, width * factor, height * factor));
  cv::Mat target = pixels_of(reduced.image);
  cv::resize(part, target, target.size(), 0, 0, factor == 1 ? cv::INTER_NEAREST : cv::INTER_AREA);
  return reduced;
}

std::vector<PatternPeak> search_patterns(const ReducedPicture& picture,
                                         std::span<const SearchPattern> patterns,
                                         const PatternSearchOptions& options) {
  std::vector<PatternPeak> peaks;
  if (picture.image.empty() || patterns.empty()) return peaks;
  const cv::Mat seen = pixels_of(picture.image);
  const Best best = best_of(seen, patterns, options.is_inverted);
  for (const cv::Point& at : local_maxima(best.correlation, options.min_correlation)) {
    if (peaks.size() >= options.max_peaks) break;
    const Eigen::Vector2d place = refined(best.correlation, at);
    const bool is_new = std::none_of(peaks.begin(), peaks.end(), [&](const PatternPeak& other) {
      return (other.at - place).norm() < options.same_place;
    });
    if (!is_new) continue;
    const auto i = static_cast<std::size_t>(best.pattern.at<int>(at));
    const double gain = gain_at(seen, pixels_of(patterns[i].picture), at);
    if (!(std::abs(gain) >= options.min_gain)) continue;
    peaks.push_back({place, i, best.correlation.at<float>(at), gain});
  }
  return peaks;
}

}  // namespace panelcal::internal
