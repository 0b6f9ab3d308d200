// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/rim_residuals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace panelcal::internal {
namespace {

constexpr double kRounding = 0.2887;  // sigma of rounding to whole levels

double sum_of_products(const float* a, const float* b, std::ptrdiff_t n) {
  const Eigen::Map<const Eigen::ArrayXf> left(a, n);
  const Eigen::Map<const Eigen::ArrayXf> right(b, n);
  return static_cast<double>((left * right).sum());
}

}  // namespace

RimResiduals residuals_of(const RimWindow& window, const RimVector& p) {
  RimResiduals result;
  result.width = window.width();
  result.height = window.height();
  const auto n = static_cast<std::size_t>(result.width) * static_cast<std::size_t>(result.height);
  result.values.assign(n, 0.0F);
  result.kinds.assign(n, RimResiduals::kNowhere);
  const Eigen::ArrayXf ramp =
      Eigen::ArrayXf::LinSpaced(result.width, 0.0F, static_cast<float>(result.width - 1));
  const float step = static_cast<float>(1 / window.unit_px());
  for (const RimSpan& span : window.spans()) {
    if (span.is_band) continue;
    const Eigen::Vector3d level = zone_level(p, span.zone);
    const Eigen::Vector2d first = window.plane_at(span.x0, span.y);
    const auto start = static_cast<float>(level[0] + level[1] * first.x() + level[2] * first.y());
    const auto slope = static_cast<float>(level[1]) * step;
    const Eigen::Index count = span.x1 - span.x0;
    const std::size_t at = window.index(span.x0, span.y);
    const Eigen::Map<const Eigen::ArrayXf> seen(window.row(span.y) + span.x0, count);
    Eigen::Map<Eigen::ArrayXf>(result.values.data() + at, count) =
        seen - start - slope * ramp.head(count);
    const auto kind =
        static_cast<std::uint8_t>(RimResiduals::kZone + static_cast<std::uint8_t>(span.zone));
    std::fill_n(result.kinds.begin() + static_cast<std::ptrdiff_t>(at), count, kind);
  }
  for (const RimPixel& pixel : window.band()) {
    const RimValue value = rim_value(pixel, p, window.is_ring(), nullptr);
    if (pixel.clipped != 0) continue;
    const std::size_t at = window.index(pixel.x, pixel.y);
    result.values[at] = pixel.value - static_cast<float>(value.level);
    const RimZone side = value.share > 0.5                           ? RimZone::Target
                         : window.is_ring() && value.distance_px > 0 ? RimZone::Hole
                                                                     : RimZone::Outside;
    result.kinds[at] =
        static_cast<std::uint8_t>(RimResiduals::kBand + static_cast<std::uint8_t>(side));
  }
  return result;
}

namespace {

/// Residuals of one zone's flat pixels, 0 elsewhere.
std::vector<float> flat_part(const RimWindow& window,
                             const RimResiduals& residuals,
                             RimZone zone,
                             double& n) {
  std::vector<float> part(residuals.values.size(), 0.0F);
  n = 0;
  for (const RimSpan& span : window.spans()) {
    if (span.is_band || span.zone != zone) continue;
    const std::size_t at = window.index(span.x0, span.y);
    const auto count = static_cast<std::size_t>(span.x1 - span.x0);
    std::copy_n(residuals.values.begin() + static_cast<std::ptrdiff_t>(at),
                count,
                part.begin() + static_cast<std::ptrdiff_t>(at));
    n += static_cast<double>(count);
    if (window.excluded().empty()) continue;
    for (std::size_t i = at; i < at + count; ++i) {
      if (window.excluded()[i] == 0) continue;
      part[i] = 0;
      --n;
    }
  }
  return part;
}

bool is_correlated(const std::vector<float>& part, int width, double n, double variance) {
  constexpr std::array<std::pair<int, int>, 8> kLags = {
      {{1, 0}, {0, 1}, {2, 0}, {0, 2}, {4, 0}, {0, 4}, {3, 3}, {-3, 3}}};
  double statistic = 0;
  for (const auto& [dx, dy] : kLags) {
    const std::ptrdiff_t offset = static_cast<std::ptrdiff_t>(dy) * width + dx;
    const auto count = static_cast<std::ptrdiff_t>(part.size()) - offset;
    if (count <= 0) return false;
    const double rho = sum_of_products(part.data(), part.data() + offset, count) / (n * variance);
    statistic += n * rho * rho;
  }
  // Chi square of 8 degrees of freedom: beyond 45 by chance once in 3 million.
  return statistic > 45;
}

}  // namespace

