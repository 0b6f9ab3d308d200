// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/strip.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "calib/base/statistics/median.h"

namespace panelcal::internal {
namespace {

constexpr double kSectorArc_px = 2;
constexpr double kMinSectors = 24;
constexpr double kMaxSectors = 256;
constexpr double kOtherEdge = 0.25;  // of an edge's slope: where it rises by more, another begins
/// Rings of an edge that stay in any case: outside, where a mask's opening is near, fewer.
constexpr Eigen::Index kOutsideOfEdge = 3;
constexpr Eigen::Index kInsideOfEdge = 4;
constexpr Eigen::Index kBeyondOther = 3;  // rings, that tell where another edge is

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

/// What the pixels of a cell add up to.
struct StripCell {
  float weight = 0;
  float sum = 0;

  void add(float share, float value) {
    weight += share;
    sum += share * value;
  }
};

/// The cells of a strip, sector by sector.
class StripCells {
 public:
  StripCells(int n_rings, int n_sectors)
      : n_rings_(n_rings),
        n_sectors_(n_sectors),
        cells_(static_cast<std::size_t>(n_rings) * static_cast<std::size_t>(n_sectors)) {}

  /// In     sector: 0 to the number of sectors; ring: whatever is not between the first and the
  ///        last one is left out
  void share_out(float sector, float ring, float value) {
    if (!(ring >= 0) || !(ring < static_cast<float>(n_rings_ - 1))) return;
    const int whole = static_cast<int>(sector);
    const int i = whole < n_sectors_ ? whole : 0;
    const int next = i + 1 == n_sectors_ ? 0 : i + 1;
    const float along = sector - static_cast<float>(whole);
    const int j = static_cast<int>(ring);
    const float down = ring - static_cast<float>(j);
    StripCell* const here = cells_.data() + i * n_rings_ + j;
    StripCell* const beside = cells_.data() + next * n_rings_ + j;
    here[0].add((1 - down) * (1 - along), value);
    here[1].add(down * (1 - along), value);
    beside[0].add((1 - down) * along, value);
    beside[1].add(down * along, value);
  }

  /// Sets the means, how many pixels are in each ring, and what part of the cells holds one.
  void finish(RimStrip& strip) const {
    strip.mean.resize(n_rings_, n_sectors_);
    strip.mass.setZero(n_rings_);
    Eigen::Index n_seen = 0;
    const StripCell* cell = cells_.data();
    for (int i = 0; i < n_sectors_; ++i) {
      for (int j = 0; j < n_rings_; ++j, ++cell) {
        n_seen += cell->weight > 0;
        strip.mass[j] += static_cast<double>(cell->weight);
        strip.mean(j, i) = cell->weight > 0 ? cell->sum / cell->weight : 0.0F;
      }
    }
    strip.mass /= n_sectors_;
    strip.seen = static_cast<double>(n_seen) / static_cast<double>(cells_.size());
    if (strip.seen < 1) fill_gaps(strip.mean);
  }

 private:
  bool is_empty(Eigen::Index ring, Eigen::Index sector) const {
    return !(cells_[static_cast<std::size_t>(sector * n_rings_ + ring)].weight > 0);
  }

  /// Cells without a pixel take the mean of their ring's neighbours.
  void fill_gaps(Eigen::ArrayXXf& mean) const {
    const Eigen::Index n = n_sectors_;
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j < n_rings_; ++j) {
        if (!is_empty(j, i)) continue;
        Eigen::Index left = 1;
        Eigen::Index right = 1;
        while (left < n && is_empty(j, (i + n - left) % n)) ++left;
        while (right < n && is_empty(j, (i + right) % n)) ++right;
        mean(j, i) = 0.5F * (mean(j, (i + n - left) % n) + mean(j, (i + right) % n));
      }
    }
  }

