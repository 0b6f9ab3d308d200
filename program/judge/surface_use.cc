// SPDX-License-Identifier: Apache-2.0
#include "program/judge/surface_use.h"

#include <algorithm>
#include <cmath>

#include "program/judge/job_decision.h"
#include <fmt/format.h>

namespace panelcal {

void SurfaceUse::put(const Operation& operation) {
  if (const auto* drill = std::get_if<Drill>(&operation.what)) {
    add(operation, drill->cut);
  } else if (const auto* rout = std::get_if<Rout>(&operation.what)) {
    add(operation, rout->cut);
  } else if (const auto* plunge = std::get_if<Plunge>(&operation.what)) {
    add(operation, plunge->cut);
  }
}

void SurfaceUse::add(const Operation& operation, const DepthOfCut& cut) {
  if (!cut.predicted || !cut.surface) return;
  const bool is_first = n_depths_++ == 0;
  lowest_ = is_first ? *cut.surface : std::min(lowest_, *cut.surface);
  highest_ = is_first ? *cut.surface : std::max(highest_, *cut.surface);
  if (cut.predicted->source == HeightSource::Filled) ++n_filled_;
  if (cut.predicted->source == HeightSource::Extrapolated) ++n_extrapolated_;
  if (cut.predicted->source == HeightSource::InVoid) ++n_in_void_;
  if (!is_first && cut.predicted->sigma <= largest_sigma_) return;
  largest_sigma_ = cut.predicted->sigma;
  line_of_largest_sigma_ = operation.line;
  file_of_largest_sigma_ = operation.file;
}

std::string SurfaceUse::summary() const {
  if (n_depths_ == 0) return "no depth counts from the map: nothing works below the surface";
  std::string out =
      fmt::format("{} from the map, {:.4f} to {:.4f} mm high, sigma at most {:.2f} um (line {})",
                  count_of(n_depths_, "depth counts", "depths count"),
                  lowest_.in_mm(),
                  highest_.in_mm(),
                  largest_sigma_.in_um(),
                  line_text(file_of_largest_sigma_, line_of_largest_sigma_));
  if (n_filled_ > 0) out += fmt::format("; {} where a probe is missing", n_filled_);
  if (n_extrapolated_ > 0) out += fmt::format("; {} outside of what was probed", n_extrapolated_);
  if (n_in_void_ > 0)
    out += fmt::format("; {} in voids, where the surface is not there", n_in_void_);
  return out;
}

void hold_against_map(const Survey& survey,
                      const ZonedMap& map,
                      const std::string& file,
                      DiagnosticLog& log) {
  constexpr double kMost = 5;
  std::int64_t n = 0, n_contradicting = 0;
  double worst = kMost;
  const ProbeReading* at_worst = nullptr;
  double off_um = 0, sigma_um = 0;
  for (const ProbeReading& reading : survey.probes) {
    if (reading.status != ProbeStatus::Found || reading.heights.empty()) continue;
    const auto found = map.height_at(reading.request.nominal);
    if (!found) continue;
    ++n;
    const HeightEstimate& probed = reading.heights.front();
    const double d_um = (probed.height - found->height.height).in_um();
    const double of_both_um = std::hypot(probed.sigma.in_um(), found->height.sigma.in_um());
    const double times = std::abs(d_um) / of_both_um;
    if (!(times > kMost)) continue;
    ++n_contradicting;
    if (at_worst != nullptr && times <= worst) continue;
    worst = times;
    at_worst = &reading;
    off_um = d_um;
    sigma_um = of_both_um;
  }
  if (at_worst == nullptr) return;
  const ProbeRequest& request = at_worst->request;
  log.add(
      {Code::SurfaceOutOfTolerance,
       {request.file.empty() ? file : request.file, request.line, 1},
       fmt::format(
           "the map of --surface is contradicted by {} of {}; the worst, {}, is {:+.1f} um off it",
           n_contradicting,
           count_of(n, "probe", "probes"),
           describe(request),
           off_um),
       fmt::format(
           "at most {:.1f} um, {:g} sigmas; or the map of this board", kMost * sigma_um, kMost)});
}

}  // namespace panelcal
