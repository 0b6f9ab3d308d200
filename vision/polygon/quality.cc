// SPDX-License-Identifier: Apache-2.0
#include "vision/polygon/quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "calib/base/statistics/median.h"
#include "vision/fit/regression.h"
#include "vision/polygon/solver.h"
#include <opencv2/imgproc.hpp>

namespace panelcal::internal {
namespace {

// Rounding to whole levels is noise as well, and all there is in a perfect picture.
constexpr double kPolygonRounding = 0.2887;
constexpr int kFewPixels = 20;

/// The model at a pixel, with little work for flat ones.
struct Seen {
  double level = 0;
  double share = 0;
  bool is_near = false;  ///< sees a line
  bool is_known = true;

  std::size_t on_target() const { return share > 0.5 ? 1 : 0; }
};

/// Sigmas of the magnitudes on the ground and on the targets, at least as given; a small lot's is
/// the other's. A face that varies far more than the ground, which may be textured, is not the
/// target's face: that is no reason to bear with it.
std::array<double, 2> polygon_spreads(std::array<std::vector<double>, 2>& magnitudes,
                                      const std::array<double, 2>& least) {
  constexpr std::size_t kFew = 20;
  std::array<double, 2> spreads{};
  for (std::size_t i = 0; i < 2; ++i) {
    auto& lot = magnitudes[i].size() < kFew ? magnitudes[1 - i] : magnitudes[i];
    spreads[i] = std::max(least[i], kSigmasPerMedian * median(lot));
  }
  constexpr double kMostOfGround = 1.5;  // a bright face has more shot noise
  spreads[1] = std::min(spreads[1], kMostOfGround * spreads[0]);
  return spreads;
}

class Eye {
 public:
  Eye(const CellModel& model, const CellState& state)
      : model_(model), state_(state), view_(model, state) {}

  Seen operator()(const CellPixel& pixel) {
    if (pixel.is_flat) {
      const Eigen::Vector3d plane = model_.plane_terms(pixel.at);
      const double level =
          plane.dot(state_.levels.head<3>()) + pixel.share * plane.dot(state_.levels.tail<3>());
      return {level, pixel.share, false, true};
    }
    const auto value = view_.evaluate(pixel, nullptr);
    return {value.level, value.share, !value.is_flat, value.is_known};
  }

 private:
  const CellModel& model_;
  const CellState& state_;
  CellView view_;
};

/// Residuals in sigmas and in grey levels as a picture, and what is found strange in it.
class ResidualMap {
 public:
  explicit ResidualMap(const std::vector<CellPixel>& pixels) : box_(box_of(pixels)) {
    values_ = cv::Mat::zeros(box_.height, box_.width, CV_32FC3);
    marks_ = cv::Mat::zeros(box_.height, box_.width, CV_8U);
  }

  struct Sum {
    double z = 0;
    double residual = 0;
    double n = 0;
  };

  void set(const CellPixel& pixel, double z, double residual) {
    values_.at<cv::Vec3f>(place(pixel)) = {
        static_cast<float>(z), static_cast<float>(residual), 1.0F};
  }
  /// Sums over the square of 2 half + 1 pixels about every pixel.
  void add_up(int half) {
    cv::boxFilter(values_, sums_, CV_32F, square(half), {-1, -1}, false, cv::BORDER_CONSTANT);
  }
  Sum around(const CellPixel& pixel) const {
    const auto& sum = sums_.at<cv::Vec3f>(place(pixel));
    return {sum[0], sum[1], std::round(sum[2])};
  }
  void mark(const CellPixel& pixel) { marks_.at<std::uint8_t>(place(pixel)) = 1; }
  void grow_marks(int reach) {
    cv::dilate(marks_, marks_, cv::getStructuringElement(cv::MORPH_RECT, square(reach)));
  }
  bool is_marked(const CellPixel& pixel) const {
    return marks_.at<std::uint8_t>(place(pixel)) != 0;
  }

 private:
  static cv::Size square(int half) { return {2 * half + 1, 2 * half + 1}; }
  cv::Point place(const CellPixel& pixel) const { return {pixel.x - box_.x0, pixel.y - box_.y0}; }

