// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/surface/run.h"

#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

struct ProbedPlace {
  int column = 0;
  int row = 0;
  Position<frame::Nominal> at;

  std::string name() const { return fmt::format("column {} row {}", column, row); }
};

/// Row by row, to and fro.
std::vector<ProbedPlace> probed_places(const NightSurface& surface) {
  const Eigen::Vector2d step_mm =
      (surface.high_mm - surface.low_mm)
          .cwiseQuotient(Eigen::Vector2d(surface.n_columns - 1, surface.n_rows - 1));
  std::vector<ProbedPlace> out;
  for (int row = 0; row < surface.n_rows; ++row) {
    for (int i = 0; i < surface.n_columns; ++i) {
      const int column = row % 2 == 0 ? i : surface.n_columns - 1 - i;
      const Eigen::Vector2d at_mm =
          surface.low_mm + Eigen::Vector2d(column, row).cwiseProduct(step_mm);
      out.push_back({column, row, position_mm<frame::Nominal>(at_mm)});
    }
  }
  return out;
}

/// In machine coordinates, which are a program's where work zero is the machine's.
ProbeRequest request_for(const NightSurface& surface, const ProbedPlace& place, std::int64_t seq) {
  ProbeRequest out;
  out.seq = seq;
  out.command = "nightly";
  out.nominal = place.at;
  out.expected = position_mm<frame::Actual>(place.at.in_mm());
  out.reference = surface.height;
  return out;
}

/// Probes place by place, and collects what a map is made of.
class Probing {
 public:
  Probing(const NightSurface& surface, ProbeSource& probe) : surface_(surface), probe_(probe) {}

  Expected<void> at(const ProbedPlace& place) {
    std::vector<HeightEstimate> readings;
    std::string why;
    for (int i = 0; i < surface_.n_repeats; ++i) {
      PANELCAL_TRY(const ProbeReading reading, probe_.probe(request_for(surface_, place, seq_++)));
      if (reading.status == ProbeStatus::Found && !reading.heights.empty()) {
        readings.push_back(reading.heights.front());
      } else {
        why = reading.reason;
      }
    }
    if (readings.empty()) {
      missed.push_back(fmt::format("{}: {}", place.name(), why.empty() ? "no height" : why));
    } else {
      take(place, readings);
    }
    return {};
  }

  std::vector<ProbePoint> points;
  std::vector<std::string> missed;
  double squares_mm2 = 0;  ///< of readings about the mean of their place
  int degrees_of_freedom = 0;

 private:
  void take(const ProbedPlace& place, const std::vector<HeightEstimate>& readings) {
    const auto n = static_cast<double>(readings.size());
    double mean_mm = 0;
    double variance_mm2 = 0;
    for (const HeightEstimate& reading : readings) {
      const Length sigma = reading.sigma > Length() ? reading.sigma : surface_.probe_sigma;
      mean_mm += reading.height.in_mm() / n;
      variance_mm2 += sigma.in_mm() * sigma.in_mm() / (n * n);
    }
    for (const HeightEstimate& reading : readings) {
      const double off_mm = reading.height.in_mm() - mean_mm;
      squares_mm2 += off_mm * off_mm;
    }
    degrees_of_freedom += static_cast<int>(readings.size()) - 1;
    points.push_back({place.at, {mm(mean_mm), mm(std::sqrt(variance_mm2))}, place.name(), {}});
  }

  const NightSurface& surface_;
  ProbeSource& probe_;
  std::int64_t seq_ = 0;
};

/// A night's measurement is no bad input, whatever is wrong with it.
Diagnostic no_surface(Diagnostic problem, const std::vector<std::string>& missed) {
  std::string what = "the probes make no surface: " + problem.what;
  if (!missed.empty()) {
    what += fmt::format("; at {} places nothing was touched, first {}", missed.size(), missed[0]);
  }
  return {Code::CalibrationData, {}, std::move(what), std::move(problem.expected)};
}

}  // namespace

SurfaceArea area_of(const NightSurface& surface) {
  return {0.5 * (surface.low_mm + surface.high_mm), 0.5 * (surface.high_mm - surface.low_mm)};
}

std::vector<Eigen::Vector2d> probed_places_mm(const NightSurface& surface) {
  std::vector<Eigen::Vector2d> out;
  for (const ProbedPlace& place : probed_places(surface)) out.push_back(place.at.in_mm());
  return out;
}

Expected<SurfaceRun> probe_surface(const NightSurface& surface,
                                   ProbeSource& probe,
                                   const std::string& made_by) {
  Probing probing(surface, probe);
  for (const ProbedPlace& place : probed_places(surface)) PANELCAL_CHECK(probing.at(place));
  HeightMapOptions options;
  options.model = SurfaceModel::GaussianProcess;
  auto map = HeightMap::of_probes(probing.points, options);
  if (!map) return failure(no_surface(std::move(map).error(), probing.missed));
  auto figures = figures_of(*map, area_of(surface));
  if (!figures) return failure(no_surface(std::move(figures).error(), probing.missed));
  SurfaceRun run{{std::move(probing.points), *std::move(map), {}, made_by},
                 *std::move(figures),
                 std::move(probing.missed)};
  run.degrees_of_freedom = probing.degrees_of_freedom;
  if (run.degrees_of_freedom > 0) {
    run.reading_variance_mm2 = probing.squares_mm2 / run.degrees_of_freedom;
  }
  return run;
}

std::string report(const SurfaceRun& run) {
  std::string out = fmt::format("{} places probed, {} make the map: {}\n",
                                run.stored.points.size() + run.missed.size(),
                                run.stored.map.kept().size(),
                                run.stored.map.surface().summary());
  for (const SurfaceOutlier& outlier : run.stored.map.outliers()) {
    out += "left out: " + outlier.text() + "\n";
  }
  for (const std::string& missed : run.missed) out += "not touched: " + missed + "\n";
  if (run.degrees_of_freedom > 0) {
    out += fmt::format("readings of one place scatter {:.1f} um\n",
                       1e3 * std::sqrt(run.reading_variance_mm2));
  }
  return out + report(run.figures);
}

}  // namespace panelcal
