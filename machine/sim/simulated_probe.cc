// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/simulated_probe.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "machine/sim/random_streams.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr double kPerPpm = 1e-6;

}  // namespace

SimulatedProbe::SimulatedProbe(SimulatedProbeOptions options) : options_(std::move(options)) {
}

Expected<SimulatedProbe> SimulatedProbe::create(SimulatedProbeOptions options) {
  PANELCAL_CHECK(options.validate());
  return SimulatedProbe(std::move(options));
}

Length SimulatedProbe::true_height(const Position<frame::Actual>& place, std::size_t axis) const {
  const Eigen::Vector2d& p_mm = place.in_mm();
  const double slope_mm =
      kPerPpm * (options_.slope_x_ppm * p_mm.x() + options_.slope_y_ppm * p_mm.y());
  const double from_center =
      (place - options_.bow_center).in_mm().norm() / options_.bow_radius.in_mm();
  const bool is_chipped = options_.chip && (place - options_.chip->place).in_mm().norm() <
                                               options_.chip->radius.in_mm();
  return options_.height + mm(slope_mm) + from_center * from_center * options_.bow +
         options_.axis_offsets[axis] - (is_chipped ? options_.chip->depth : Length());
}

Expected<ProbeReading> SimulatedProbe::probe(const ProbeRequest& request) {
  const Random random =
      internal::random_of(options_.seed, internal::RandomStream::Probes, request.seq);
  ProbeReading reading{request, ProbeStatus::Found, {}, ""};
  for (std::size_t axis = 0; axis < options_.axis_offsets.size(); ++axis) {
    const Length noise = random.fork(axis).normal() * options_.noise_sigma;
    reading.heights.push_back({true_height(request.expected, axis) + noise, options_.noise_sigma});
  }
  return reading;
}

}  // namespace panelcal
