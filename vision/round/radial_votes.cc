// SPDX-License-Identifier: Apache-2.0
#include "vision/round/radial_votes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <utility>

#include "calib/base/statistics/median.h"
#include "vision/fit/local_maxima.h"

namespace panelcal::internal {
namespace {

constexpr double kCellsPerRadius = 10;
/// Votes go to this range of radii, so that a target of the wrong size is seen and named.
constexpr double kRadiusSpread = 0.12;
constexpr double kMinVotes = 0.12;
constexpr double kPeakDistance = 0.4;  // of the radius

/// A small picture of doubles.
struct Grid {
  int width = 0;
  int height = 0;
  std::vector<float> cells;

  Grid(int w, int h)
      : width(w), height(h), cells(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), 0) {}
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
  float at(int x, int y) const { return cells[index(x, y)]; }
  float& at(int x, int y) { return cells[index(x, y)]; }
  /// n cells of a row.
  Eigen::Map<const Eigen::ArrayXf> part(int x, int y, int n) const {
    return {cells.data() + index(x, y), n};
  }
  Eigen::Map<Eigen::ArrayXf> part(int x, int y, int n) { return {cells.data() + index(x, y), n}; }
};

/// Averages factor x factor pixels; what is left over at the right and bottom is dropped.
Grid averaged(const Image& image, const PixelBox& box, int factor) {
  Grid grid(box.width / factor, box.height / factor);
  const float weight = 1.0F / static_cast<float>(factor * factor);
  const Eigen::Index width = static_cast<Eigen::Index>(grid.width) * factor;
  Eigen::ArrayXf sums(width);
  for (int y = 0; y < grid.height; ++y) {
    sums.setZero();
    const auto row = [&](int i) {
      return Eigen::Map<const Eigen::ArrayXf>(image.row(box.y0 + y * factor + i).data() + box.x0,
                                              width);
    };
    int i = 0;
    for (; i + 4 <= factor; i += 4) sums += (row(i) + row(i + 1)) + (row(i + 2) + row(i + 3));
    for (; i < factor; ++i) sums += row(i);
    const float* from = sums.data();
    for (int x = 0; x < grid.width; ++x, from += factor) {
      grid.at(x, y) = weight * std::accumulate(from, from + factor, 0.0F);
    }
  }
  return grid;
}

/// (1 2 1) / 4 both ways; the border keeps its values.
Grid smoothed_votes(const Grid& in) {
  if (in.width < 3 || in.height < 3) return in;
  Grid rows = in;
  for (int y = 0; y < in.height; ++y) {
    const auto from = [&](int x) { return in.part(x, y, in.width - 2); };
    rows.part(1, y, in.width - 2) = 0.25F * (from(0) + 2 * from(1) + from(2));
  }
  Grid out = rows;
  for (int y = 1; y + 1 < in.height; ++y) {
    const auto from = [&](int dy) { return std::as_const(rows).part(0, y + dy, in.width); };
    out.part(0, y, in.width) = 0.25F * (from(-1) + 2 * from(0) + from(1));
  }
  return out;
}

struct Gradients {
  Grid x;
  Grid y;
};

Gradients gradients_of(const Grid& grid) {
  Gradients g{Grid(grid.width, grid.height), Grid(grid.width, grid.height)};
  if (grid.width < 3) return g;
  const int n = grid.width - 2;
  for (int y = 1; y + 1 < grid.height; ++y) {
    g.x.part(1, y, n) = 0.5F * (grid.part(2, y, n) - grid.part(0, y, n));
    g.y.part(1, y, n) = 0.5F * (grid.part(1, y + 1, n) - grid.part(1, y - 1, n));
  }
  return g;
}

/// Sigma of a gradient component by noise and texture: the median is blind to a few edges.
double gradient_sigma(const Gradients& g) {
  // This number gives the median to 2 %.
  constexpr std::size_t kEnough = 4000;
  std::size_t stride = std::max<std::size_t>(1, g.x.cells.size() / kEnough);
  // Not the same columns in every row: a weave may repeat with them.
  while (stride > 1 && static_cast<std::size_t>(g.x.width) % stride == 0) ++stride;
  std::vector<float> magnitudes;
  magnitudes.reserve(g.x.cells.size() / stride + 1);
  for (std::size_t i = 0; i < g.x.cells.size(); i += stride) {
    magnitudes.push_back(std::abs(g.x.cells[i]));
  }
  return kSigmasPerMedian * median(std::move(magnitudes));
}

void vote(Grid& votes, double x, double y, float weight) {
  const double fx = std::floor(x);
  const double fy = std::floor(y);
  if (!(fx >= 0) || !(fy >= 0) || !(fx < votes.width - 1) || !(fy < votes.height - 1)) return;
  const int ix = static_cast<int>(fx);
  const int iy = static_cast<int>(fy);
  const float tx = static_cast<float>(x - fx);
  const float ty = static_cast<float>(y - fy);
  votes.at(ix, iy) += weight * (1 - tx) * (1 - ty);
  votes.at(ix + 1, iy) += weight * tx * (1 - ty);
  votes.at(ix, iy + 1) += weight * (1 - tx) * ty;
  votes.at(ix + 1, iy + 1) += weight * tx * ty;
}

Grid collect_votes(const Gradients& g, double radius, double sign, double threshold) {
  Grid votes(g.x.width, g.x.height);
  const int n_steps = std::max(1, static_cast<int>(std::ceil(kRadiusSpread * radius)));
  const float weight = 1.0F / static_cast<float>(2 * n_steps + 1);
  const auto limit = static_cast<float>(threshold * threshold);
  Eigen::ArrayXf squares(votes.width);
  for (int y = 0; y < votes.height; ++y) {
    squares = g.x.part(0, y, votes.width).square() + g.y.part(0, y, votes.width).square();
    for (int x = 0; x < votes.width; ++x) {
      if (!(squares[x] > limit)) continue;
      const double gx = g.x.at(x, y);
      const double gy = g.y.at(x, y);
      const double magnitude = std::sqrt(gx * gx + gy * gy);
      for (int k = -n_steps; k <= n_steps; ++k) {
        const double r = sign * radius * (1 + kRadiusSpread * k / n_steps);
        vote(votes, x + r * gx / magnitude, y + r * gy / magnitude, weight);
      }
    }
  }
  return votes;
}

}  // namespace