  int n_rings_;
  int n_sectors_;
  std::vector<StripCell> cells_;
};

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
  const RimPlaces places = rim_places(band, p);
  RimStrip strip;
  strip.unit = units_per_px(band, p, places.distance_px);
  const auto n = static_cast<int>(n_sectors > 0 ? n_sectors : sectors_of(p[kRadius] / strip.unit));
  const int n_rings = 1 + static_cast<int>(outer_px) + static_cast<int>(inner_px);
  strip.first_px = -std::floor(outer_px);
  StripCells cells(n_rings, n);
  const auto first = static_cast<float>(strip.first_px);
  // Once around, and the first sector again.
  Eigen::VectorXf outwards = shape.cast<float>();
  if (shape.size() > 0) {
    outwards.conservativeResize(shape.size() + 1);
    outwards[shape.size()] = outwards[0];
  }
  for (std::size_t k = 0; k < band.size(); ++k) {
    const float sector = std::min(places.turn[k], 1.0F) * static_cast<float>(n);
    float ring = places.distance_px[k] - first;
    if (shape.size() > 0) {
      const int i = std::min(static_cast<int>(sector), n - 1);
      const float along = sector - static_cast<float>(i);
      ring += (1 - along) * outwards[i] + along * outwards[i + 1];
    }
    cells.share_out(sector, ring, band.value[k]);
  }
  cells.finish(strip);
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
    medians[j] = median(std::move(values));
  }
  return medians;
}

namespace {

/// Where an edge's rings end on one side, and the edge beside it that is within them.
struct EdgeSide {
  Eigen::Index last = 0;              ///< of the slopes
  std::optional<Eigen::Index> other;  ///< of the slopes, the steepest
};

/// In     slope: from ring to ring; step: 1 or -1
EdgeSide side_of(const Eigen::ArrayXd& slope, Eigen::Index steepest, Eigen::Index step) {
  const Eigen::Index n = slope.size();
  const auto is_inside = [&](Eigen::Index j) { return j >= 0 && j < n; };
  const double rise = kOtherEdge * slope[steepest];
  Eigen::Index flattest = steepest;
  Eigen::Index j = steepest + step;
  for (; is_inside(j); j += step) {
    if (slope[j] < slope[flattest]) flattest = j;
    if (slope[j] > std::max(0.0, slope[flattest]) + rise) break;
  }
  if (!is_inside(j)) return {step < 0 ? 0 : n - 1, std::nullopt};
  while (is_inside(j + step) && slope[j + step] > slope[j]) j += step;
  const Eigen::Index other = j;
  const double half = 0.5 * (slope[other] + std::max(0.0, slope[flattest]));
  while (is_inside(j) && slope[j] > half) j += step;
  // A slope that goes on is shading, such as a dome's.
  if (!is_inside(j)) return {flattest, std::nullopt};
  Eigen::Index last = j;
  for (; is_inside(j) && std::abs(j - other) <= kBeyondOther; j += step) {
    if (slope[j] > std::max(0.0, slope[last]) + rise) break;
    if (slope[j] < slope[last] || slope[j] < rise) last = j;
  }
  return {last, other};
}

}  // namespace

void keep_nearest_edge(
    double at_px, double near_px, double sign, Eigen::ArrayXd& medians, RimStrip& strip) {
  const Eigen::Index n = medians.size() - 1;
  if (n < 2) return;
  const Eigen::ArrayXd slope = sign * (medians.tail(n) - medians.head(n));
  const auto merit = [&](Eigen::Index j) {
    const double z = (strip.at_px(j) + 0.5 - at_px) / near_px;
    return slope[j] * std::exp(-0.5 * z * z);
  };
  Eigen::Index steepest = 0;
  for (Eigen::Index j = 1; j < n; ++j) {
    if (merit(j) > merit(steepest)) steepest = j;
  }
  if (!(slope[steepest] > 0)) return;
  const EdgeSide outer = side_of(slope, steepest, -1);
  const EdgeSide inner = side_of(slope, steepest, 1);
  for (const EdgeSide& side : {outer, inner}) {
    if (side.other) strip.others_px.push_back(strip.at_px(*side.other) + 0.5);
  }
  const Eigen::Index first = std::clamp<Eigen::Index>(steepest + 1 - kOutsideOfEdge, 0, outer.last);
  const Eigen::Index last = std::clamp<Eigen::Index>(steepest + kInsideOfEdge, inner.last + 1, n);
  const Eigen::Index count = last + 1 - first;
  strip.first_px += static_cast<double>(first);
  strip.mean = strip.mean.middleRows(first, count).eval();
  strip.mass = strip.mass.segment(first, count).eval();
  medians = medians.segment(first, count).eval();
}

}  // namespace panelcal::internal