RimNoiseEstimate estimate_noise(const RimWindow& window,
                                const RimVector& p,
                                const RimResiduals& residuals) {
  RimNoiseEstimate result;
  const double used = 5;  // parameters that a zone's flat pixels settle
  constexpr double kFewPixels = 60;
  std::array<bool, kRimZones> known{};
  for (std::size_t i = 0; i < kRimZones; ++i) {
    double n = 0;
    const auto part = flat_part(window, residuals, static_cast<RimZone>(i), n);
    if (n < kFewPixels) continue;
    const auto count = static_cast<std::ptrdiff_t>(part.size());
    const double squares = sum_of_products(part.data(), part.data(), count);
    const double variance = std::max(kRounding * kRounding, squares / (n - used));
    result.total.sigma[i] = std::sqrt(variance);
    known[i] = true;
    if (i != 0) continue;
    result.is_textured = is_correlated(part, residuals.width, n, variance);
    result.white = result.total.sigma[i];
    if (!result.is_textured) continue;
    // A smooth texture's autocovariance goes on to lag 0 as a parabola; the rest is white.
    const auto mean_at = [&](int lag) {
      const std::ptrdiff_t down = static_cast<std::ptrdiff_t>(lag) * residuals.width;
      return (sum_of_products(part.data(), part.data() + lag, count - lag) +
              sum_of_products(part.data(), part.data() + down, count - down)) /
             (2 * n);
    };
    const double texture = (4 * mean_at(1) - mean_at(2)) / 3;
    result.white = std::sqrt(std::clamp(variance - texture, kRounding * kRounding, variance));
  }
  // A zone without flat pixels of its own is taken to be like another.
  for (std::size_t i = 0; i < kRimZones; ++i) {
    if (known[i]) continue;
    const std::size_t other = known[1] ? 1 : known[0] ? 0 : known[2] ? 2 : i;
    result.total.sigma[i] = known[other] ? result.total.sigma[other] : 0;
  }
  double chi_square = 0;
  double squares = 0;
  double n_plain = 0;
  for (const RimPixel& pixel : window.band()) {
    if (pixel.clipped != 0 || window.is_excluded(pixel.x, pixel.y)) continue;
    const RimValue value = rim_value(pixel, p, window.is_ring(), nullptr);
    const double r = static_cast<double>(pixel.value) - value.level;
    const double share = std::clamp(value.share, 0.0, 1.0);
    const double in = result.total[RimZone::Target];
    const double out = result.total[RimZone::Outside];
    const double variance = share * in * in + (1 - share) * out * out;
    squares += r * r;
    ++n_plain;
    if (variance > 0) chi_square += r * r / variance;
  }
  result.n_band = static_cast<int>(n_plain);
  if (n_plain > 20) {
    result.rim_sigma = std::max(kRounding, std::sqrt(squares / (n_plain - used)));
    result.rim_ratio = chi_square / (n_plain - used);
  }
  for (double& sigma : result.total.sigma) {
    if (!(sigma > 0)) sigma = std::max(kRounding, result.rim_sigma);
  }
  if (!(result.white > 0)) result.white = result.total[RimZone::Outside];
  return result;
}

