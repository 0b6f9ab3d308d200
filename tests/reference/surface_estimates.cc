// SPDX-License-Identifier: Apache-2.0
// Reads probed boards from standard input and prints what panelcal makes of each, without the
// lattice that a map has.
//
//   N M           numbers of probes and of places; a board after the other
//   x y z sigma   a probe, mm; N lines
//   x y           a place, mm; M lines
//
// Out    a JSON object a board: "model", "summary", "reason", "left_out" (indices, from 0), and
//        [height, sigma] of each place in "places" and of each kept probe in "probes"; or "refused"
// See    tests/bench/surface_coverage.py, which draws the boards and knows the truth
#include <cstddef>
#include <cstdio>
#include <iostream>
#include <string>
#include <vector>

#include "surface/fit/choice.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace panelcal {
namespace {

using BoardPlaces = std::vector<Position<frame::Nominal>>;

nlohmann::json heights(const SurfaceFit& fit, const BoardPlaces& places) {
  auto out = nlohmann::json::array();
  for (const HeightEstimate& found : fit.at(places)) {
    out.push_back({found.height.in_mm(), found.sigma.in_mm()});
  }
  return out;
}

nlohmann::json answer(const std::vector<ProbePoint>& points, const BoardPlaces& places) {
  const auto chosen = choose_surface(points);
  if (!chosen) return {{"refused", chosen.error().text()}};
  const SoundSurface& sound = chosen->surface;
  BoardPlaces kept;
  for (const std::size_t i : sound.kept) kept.push_back(points[i].place);
  auto left_out = nlohmann::json::array();
  for (const SurfaceOutlier& outlier : sound.outliers) left_out.push_back(outlier.i_point);
  return {{"model", word(sound.fit.model())},
          {"summary", sound.fit.summary()},
          {"reason", chosen->reason},
          {"left_out", std::move(left_out)},
          {"places", heights(sound.fit, places)},
          {"probes", heights(sound.fit, kept)}};
}

}  // namespace
}  // namespace panelcal

int main() {
  for (std::size_t n = 0, m = 0; std::cin >> n >> m;) {
    std::vector<panelcal::ProbePoint> points(n);
    for (panelcal::ProbePoint& point : points) {
      double x_mm = 0, y_mm = 0, z_mm = 0, sigma_mm = 0;
      std::cin >> x_mm >> y_mm >> z_mm >> sigma_mm;
      point.place = panelcal::position_mm<panelcal::frame::Nominal>(x_mm, y_mm);
      point.measured = {panelcal::mm(z_mm), panelcal::mm(sigma_mm)};
    }
    panelcal::BoardPlaces places;
    for (std::size_t i = 0; i < m; ++i) {
      double x_mm = 0, y_mm = 0;
      std::cin >> x_mm >> y_mm;
      places.push_back(panelcal::position_mm<panelcal::frame::Nominal>(x_mm, y_mm));
    }
    if (!std::cin) return 2;
    fmt::print("{}\n", panelcal::answer(points, places).dump());
    std::fflush(stdout);
  }
  return 0;
}
