// SPDX-License-Identifier: Apache-2.0
#include "vision/round/strangers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "calib/base/statistics/median.h"

namespace panelcal::internal {
namespace {

constexpr int kBox = 5;                  // px: strangers are at least about as large
constexpr double kSeedSigmas = 5.5;      // of the box mean: by chance once in 10 million
constexpr double kPixelSigmas = 8;       // of one pixel
constexpr double kRimOfContrast = 0.12;  // of the box mean; a rim that is not quite round stays
constexpr double kFlatOfContrast = 0.03;
constexpr double kMarkOfContrast = 0.45;

/// Limits of strange pixels, by kind of pixel.
struct StrangeLimits {
  std::array<float, 16> scale{};      ///< 1 / sigma of a pixel
  std::array<float, 16> per_box{};    ///< 1 / limit of a box sum over kBox
  std::array<float, 16> per_pixel{};  ///< 1 / limit of a pixel over its sigma
};

/// Residuals over their sigmas and their sums over boxes, row by row.
class BoxRows {
 public:
  BoxRows(const RimResiduals& residuals, const StrangeLimits& limits)
      : residuals_(residuals),
        limits_(limits),
        width_(residuals.width),
        z_(Eigen::ArrayXXf::Zero(width_ + 2 * kHalf, kBox)),
        sums_(Eigen::ArrayXXf::Zero(width_, kBox)),
        box_(width_) {}

  /// Precondition: rows are asked for one after another, from 0.
  void go_to(int y) {
    while (next_ <= y + kHalf) take(next_++);
    box_ = sums_.col(0);
    for (int i = 1; i < kBox; ++i) box_ += sums_.col(i);
    box_ *= 1.0F / kBox;  // the sum of k^2 pixels has k times their sigma
    y_ = y;
  }
  /// Of the row gone to.
  const Eigen::ArrayXf& box() const { return box_; }
  const float* z() const { return z_.col(y_ % kBox).data() + kHalf; }
  /// Excess of a pixel over its limit.
  float excess(int x) const {
    const std::uint8_t kind = kinds(y_)[x];
    return std::max(std::abs(box_[x]) * limits_.per_box[kind],
                    std::abs(z()[x]) * limits_.per_pixel[kind]);
  }

 private:
  static constexpr int kHalf = kBox / 2;

  const std::uint8_t* kinds(int y) const {
    return residuals_.kinds.data() + static_cast<std::ptrdiff_t>(y) * width_;
  }

  void take(int y) {
    auto z = z_.col(y % kBox);
    auto sums = sums_.col(y % kBox);
    z.setZero();
    sums.setZero();
    if (y >= residuals_.height) return;
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(y) * width_;
    const float* const values = residuals_.values.data() + first;
    const std::uint8_t* const kind = kinds(y);
    for (int x = 0; x < width_; ++x) z[kHalf + x] = values[x] * limits_.scale[kind[x]];
    for (int i = 0; i < kBox; ++i) sums += z.segment(i, width_);
  }

