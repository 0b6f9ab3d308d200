// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/facts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <utility>

#include "calib/base/plane_vectors.h"
#include "calib/base/statistics/median.h"

namespace panelcal::surface {
namespace {

/// Places along the longer side of the hull's rectangle.
constexpr int kAlong = 100;

/// A place of a raster over the hull; empty outside.
using Cell = std::optional<HeightAt>;

struct Raster {
  Eigen::Vector2d low_mm, step_mm;
  int n_columns = 0, n_rows = 0;
  std::vector<Cell> cells;    ///< row by row
  std::size_t n_without = 0;  ///< within the hull, without a surface

  Position<frame::Nominal> middle(std::size_t i) const {
    const auto column = static_cast<double>(i % static_cast<std::size_t>(n_columns));
    const auto row = static_cast<double>(i / static_cast<std::size_t>(n_columns));
    return position_mm<frame::Nominal>(
        low_mm + Eigen::Vector2d((column + 0.5) * step_mm.x(), (row + 0.5) * step_mm.y()));
  }
  double cell_mm2() const { return step_mm.prod(); }
};

using IsSurface = std::function<bool(const Position<frame::Nominal>&)>;

Raster raster_of(const HeightMap& map, const IsSurface& is_surface) {
  Raster out;
  out.low_mm = map.hull().front().in_mm();
  Eigen::Vector2d high_mm = out.low_mm;
  for (const auto& corner : map.hull()) {
    out.low_mm = out.low_mm.cwiseMin(corner.in_mm());
    high_mm = high_mm.cwiseMax(corner.in_mm());
  }
  const Eigen::Vector2d size_mm = high_mm - out.low_mm;
  const double step_mm = size_mm.maxCoeff() / kAlong;
  out.n_columns = std::max(1, static_cast<int>(std::lround(size_mm.x() / step_mm)));
  out.n_rows = std::max(1, static_cast<int>(std::lround(size_mm.y() / step_mm)));
  out.step_mm = {size_mm.x() / out.n_columns, size_mm.y() / out.n_rows};
  const auto n = static_cast<std::size_t>(out.n_columns) * static_cast<std::size_t>(out.n_rows);
  for (std::size_t i = 0; i < n; ++i) {
    const auto found = map.height_at(out.middle(i));
    bool is_inside = found && found->source != HeightSource::Extrapolated;
    if (is_inside && is_surface && !is_surface(out.middle(i))) {
      is_inside = false;
      ++out.n_without;
    }
    out.cells.push_back(is_inside ? Cell(*found) : std::nullopt);
  }
  return out;
}

bool is_filled(const Cell& cell) {
  return cell && cell->source == HeightSource::Filled;
}

/// Cells that touch along a side belong together.
std::vector<FilledArea> filled_areas(const Raster& raster) {
  const auto n_columns = static_cast<std::size_t>(raster.n_columns);
  std::vector<bool> seen(raster.cells.size(), false);
  std::vector<FilledArea> out;
  for (std::size_t first = 0; first < raster.cells.size(); ++first) {
    if (seen[first] || !is_filled(raster.cells[first])) continue;
    std::vector<std::size_t> waiting = {first};
    seen[first] = true;
    Eigen::Vector2d sum_mm = Eigen::Vector2d::Zero();
    double n = 0;
    while (!waiting.empty()) {
      const std::size_t i = waiting.back();
      waiting.pop_back();
      sum_mm += raster.middle(i).in_mm();
      n += 1;
      const auto visit = [&](bool is_there, std::size_t next) {
        if (!is_there || seen[next] || !is_filled(raster.cells[next])) return;
        seen[next] = true;
        waiting.push_back(next);
      };
      visit(i % n_columns > 0, i - 1);
      visit(i % n_columns + 1 < n_columns, i + 1);
      visit(i >= n_columns, i - n_columns);
      visit(i + n_columns < raster.cells.size(), i + n_columns);
    }
    out.push_back({position_mm<frame::Nominal>(sum_mm / n), n * raster.cell_mm2()});
  }
  std::ranges::stable_sort(out, std::greater<>(), &FilledArea::area_mm2);
  return out;
}

double area_mm2(std::span<const Position<frame::Nominal>> corners) {
  double twice_mm2 = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d a = corners[i].in_mm(), b = corners[(i + 1) % corners.size()].in_mm();
    twice_mm2 += internal::cross(a, b);
  }
  return twice_mm2 / 2;
}

}  // namespace

double MapFacts::filled_share() const {
  double sum_mm2 = 0;
  for (const FilledArea& area : filled) sum_mm2 += area.area_mm2;
  return std::min(1.0, sum_mm2 / hull_mm2);
}

MapFacts facts_of(const StoredMap& stored, const IsSurface& is_surface) {
  const HeightMap& map = stored.map;
  MapFacts out;
  std::vector<double> sigmas_mm;
  bool is_first = true;
  const auto look = [&](const Position<frame::Nominal>& at, const HeightAt& found) {
    if (is_first || found.height < out.lowest.value) out.lowest = {found.height, at};
    if (is_first || found.height > out.highest.value) out.highest = {found.height, at};
    if (is_first || found.sigma > out.worst_sigma.value) out.worst_sigma = {found.sigma, at};
    is_first = false;
  };
  // Sigma is greatest at corners of the hull or in gaps, heights often at the probes.
  double sum_mm2 = 0, stated_mm2 = 0;
  for (const std::size_t i : map.kept()) {
    const ProbePoint& probe = stored.points[i];
    if (const auto found = map.height_at(probe.place)) look(probe.place, *found);
    const Length residual = probe.measured.height - map.surface().at(probe.place).height;
    sum_mm2 += residual.in_mm() * residual.in_mm();
    stated_mm2 += probe.measured.sigma.in_mm() * probe.measured.sigma.in_mm();
  }
  const auto n = static_cast<double>(map.kept().size());
  out.residual_rms = mm(std::sqrt(sum_mm2 / n));
  out.stated_rms = mm(std::sqrt(stated_mm2 / n));
  const Raster raster = raster_of(map, is_surface);
  for (std::size_t i = 0; i < raster.cells.size(); ++i) {
    if (!raster.cells[i]) continue;
    look(raster.middle(i), *raster.cells[i]);
    sigmas_mm.push_back(raster.cells[i]->sigma.in_mm());
  }
  out.usual_sigma = mm(median(std::move(sigmas_mm)));
  // A raster may count more than there is.
  const double without_mm2 = static_cast<double>(raster.n_without) * raster.cell_mm2();
  out.hull_mm2 = std::max(raster.cell_mm2(), area_mm2(map.hull()) - without_mm2);
  out.filled = filled_areas(raster);
  return out;
}

}  // namespace panelcal::surface
