// SPDX-License-Identifier: Apache-2.0
#include "vision/round/residuals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "vision/fit/regression.h"
#include "vision/fit/turn.h"

namespace panelcal::internal {
namespace {

constexpr double kModelError = 5e-4;        // of the contrast, of edges behind any lens
constexpr double kCircleRounding = 0.2887;  // sigma of rounding to whole levels

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
  const RimBand& band = window.band();
  result.band = band_values(band, p, window.is_ring());
  for (std::size_t i = 0; i < band.size(); ++i) {
    if (band.clipped[i] != 0) continue;
    const std::size_t at = window.index(band.x[i], band.y[i]);
    result.values[at] = band.value[i] - result.band.level[i];
    const RimZone side = result.band.share[i] > 0.5F                          ? RimZone::Target
                         : window.is_ring() && result.band.distance_px[i] > 0 ? RimZone::Hole
                                                                              : RimZone::Outside;
    result.kinds[at] =
        static_cast<std::uint8_t>(RimResiduals::kBand + static_cast<std::uint8_t>(side));
  }
  return result;
}

namespace {

/// Of the residuals of one zone's flat pixels.
struct FlatSquares {
  double n = 0;
  double sum = 0;
};

FlatSquares flat_squares(const RimWindow& window, const RimResiduals& residuals, RimZone zone) {
  FlatSquares squares;
  for (const RimSpan& span : window.spans()) {
    if (span.is_band || span.zone != zone) continue;
    const std::size_t at = window.index(span.x0, span.y);
    const auto count = static_cast<std::size_t>(span.x1 - span.x0);
    const float* const values = residuals.values.data() + at;
    squares.n += static_cast<double>(count);
    squares.sum += sum_of_products(values, values, static_cast<std::ptrdiff_t>(count));
  }
  return squares;
}

/// Residuals of one zone's flat pixels, 0 elsewhere: the rows in which there are any.
std::vector<float> flat_part(const RimWindow& window, const RimResiduals& residuals, RimZone zone) {
  int first = residuals.height;
  int end = 0;
  const auto is_here = [&](const RimSpan& span) { return !span.is_band && span.zone == zone; };
  for (const RimSpan& span : window.spans()) {
    if (!is_here(span)) continue;
    first = std::min(first, span.y);
    end = std::max(end, span.y + 1);
  }
  if (first >= end) return {};
  const auto skipped = static_cast<std::ptrdiff_t>(window.index(0, first));
  std::vector<float> part(window.index(0, end) - window.index(0, first), 0.0F);
  for (const RimSpan& span : window.spans()) {
    if (!is_here(span)) continue;
    const auto at = static_cast<std::ptrdiff_t>(window.index(span.x0, span.y));
    std::copy_n(residuals.values.begin() + at, span.x1 - span.x0, part.begin() + (at - skipped));
  }
  return part;
}

/// Of the products of all pairs that far apart.
double flat_sum_at_lag(const std::vector<float>& part, std::ptrdiff_t lag) {
  const auto count = static_cast<std::ptrdiff_t>(part.size()) - lag;
  return count > 0 ? sum_of_products(part.data(), part.data() + lag, count) : 0;
}

bool is_correlated(const std::vector<float>& part, int width, double n, double variance) {
  constexpr std::array<std::pair<int, int>, 8> kLags = {
      {{1, 0}, {0, 1}, {2, 0}, {0, 2}, {4, 0}, {0, 4}, {3, 3}, {-3, 3}}};
  double statistic = 0;
  for (const auto& [dx, dy] : kLags) {
    const std::ptrdiff_t offset = static_cast<std::ptrdiff_t>(dy) * width + dx;
    const double rho = flat_sum_at_lag(part, offset) / (n * variance);
    statistic += n * rho * rho;
  }
  // Chi square of 8 degrees of freedom: beyond 45 by chance once in 3 million.
  return statistic > 45;
}

}  // namespace

RimNoiseEstimate estimate_noise(const RimWindow& window,
                                const RimResiduals& residuals,
                                double contrast) {
  RimNoiseEstimate result;
  const double least = std::max(kCircleRounding, kModelError * std::abs(contrast));
  const double used = 5;  // parameters that a zone's flat pixels settle
  constexpr double kFewPixels = 60;
  std::array<bool, kRimZones> known{};
  for (std::size_t i = 0; i < kRimZones; ++i) {
    const FlatSquares flat = flat_squares(window, residuals, static_cast<RimZone>(i));
    const double n = flat.n;
    if (n < kFewPixels) continue;
    const double variance = std::max(least * least, flat.sum / (n - used));
    result.total.sigma[i] = std::sqrt(variance);
    known[i] = true;
    const auto part = flat_part(window, residuals, static_cast<RimZone>(i));
    const bool is_textured = is_correlated(part, residuals.width, n, variance);
    result.is_textured = result.is_textured || is_textured;
    if (i != 0) continue;
    result.white = result.total.sigma[i];
    if (!is_textured) continue;
    // A smooth texture's autocovariance goes on to lag 0 as a parabola; the rest is white.
    const auto mean_at = [&](int lag) {
      const std::ptrdiff_t down = static_cast<std::ptrdiff_t>(lag) * residuals.width;
      return (flat_sum_at_lag(part, lag) + flat_sum_at_lag(part, down)) / (2 * n);
    };
    const double texture = (4 * mean_at(1) - mean_at(2)) / 3;
    result.white = std::sqrt(std::clamp(variance - texture, least * least, variance));
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
  const RimBand& band = window.band();
  for (std::size_t i = 0; i < band.size(); ++i) {
    if (band.clipped[i] != 0) continue;
    const double r = static_cast<double>(band.value[i] - residuals.band.level[i]);
    const double share = std::clamp(static_cast<double>(residuals.band.share[i]), 0.0, 1.0);
    const double in = result.total[RimZone::Target];
    const double out = result.total[RimZone::Outside];
    const double variance = share * in * in + (1 - share) * out * out;
    squares += r * r;
    ++n_plain;
    if (variance > 0) chi_square += r * r / variance;
  }
  result.n_band = static_cast<int>(n_plain);
  if (n_plain > 20) {
    result.rim_sigma = std::max(least, std::sqrt(squares / (n_plain - used)));
    result.rim_ratio = chi_square / (n_plain - used);
  }
  for (double& sigma : result.total.sigma) {
    if (!(sigma > 0)) sigma = std::max(kCircleRounding, result.rim_sigma);
  }
  if (!(result.white > 0)) result.white = result.total[RimZone::Outside];
  return result;
}

double visible_share(const RimWindow& window, const RimVector& p) {
  constexpr int kMostSectors = 48;
  constexpr double kSector_px = 4;
  constexpr double kLeast = 0.5;
  constexpr double kMost = 1.6;
  constexpr double kFewPixels = 4;
  const int n_sectors =
      std::clamp(static_cast<int>(2 * std::numbers::pi * p[kRadius] / kSector_px), 4, kMostSectors);
  // Of what is seen on the model's step.
  std::array<Regression, kMostSectors> sectors{};
  const double reach = 3 * p[kSigma] + 1;
  const RimBand& band = window.band();
  const RimBandValues values = band_values(band, p, window.is_ring());
  for (std::size_t i = 0; i < band.size(); ++i) {
    if (std::abs(static_cast<double>(values.distance_px[i])) > reach) continue;
    const double u = static_cast<double>(band.plane_x[i]);
    const double w = static_cast<double>(band.plane_y[i]);
    const double background = p[kLevel] * (1 + u * p[kLightX] + w * p[kLightY]);
    const double turn = turn_of(static_cast<double>(band.at_x[i]) - p[kCenterX],
                                static_cast<double>(band.at_y[i]) - p[kCenterY]);
    Regression& s =
        sectors[static_cast<std::size_t>(turn * n_sectors) % static_cast<std::size_t>(n_sectors)];
    s.add(static_cast<double>(values.level[i]) - background,
          static_cast<double>(band.value[i]) - background);
  }
  int n_seen = 0;
  for (int i = 0; i < n_sectors; ++i) {
    const Regression& s = sectors[static_cast<std::size_t>(i)];
    if (s.n < kFewPixels || !(s.model_square() > 0)) continue;
    const double ratio = s.gain();
    n_seen += ratio > kLeast && ratio < kMost;
  }
  return static_cast<double>(n_seen) / n_sectors;
}

}  // namespace panelcal::internal