namespace {

constexpr int kBox = 5;              // px: strangers are at least about as large
constexpr double kSeedSigmas = 5.5;  // of the box mean: by chance once in 10 million
constexpr double kPixelSigmas = 8;   // of one pixel
constexpr double kGrowSigmas = 2.5;
constexpr double kRimOfContrast = 0.12;  // of the box mean; a rim that is not quite round stays
constexpr double kFlatOfContrast = 0.03;
constexpr double kMarkOfContrast = 0.45;
constexpr double kGrowBlurs = 1.2;  // the blurred foot of what was excluded, sigmas

double median_magnitude(std::vector<float>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

}  // namespace

bool exclude_strangers(RimWindow& window,
                       const RimResiduals& residuals,
                       const RimNoiseEstimate& noise,
                       const RimVector& p) {
  const double contrast = p[kContrast];
  const int width = residuals.width;
  const int height = residuals.height;
  cv::Mat z(height, width, CV_32F, cv::Scalar(0));
  const double flat_limit = kFlatOfContrast * std::abs(contrast);
  const double rim_limit = kRimOfContrast * std::abs(contrast);
  std::array<float, 16> scale{};
  for (std::size_t i = 0; i < kRimZones; ++i) {
    // The white part is what a box averages away; texture is judged by its own spread below.
    const double sigma = i == 0 && noise.is_textured ? noise.white : noise.total.sigma[i];
    scale[RimResiduals::kZone + i] = static_cast<float>(1 / sigma);
    scale[RimResiduals::kBand + i] = scale[RimResiduals::kZone + i];
  }
  float* const zs = z.ptr<float>();
  for (std::size_t i = 0; i < residuals.values.size(); ++i) {
    zs[i] = residuals.values[i] * scale[residuals.kinds[i]];
    if (!window.excluded().empty() && window.excluded()[i] != 0) zs[i] = 0;
  }
  cv::Mat box;
  cv::boxFilter(z, box, -1, {kBox, kBox}, {-1, -1}, true, cv::BORDER_CONSTANT);
  // The mean of k^2 pixels has a k-th of their sigma.
  box *= kBox;

  // Texture makes box means larger than chance outside of the target.
  double outside_spread = 1;
  if (noise.is_textured) {
    std::vector<float> magnitudes;
    const float* const b = box.ptr<float>();
    for (std::size_t i = 0; i < residuals.kinds.size(); i += 3) {
      if (residuals.kinds[i] == RimResiduals::kZone) magnitudes.push_back(std::abs(b[i]));
    }
    outside_spread = std::max(1.0, 1.4826 * median_magnitude(magnitudes));
  }
  cv::Mat strange(height, width, CV_8U, cv::Scalar(0));
  double largest = 0;
  // By kind of pixel: of a box mean, and of one pixel.
  std::array<float, 16> box_limit{};
  std::array<float, 16> pixel_limit{};
  for (const std::size_t base : {RimResiduals::kZone, RimResiduals::kBand}) {
    for (std::size_t zone = 0; zone < kRimZones; ++zone) {
      const std::size_t kind = base + zone;
      const double per_level = static_cast<double>(scale[kind]) * kBox;
      double limit =
          std::max(kSeedSigmas, (base == RimResiduals::kBand ? rim_limit : flat_limit) * per_level);
      if (zone == 0) {
        // Whatever the texture: what stands out as far as half the target does is another mark.
        const double mark = kMarkOfContrast * std::abs(contrast) * per_level;
        limit = std::max(limit, std::min(kSeedSigmas * outside_spread, mark));
      }
      box_limit[kind] = static_cast<float>(1 / limit);
      pixel_limit[kind] =
          static_cast<float>(1 / std::max(kPixelSigmas, limit * (kPixelSigmas / kSeedSigmas)));
    }
  }
  const float* const b = box.ptr<float>();
  for (std::size_t i = 0; i < residuals.kinds.size(); ++i) {
    const std::uint8_t kind = residuals.kinds[i];
    const float excess =
        std::max(std::abs(b[i]) * box_limit[kind], std::abs(zs[i]) * pixel_limit[kind]);
    largest = std::max(largest, static_cast<double>(excess));
    strange.data[i] = static_cast<std::uint8_t>(std::min(250.0F, 50 * excess));
  }
  // What hangs together with what is already out is its foot.
  if (!window.excluded().empty()) {
    for (std::size_t i = 0; i < residuals.kinds.size(); ++i) {
      if (window.excluded()[i] != 0) strange.data[i] = 250;
    }
  }
  if (largest < kGrowSigmas / kSeedSigmas) return false;

  // Large strangers spoil the fit around them, so that what is small beside them waits for the next
  // fit.
  const double seed = std::max(1.0, 0.4 * std::min(largest, 5.0));
  const double foot = seed * kGrowSigmas / kSeedSigmas;
  cv::Mat candidates = strange >= 50 * foot;
  cv::Mat labels;
  const int n_labels = cv::connectedComponents(candidates, labels, 8, CV_32S);
  std::vector<char> is_seeded(static_cast<std::size_t>(n_labels), 0);
  const int* const label = labels.ptr<int>();
  for (std::size_t i = 0; i < residuals.kinds.size(); ++i) {
    if (strange.data[i] >= 50 * seed) is_seeded[static_cast<std::size_t>(label[i])] = 1;
  }
  is_seeded[0] = 0;
  cv::Mat mask(height, width, CV_8U, cv::Scalar(0));
  for (std::size_t i = 0; i < residuals.kinds.size(); ++i) {
    mask.data[i] = is_seeded[static_cast<std::size_t>(label[i])] != 0 ? 1 : 0;
  }
  std::vector<std::uint8_t>& excluded = window.excluded();
  const bool is_first = excluded.empty();
  if (is_first) excluded.assign(residuals.kinds.size(), 0);
  for (std::size_t i = 0; i < residuals.kinds.size(); ++i) {
    if (excluded[i] != 0) mask.data[i] = 0;
  }
  // Later ones are feet themselves.
  const int grow_px =
      is_first ? std::clamp(static_cast<int>(std::lround(kGrowBlurs * p[kSigma])), 2, 6) : 1;
  const cv::Size kernel(2 * grow_px + 1, 2 * grow_px + 1);
  cv::dilate(mask, mask, cv::getStructuringElement(cv::MORPH_ELLIPSE, kernel));
  bool is_new = false;
  for (std::size_t i = 0; i < residuals.kinds.size(); ++i) {
    if (mask.data[i] == 0 || excluded[i] != 0) continue;
    excluded[i] = 1;
    is_new = true;
  }
  return is_new;
}

double excluded_share(const RimWindow& window) {
  if (window.excluded().empty()) return 0;
  double n = 0;
  double n_excluded = 0;
  for (const RimSpan& span : window.spans()) {
    n += span.x1 - span.x0;
    for (int x = span.x0; x < span.x1; ++x) n_excluded += window.is_excluded(x, span.y);
  }
  return n > 0 ? n_excluded / n : 0;
}

double visible_share(const RimWindow& window, const RimVector& p) {
  constexpr int kMostSectors = 48;
  constexpr double kSector_px = 4;
  constexpr double kLeast = 0.5;
  constexpr double kMost = 1.6;
  constexpr double kFewPixels = 4;
  /// Regression of what is seen on the model's step, about the sector's mean.
  struct Sector {
    double n = 0, m = 0, v = 0, mm = 0, mv = 0;
  };
  const int n_sectors =
      std::clamp(static_cast<int>(2 * std::numbers::pi * p[kRadius] / kSector_px), 4, kMostSectors);
  std::array<Sector, kMostSectors> sectors{};
  const double reach = 3 * p[kSigma] + 1;
  for (const RimPixel& pixel : window.band()) {
    const RimValue value = rim_value(pixel, p, window.is_ring(), nullptr);
    if (std::abs(value.distance_px) > reach) continue;
    const double u = static_cast<double>(pixel.plane.x());
    const double w = static_cast<double>(pixel.plane.y());
    const double background = p[kLevel] * (1 + u * p[kLightX] + w * p[kLightY]);
    const double angle = std::atan2(static_cast<double>(pixel.at.y()) - p[kCenterY],
                                    static_cast<double>(pixel.at.x()) - p[kCenterX]);
    const auto turn = (angle / std::numbers::pi + 1) / 2;
    Sector& s =
        sectors[static_cast<std::size_t>(turn * n_sectors) % static_cast<std::size_t>(n_sectors)];
    const double m = value.level - background;
    const double v = static_cast<double>(pixel.value) - background;
    ++s.n;
    s.m += m;
    s.v += v;
    s.mm += m * m;
    s.mv += m * v;
  }
  int n_seen = 0;
  for (int i = 0; i < n_sectors; ++i) {
    const Sector& s = sectors[static_cast<std::size_t>(i)];
    const double spread = s.mm - s.m * s.m / std::max(1.0, s.n);
    if (s.n < kFewPixels || !(spread > 0)) continue;
    const double ratio = (s.mv - s.m * s.v / s.n) / spread;
    n_seen += ratio > kLeast && ratio < kMost;
  }
  return static_cast<double>(n_seen) / n_sectors;
}

RimRoughness rim_roughness(const RimWindow& window, const RimVector& p, const RimNoise& noise) {
  constexpr int kSectors = 48;
  constexpr double kKept = 0.8;
  constexpr std::size_t kFewSectors = 12;
  struct Sector {
    double slope = 0, curvature = 0;
  };
  std::array<Sector, kSectors> sectors{};
  RimGradient gradient{};
  for (const RimPixel& pixel : window.band()) {
    if (pixel.clipped != 0) continue;
    const RimValue value = rim_value(pixel, p, window.is_ring(), &gradient);
    if (std::abs(value.distance_px) > 4 * p[kSigma]) continue;
    const double share = std::clamp(value.share, 0.0, 1.0);
    const double in = noise[RimZone::Target];
    const double out = noise[RimZone::Outside];
    const double weight = 1 / (share * in * in + (1 - share) * out * out);
    const double angle = std::atan2(static_cast<double>(pixel.at.y()) - p[kCenterY],
                                    static_cast<double>(pixel.at.x()) - p[kCenterX]);
    Sector& s =
        sectors[static_cast<std::size_t>((angle / std::numbers::pi + 1) / 2 * kSectors) % kSectors];
    const double g = gradient[kRadius];
    s.slope += weight * g * (static_cast<double>(pixel.value) - value.level);
    s.curvature += weight * g * g;
  }
  // Squared deviations and what noise makes of them.
  std::vector<std::pair<double, double>> squares;
  for (const Sector& s : sectors) {
    if (!(s.curvature > 0)) continue;
    const double deviation = s.slope / s.curvature;
    squares.emplace_back(deviation * deviation, 1 / s.curvature);
  }
  if (squares.size() < kFewSectors) return {};
  std::sort(squares.begin(), squares.end());
  squares.resize(static_cast<std::size_t>(kKept * static_cast<double>(squares.size())));
  double seen = 0;
  double by_chance = 0;
  for (const auto& [square, variance] : squares) {
    seen += square;
    by_chance += variance;
  }
  const auto n = static_cast<double>(squares.size());
  // The smaller four fifths of squared normal numbers have a mean of 0.47 and a spread of 0.45.
  constexpr double kTrimmedMean = 0.47;
  constexpr double kTrimmedSpread = 0.45;
  RimRoughness result;
  result.rms_px = std::sqrt(std::max(0.0, seen - kTrimmedMean * by_chance) / n);
  result.significance = (seen / by_chance - kTrimmedMean) * std::sqrt(n) / kTrimmedSpread;
  return result;
}

double covered_share(const RimWindow& window, const RimVector& p) {
  constexpr double kInner = 0.7;
  if (window.excluded().empty()) return 0;
  const double limit = kInner * p[kRadius] / window.unit_px();
  double n = 0;
  double n_excluded = 0;
  for (const RimSpan& span : window.spans()) {
    // A clipped zone is taken pixel by pixel, as a band is.
    if (window.is_ring() && (span.is_band || span.zone != RimZone::Target)) continue;
    for (int x = span.x0; x < span.x1; ++x) {
      if (window.plane_at(x, span.y).norm() > limit) continue;
      ++n;
      n_excluded += window.is_excluded(x, span.y);
    }
  }
  return n > 0 ? n_excluded / n : 0;
}

}  // namespace panelcal::internal