  const RimResiduals& residuals_;
  const StrangeLimits& limits_;
  Eigen::Index width_;
  Eigen::ArrayXXf z_;     ///< the last kBox rows, with borders of 0
  Eigen::ArrayXXf sums_;  ///< of kBox neighbours in these rows
  Eigen::ArrayXf box_;
  int next_ = 0;
  int y_ = 0;
};

/// Factor by which texture makes box means larger than chance outside of the target, and in its
/// hole.
std::array<double, kRimZones> zone_spreads(const RimResiduals& residuals,
                                           const StrangeLimits& limits) {
  BoxRows rows(residuals, limits);
  std::array<std::vector<float>, kRimZones> magnitudes;
  for (int y = 0; y < residuals.height; ++y) {
    rows.go_to(y);
    const std::size_t first =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(residuals.width);
    for (int x = 0; x < residuals.width; ++x) {
      const std::size_t i = first + static_cast<std::size_t>(x);
      if (i % 3 != 0) continue;
      for (const std::size_t zone : {std::size_t{0}, std::size_t{2}}) {
        if (residuals.kinds[i] != RimResiduals::kZone + zone) continue;
        magnitudes[zone].push_back(std::abs(rows.box()[x]));
      }
    }
  }
  std::array<double, kRimZones> spreads = {1, 1, 1};
  for (const std::size_t zone : {std::size_t{0}, std::size_t{2}}) {
    spreads[zone] = std::max(1.0, kSigmasPerMedian * median(std::move(magnitudes[zone])));
  }
  return spreads;
}

StrangeLimits strange_limits(const RimResiduals& residuals,
                             const RimNoiseEstimate& noise,
                             double contrast) {
  StrangeLimits limits;
  for (std::size_t i = 0; i < kRimZones; ++i) {
    // The white part is what a box averages away; texture is judged by its own spread below.
    const double sigma = i == 0 && noise.is_textured ? noise.white : noise.total.sigma[i];
    limits.scale[RimResiduals::kZone + i] = static_cast<float>(1 / sigma);
    limits.scale[RimResiduals::kBand + i] = limits.scale[RimResiduals::kZone + i];
  }
  std::array<double, kRimZones> spreads = {1, 1, 1};
  if (noise.is_textured) spreads = zone_spreads(residuals, limits);
  for (const std::size_t base : {RimResiduals::kZone, RimResiduals::kBand}) {
    for (std::size_t zone = 0; zone < kRimZones; ++zone) {
      const std::size_t kind = base + zone;
      const double per_level = static_cast<double>(limits.scale[kind]) * kBox;
      const double of_contrast = base == RimResiduals::kBand ? kRimOfContrast : kFlatOfContrast;
      double limit = std::max(kSeedSigmas, of_contrast * contrast * per_level);
      if (zone != 1) {
        // Whatever the texture: what stands out as far as half the target does is another mark.
        const double mark = kMarkOfContrast * contrast * per_level;
        limit = std::max(limit, std::min(kSeedSigmas * spreads[zone], mark));
      }
      limits.per_box[kind] = static_cast<float>(1 / limit);
      limits.per_pixel[kind] =
          static_cast<float>(1 / std::max(kPixelSigmas, limit * (kPixelSigmas / kSeedSigmas)));
    }
  }
  return limits;
}

/// The largest excess of any pixel.
double largest_excess(const RimWindow& window,
                      const RimResiduals& residuals,
                      const StrangeLimits& limits) {
  BoxRows rows(residuals, limits);
  float largest = 0;
  for (int y = 0, i = 0; y < residuals.height; ++y) {
    rows.go_to(y);
    const auto n_spans = static_cast<int>(window.spans().size());
    for (; i < n_spans && window.spans()[static_cast<std::size_t>(i)].y == y; ++i) {
      const RimSpan& span = window.spans()[static_cast<std::size_t>(i)];
      if (span.is_band) {
        for (int x = span.x0; x < span.x1; ++x) largest = std::max(largest, rows.excess(x));
        continue;
      }
      const std::size_t kind = residuals.kinds[window.index(span.x0, y)];
      const Eigen::Index n = span.x1 - span.x0;
      const Eigen::Map<const Eigen::ArrayXf> z(rows.z() + span.x0, n);
      largest = std::max({largest,
                          rows.box().segment(span.x0, n).abs().maxCoeff() * limits.per_box[kind],
                          z.abs().maxCoeff() * limits.per_pixel[kind]});
    }
  }
  return static_cast<double>(largest);
}

}  // namespace

bool has_strangers(const RimWindow& window,
                   const RimResiduals& residuals,
                   const RimNoiseEstimate& noise,
                   const RimVector& p) {
  const StrangeLimits limits = strange_limits(residuals, noise, std::abs(p[kContrast]));
  return largest_excess(window, residuals, limits) >= 1;
}

}  // namespace panelcal::internal