std::vector<VotePeak> radial_votes(const Image& image,
                                   const PixelBox& box,
                                   double radius_px,
                                   Polarity polarity,
                                   double edge_level,
                                   int max_peaks) {
  // Such a rim could not be seen; its averaging would overflow.
  if (!(radius_px < std::hypot(box.width, box.height))) return {};
  const int factor = std::max(1, static_cast<int>(radius_px / kCellsPerRadius));
  if (box.width < 4 * factor || box.height < 4 * factor) return {};
  const Grid grid = smoothed_votes(averaged(image, box, factor));
  const double radius = radius_px / factor;
  const Gradients gradients = gradients_of(grid);
  // An edge smoothed to about 1.2 cells has a slope of a third of its height.
  const double threshold = std::max(0.25 * edge_level / 3, 3.5 * gradient_sigma(gradients));
  const double sign = polarity == Polarity::Bright ? 1 : -1;
  Grid votes = smoothed_votes(
      smoothed_votes(collect_votes(gradients, radius, sign, std::max(threshold, 1e-6))));

  // A rim two cells wide votes into a spot whose middle holds about a tenth of it.
  const double whole_rim = 2 * std::numbers::pi * radius * 0.15;
  const auto least = static_cast<float>(kMinVotes * whole_rim);
  const cv::Mat map(votes.height, votes.width, CV_32F, votes.cells.data());
  std::vector<VotePeak> best;
  for (const cv::Point& cell : local_maxima(map, least)) {
    if (static_cast<int>(best.size()) >= max_peaks) break;
    const Eigen::Vector2d at(box.x0 + (cell.x + 0.5) * factor - 0.5,
                             box.y0 + (cell.y + 0.5) * factor - 0.5);
    const bool is_new = std::ranges::all_of(best, [&](const VotePeak& other) {
      return (other.at_px - at).norm() > kPeakDistance * radius_px;
    });
    if (is_new) best.push_back({at, votes.at(cell.x, cell.y) / whole_rim});
  }
  return best;
}

}  // namespace panelcal::internal
