// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/strip.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/fit/turn.h"

namespace panelcal::internal {
namespace {

constexpr double kSectorArc_px = 2;
constexpr double kMinSectors = 24;
constexpr double kMaxSectors = 256;
constexpr double kOtherEdge = 0.25;  // of an edge's slope: where it rises by more, another begins

Eigen::Index sectors_of(double radius_px) {
  return static_cast<Eigen::Index>(
      std::clamp(2 * std::numbers::pi * radius_px / kSectorArc_px, kMinSectors, kMaxSectors));
}

/// Fit frame units per px across the rim, on average over the band.
double units_per_px(const RimBand& band, const RimVector& p, const std::vector<float>& distance) {
  if (!band.has_jacobian) return 1;
  double units = 0;
  double px = 0;
  for (std::size_t i = 0; i < band.size(); i += 7) {
    const double r = std::hypot(static_cast<double>(band.at_x[i]) - p[kCenterX],
                                static_cast<double>(band.at_y[i]) - p[kCenterY]);
    units += std::abs(p[kRadius] - r);
    px += std::abs(static_cast<double>(distance[i]));
  }
  return px > 0 ? units / px : 1;
}

/// Cells without a pixel take the mean of their ring's neighbours.
void fill_gaps(const Eigen::ArrayXXf& weight, Eigen::ArrayXXf& mean) {
  const Eigen::Index n = mean.cols();
  for (Eigen::Index j = 0; j < mean.rows(); ++j) {
    for (Eigen::Index i = 0; i < n; ++i) {
      if (weight(j, i) > 0) continue;
      Eigen::Index left = 1;
      Eigen::Index right = 1;
      while (left < n && !(weight(j, (i + n - left) % n) > 0)) ++left;
      while (right < n && !(weight(j, (i + right) % n) > 0)) ++right;
      mean(j, i) = 0.5F * (mean(j, (i + n - left) % n) + mean(j, (i + right) % n));
    }
  }
}

}  // namespace

double RimStrip::angle_rad(Eigen::Index sector) const {
  return 2 * std::numbers::pi * static_cast<double>(sector) / static_cast<double>(n_sectors());
}

RimStrip unroll(const RimWindow& window,
                const RimVector& p,
                double outer_px,
                double inner_px,
                Eigen::Index n_sectors,
                const Eigen::VectorXd& shape) {
  const RimBand& band = window.band();
  RimVector plain = p;
  plain[kOval] = plain[kOvalDiagonal] = 0;
  const std::vector<float> distance = band_values(band, plain, false).distance_px;
  RimStrip strip;
  strip.unit = units_per_px(band, p, distance);
  const auto n = static_cast<int>(n_sectors > 0 ? n_sectors : sectors_of(p[kRadius] / strip.unit));
  const int n_rings = 1 + static_cast<int>(outer_px) + static_cast<int>(inner_px);
  strip.first_px = -std::floor(outer_px);
  strip.mean.setZero(n_rings, n);
  Eigen::ArrayXXf weight = Eigen::ArrayXXf::Zero(n_rings, n);
  const auto first = static_cast<float>(strip.first_px);
  const Eigen::VectorXf outwards = shape.cast<float>();
  for (std::size_t k = 0; k < band.size(); ++k) {
    const double turn = turn_of(static_cast<double>(band.at_x[k]) - p[kCenterX],
                                static_cast<double>(band.at_y[k]) - p[kCenterY]);
    const auto column = static_cast<float>(turn * n);
    const int i = static_cast<int>(column) % n;
    const int next = i + 1 == n ? 0 : i + 1;
    const float along = column - std::floor(column);
    float row = distance[k] - first;
    if (outwards.size() > 0) row += (1 - along) * outwards[i] + along * outwards[next];
    if (!(row >= 0) || !(row < static_cast<float>(n_rings - 1))) continue;
    const int j = static_cast<int>(row);
    const float down = row - static_cast<float>(j);
    const float value = band.value[k];
    const auto add = [&](int ring, int sector, float share) {
      weight(ring, sector) += share;
      strip.mean(ring, sector) += share * value;
    };
    add(j, i, (1 - down) * (1 - along));
    add(j + 1, i, down * (1 - along));
    add(j, next, (1 - down) * along);
    add(j + 1, next, down * along);
  }
  strip.mass = weight.rowwise().mean().cast<double>();
  strip.seen = static_cast<double>((weight > 0).count()) / static_cast<double>(weight.size());
  strip.mean = (weight > 0).select(strip.mean / weight, 0.0F);
  if (strip.seen < 1) fill_gaps(weight, strip.mean);
  return strip;
}

Eigen::ArrayXd ring_medians(const RimStrip& strip, const std::vector<char>& use) {
  Eigen::ArrayXd medians(strip.n_rings());
  std::vector<float> values;
  for (Eigen::Index j = 0; j < strip.n_rings(); ++j) {
    values.clear();
    for (Eigen::Index i = 0; i < strip.n_sectors(); ++i) {
      if (use.empty() || use[static_cast<std::size_t>(i)] != 0) values.push_back(strip.mean(j, i));
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    medians[j] = static_cast<double>(*middle);
  }
  return medians;
}

void keep_one_edge(double near_px, double sign, Eigen::ArrayXd& medians, RimStrip& strip) {
  const Eigen::Index n = medians.size() - 1;
  if (n < 2) return;
  const Eigen::ArrayXd slope = sign * (medians.tail(n) - medians.head(n));
  Eigen::Index steepest = -1;
  for (Eigen::Index j = 0; j < n; ++j) {
    if (std::abs(strip.at_px(j) + 0.5) > near_px) continue;
    if (steepest < 0 || slope[j] > slope[steepest]) steepest = j;
  }
  if (steepest < 0 || !(slope[steepest] > 0)) return;
  // The flattest place from the edge on, if it is steep again behind.
  const auto valley = [&](Eigen::Index step) {
    Eigen::Index flattest = steepest;
    for (Eigen::Index j = steepest + step; j >= 0 && j < n; j += step) {
      if (slope[j] < slope[flattest]) flattest = j;
      if (slope[j] > slope[flattest] + kOtherEdge * slope[steepest]) return flattest;
    }
    return step < 0 ? Eigen::Index{0} : n - 1;
  };
  const Eigen::Index first = valley(-1);
  const Eigen::Index count = valley(1) + 2 - first;
  strip.first_px += static_cast<double>(first);
  strip.mean = strip.mean.middleRows(first, count).eval();
  strip.mass = strip.mass.segment(first, count).eval();
  medians = medians.segment(first, count).eval();
}

}  // namespace panelcal::internal