  PixelBox box_;
  cv::Mat values_;  ///< z, residual, 1
  cv::Mat sums_;
  cv::Mat marks_;
};

}  // namespace

PixelBox box_of(const std::vector<CellPixel>& pixels) {
  if (pixels.empty()) return {};
  const auto [x0, x1] = std::ranges::minmax(pixels, {}, &CellPixel::x);
  const auto [y0, y1] = std::ranges::minmax(pixels, {}, &CellPixel::y);
  return {x0.x, y0.y, x1.x - x0.x + 1, y1.y - y0.y + 1};
}

CellNoise noise_of(const CellModel& model,
                   const std::vector<CellPixel>& pixels,
                   const CellState& state,
                   double full_scale) {
  double sums[2] = {0, 0};
  int counts[2] = {0, 0};
  double rim_square = 0;
  double rim_chi_square = 0;
  int n_rim = 0;
  Eye eye(model, state);
  for (const CellPixel& pixel : pixels) {
    if (pixel.is_excluded) continue;
    const Seen seen = eye(pixel);
    if (!seen.is_known || is_beyond_scale(pixel.value, seen.level, full_scale)) continue;
    const double residual = pixel.value - seen.level;
    const std::size_t side = seen.share > 0.5 ? 1 : 0;
    sums[side] += residual * residual;
    ++counts[side];
    if (seen.is_near && seen.share > 0.02 && seen.share < 0.98) {
      rim_square += residual * residual;
      rim_chi_square += residual * residual * pixel.weight;
      ++n_rim;
    }
  }
  // Half of the parameters each.
  const double used = 0.5 * model.n_parameters();
  const auto sigma = [&](std::size_t side) {
    return std::max(kPolygonRounding, std::sqrt(sums[side] / std::max(1.0, counts[side] - used)));
  };
  CellNoise noise;
  noise.outside = sigma(0);
  noise.inside = sigma(1);
  if (counts[1] < kFewPixels) noise.inside = noise.outside;
  if (counts[0] < kFewPixels) noise.outside = noise.inside;
  if (n_rim > 0) {
    noise.rim = std::sqrt(rim_square / n_rim);
    const double ratio = rim_chi_square / n_rim;
    // Three standard deviations of a chi square over its degrees of freedom.
    if (ratio > 1 + 3 * std::sqrt(2.0 / n_rim)) noise.rim_excess = ratio;
  }
  return noise;
}

void set_weights(const CellModel& model,
                 const CellState& state,
                 const CellNoise& noise,
                 std::vector<CellPixel>& pixels) {
  const double inside = noise.inside * noise.inside;
  const double outside = noise.outside * noise.outside;
  Eye eye(model, state);
  for (CellPixel& pixel : pixels) {
    const double share = std::clamp(eye(pixel).share, 0.0, 1.0);
    pixel.weight = 1 / (share * inside + (1 - share) * outside);
  }
}

double exclude_strangers(const CellModel& model,
                         const CellState& state,
                         double full_scale,
                         std::vector<CellPixel>& pixels) {
  constexpr double kSigmas = 6;            // of a pixel
  constexpr double kBlobSigmas = 5;        // of a square's mean
  constexpr double kOfContrast = 0.15;     // less than this is no debris
  constexpr double kRimOfContrast = 0.35;  // an edge that is not quite straight is not cut away
  constexpr double kBlobOfContrast = 0.06;
  constexpr double kRimBlobOfContrast = 0.12;
  constexpr double kMarkOfContrast = 0.45;
  constexpr int kBlobHalf = 2;        // px
  constexpr std::size_t kSample = 5;  // medians are taken of every n-th pixel
  constexpr int kGrow = 2;            // px: the blurred foot of what was excluded

  ResidualMap map(pixels);
  std::vector<Seen> seen(pixels.size());
  Eye eye(model, state);
  // Ground may be textured, targets are not: each has its own spread. Index 1: on a target.
  std::array<std::vector<double>, 2> magnitudes;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const CellPixel& pixel = pixels[i];
    seen[i] = eye(pixel);
    if (!seen[i].is_known || is_beyond_scale(pixel.value, seen[i].level, full_scale)) continue;
    const double residual = pixel.value - seen[i].level;
    const double z = residual * std::sqrt(pixel.weight);
    map.set(pixel, z, residual);
    if (i % kSample == 0) magnitudes[seen[i].on_target()].push_back(std::abs(z));
  }
  map.add_up(kBlobHalf);
  const std::array z_sigma = polygon_spreads(magnitudes, {0.3, 0.3});
  // Texture is correlated: its local means vary more than those of white noise.
  magnitudes = {};
  for (std::size_t i = 0; i < pixels.size(); i += kSample) {
    const auto sum = map.around(pixels[i]);
    if (sum.n > 0) magnitudes[seen[i].on_target()].push_back(std::abs(sum.z) / std::sqrt(sum.n));
  }
  const std::array blob_sigma = polygon_spreads(magnitudes, z_sigma);

