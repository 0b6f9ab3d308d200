// SPDX-License-Identifier: Apache-2.0
#include "program/judge/probed_surface.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "program/judge/job_decision.h"
#include <fmt/format.h>

namespace panelcal {

Expected<ZonedMap> probed_surface(const Survey& survey,
                                  Length max_extrapolation,
                                  std::size_t axis) {
  std::vector<ProbePoint> points;
  points.reserve(survey.probes.size());
  for (const ProbeReading& reading : survey.probes) {
    if (reading.status != ProbeStatus::Found || axis >= reading.heights.size()) continue;
    const ProbeRequest& request = reading.request;
    const HeightEstimate& height = reading.heights[axis];
    if (!(height.sigma > Length())) {
      return failure({Code::MeasurementInvalid,
                      {request.file, request.line, 1},
                      describe(request) + " states a sigma of 0",
                      "a sigma above 0"});
    }
    points.push_back({request.nominal, height, describe(request), {request.file, request.line, 1}});
  }
  if (points.size() < kLeastForBow) {
    return failure({Code::GridInvalid,
                    {},
                    count_of(static_cast<std::int64_t>(points.size()), "probe does", "probes do") +
                        " not determine how the board bends between them",
                    fmt::format("{} or more", kLeastForBow)});
  }
  HeightMapOptions options;
  options.max_extrapolation = max_extrapolation;
  PANELCAL_TRY(HeightMap map, HeightMap::of_probes(points, options));
  return ZonedMap(std::move(map));
}

std::vector<Expected<ZonedMap>> probed_surfaces(const Survey& survey, Length max_extrapolation) {
  std::size_t n_axes = 1;
  for (const ProbeReading& reading : survey.probes) {
    n_axes = std::max(n_axes, reading.heights.size());
  }
  std::vector<Expected<ZonedMap>> maps;
  for (std::size_t axis = 0; axis < n_axes; ++axis) {
    maps.push_back(probed_surface(survey, max_extrapolation, axis));
  }
  return maps;
}

}  // namespace panelcal
