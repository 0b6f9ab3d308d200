// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "surface/map/file_parts.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Probes that scatter more than this multiple of their stated sigma are refused.
constexpr double kMostNoise = 1e6;

Expected<void> check_noise_factor(const MapSurface& written, const std::string& file) {
  const bool is_grid = is_of_grid(written.model);
  for (const ShapeShare& share : written.shapes) {
    const double factor = share.shape.noise_factor;
    if (is_grid ? factor == 1 : factor <= kMostNoise) continue;
    return failure(map_file_problem(file,
                                    fmt::format("the noise factor is {}", factor),
                                    is_grid ? "1: grid models believe their probes"
                                            : fmt::format("above 0, at most {}", kMostNoise)));
  }
  return {};
}

/// Their i_point counts in `own`.
Expected<std::vector<SurfaceOutlier>> outliers_of(const MapSurface& written,
                                                  std::span<const ProbePoint> points,
                                                  std::span<const std::size_t> own,
                                                  const std::string& file) {
  std::vector<SurfaceOutlier> out = written.left_out;
  std::size_t next = 0;
  for (SurfaceOutlier& outlier : out) {
    const std::size_t i_point = outlier.i_point;
    if (i_point < next || i_point >= points.size()) {
      return failure(map_file_problem(
          file,
          fmt::format("probe {} is left out", i_point),
          fmt::format("each probe once, rising, from {} to {}", next, points.size() - 1)));
    }
    next = i_point + 1;
    outlier.name = name_of(points[i_point]);
    const auto found = std::ranges::lower_bound(own, i_point);
    if (found == own.end() || *found != i_point) {
      return failure(map_file_problem(
          file,
          fmt::format("{} is left out of a zone that it is not in", quoted(outlier.name)),
          "a probe of the zone"));
    }
    outlier.i_point = static_cast<std::size_t>(found - own.begin());
  }
  return out;
}

}  // namespace

Diagnostic map_file_problem(const std::string& file, std::string what, std::string expected) {
  return {kMapFileCode, {file, 0, 0}, std::move(what), std::move(expected)};
}

Expected<HeightMap> surface_of(const MapSurface& written,
                               std::span<const ProbePoint> points,
                               std::span<const std::size_t> own,
                               const std::string& file) {
  PANELCAL_CHECK(check_noise_factor(written, file));
  PANELCAL_TRY(auto outliers, outliers_of(written, points, own, file));
  // Before anything is solved: of more no surface was made.
  const std::size_t most = is_of_grid(written.model) ? kMostGridProbes : kMostBentProbes;
  if (own.size() > most) {
    return failure(map_file_problem(file,
                                    fmt::format("{} probes of one surface", own.size()),
                                    fmt::format("at most {} for {}", most, word(written.model))));
  }
  std::vector<ProbePoint> all, fitted;
  std::vector<std::size_t> kept;
  auto next = outliers.begin();
  for (std::size_t k = 0; k < own.size(); ++k) {
    all.push_back(points[own[k]]);
    if (next != outliers.end() && next->i_point == k) {
      ++next;
      continue;
    }
    kept.push_back(k);
    fitted.push_back(points[own[k]]);
  }
  auto made = [&]() -> Expected<HeightMap> {
    PANELCAL_TRY(SurfaceFit fit, fit_surface(fitted, written.model, written.shapes));
    if (!outliers.empty()) fit = fit.with(possible_bends(all, kept, outliers));
    SoundSurface surface{std::move(fit), std::move(kept), std::move(outliers)};
    return HeightMap::of_surface(all, {std::move(surface), written.reason}, written.options);
  }();
  if (made) return made;
  // Whatever it is, the map's file is what must be mended.
  Diagnostic problem = std::move(made).error();
  problem.place = {file, 0, 0};
  return failure(std::move(problem));
}

MapSurface written_surface(const HeightMap& map, std::span<const std::size_t> own) {
  const auto shapes = map.surface().shapes();
  MapSurface out = {map.surface().model(),
                    map.reason(),
                    {shapes.begin(), shapes.end()},
                    map.options(),
                    {map.outliers().begin(), map.outliers().end()}};
  for (SurfaceOutlier& outlier : out.left_out) outlier.i_point = own[outlier.i_point];
  return out;
}

}  // namespace panelcal::internal