  const double contrast = std::abs(state.levels[3]);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const CellPixel& pixel = pixels[i];
    const Seen& at = seen[i];
    if (!at.is_known) continue;
    const bool is_rim = at.share > 0.01 && at.share < 0.99;
    if (!is_beyond_scale(pixel.value, at.level, full_scale)) {
      const double residual = std::abs(pixel.value - at.level);
      const double limit = (is_rim ? kRimOfContrast : kOfContrast) * contrast;
      if (residual > limit &&
          residual * std::sqrt(pixel.weight) > kSigmas * z_sigma[at.on_target()]) {
        map.mark(pixel);
        continue;
      }
    }
    const auto sum = map.around(pixel);
    if (sum.n < 1) continue;
    const double limit = (is_rim ? kRimBlobOfContrast : kBlobOfContrast) * contrast;
    // Whatever the texture: what stands out as far as half the target does is another mark.
    const bool is_mark =
        at.share < 0.01 && std::abs(sum.residual) > kMarkOfContrast * contrast * sum.n;
    const double sigma = is_mark ? z_sigma[at.on_target()] : blob_sigma[at.on_target()];
    if (std::abs(sum.residual) > limit * sum.n &&
        std::abs(sum.z) > kBlobSigmas * sigma * std::sqrt(sum.n)) {
      map.mark(pixel);
    }
  }
  map.grow_marks(kGrow);
  int n_rim = 0;
  int n_excluded = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    pixels[i].is_excluded = map.is_marked(pixels[i]);
    if (!seen[i].is_near) continue;
    ++n_rim;
    n_excluded += pixels[i].is_excluded;
  }
  return n_rim > 0 ? static_cast<double>(n_excluded) / n_rim : 1;
}

double correlation_near(const CellModel& model,
                        const CellState& state,
                        const std::vector<CellPixel>& pixels,
                        double white_noise,
                        double reach_px) {
  Regression sums;
  CellState sharp = state;
  sharp.sigma_px = 1e-3;
  CellView lines(model, sharp);
  Eye eye(model, state);
  for (const CellPixel& pixel : pixels) {
    if (pixel.is_excluded || lines.flat_share(pixel, reach_px)) continue;
    const Seen seen = eye(pixel);
    if (!seen.is_known) continue;
    const double plane = model.plane_terms(pixel.at).dot(state.levels.head<3>());
    sums.add(seen.level - plane, pixel.value - plane);
  }
  return sums.correlation(white_noise * white_noise);
}

double intact_part(const CellModel& model,
                   const CellState& state,
                   const std::vector<CellPixel>& pixels) {
  Eye eye(model, state);
  int n = 0;
  int n_excluded = 0;
  for (const CellPixel& pixel : pixels) {
    const Seen seen = eye(pixel);
    if (!seen.is_known || seen.share < 0.5) continue;
    ++n;
    n_excluded += pixel.is_excluded;
  }
  return n > 0 ? 1 - static_cast<double>(n_excluded) / n : 0;
}

}  // namespace panelcal::internal
