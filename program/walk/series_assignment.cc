// SPDX-License-Identifier: Apache-2.0
#include "program/walk/series_assignment.h"

#include <algorithm>

#include <fmt/format.h>

namespace panelcal {
namespace {

/// The places of a measurement; of one that lists none, what was found.
std::vector<MeasuredCandidate> candidates_of(const Measurement& measurement) {
  if (!measurement.candidates.empty() || measurement.status != MeasurementStatus::Found) {
    return measurement.candidates;
  }
  return {{measurement.measured,
           measurement.score.value_or(1),
           true,
           measurement.by_camera.value_or(CameraJacobian::Zero())}};
}

ConstellationTarget constellation_target(const Measurement& measurement, int turned_deg) {
  ConstellationTarget target;
  target.expected_mm = turned_by(measurement.request.expected.in_mm(), turned_deg);
  for (const MeasuredCandidate& c : candidates_of(measurement)) {
    target.candidates.push_back({c.place.position.in_mm(), c.place.cov, c.score, c.counts});
  }
  if (measurement.listed) {
    target.view_mm.emplace();
    std::ranges::transform(measurement.listed->corners,
                           target.view_mm->begin(),
                           [](const Position<frame::Actual>& p) { return p.in_mm(); });
    if (measurement.listed->radius) target.radius_mm = measurement.listed->radius->in_mm();
  }
  return target;
}

void choose(const MeasuredCandidate& candidate, Measurement& measurement) {
  const bool is_chosen = measurement.status == MeasurementStatus::Found &&
                         measurement.measured.position == candidate.place.position;
  // Repeated inspections may have enlarged its covariance.
  if (is_chosen) return;
  measurement.status = MeasurementStatus::Found;
  measurement.reason.clear();
  measurement.measured = candidate.place;
  measurement.score = candidate.score;
  if (!candidate.by_camera.isZero(0)) measurement.by_camera = candidate.by_camera;
}

std::string targets_text(const Combination& combination) {
  std::string places;
  std::string missing;
  for (std::size_t i = 0; i < combination.choice.size(); ++i) {
    const Eigen::Vector2d& at_mm = combination.predicted_mm[i];
    places += fmt::format("{}({:.3f}, {:.3f})", places.empty() ? "" : ", ", at_mm.x(), at_mm.y());
    if (combination.presence[i] == Presence::Matched) continue;
    missing += fmt::format(", target {} {}", i + 1, name(combination.presence[i]));
  }
  return fmt::format("shift ({:+.3f}, {:+.3f}) mm, targets at {} mm{}",
                     combination.shift_mm.x(),
                     combination.shift_mm.y(),
                     places,
                     missing);
}

std::string likelihood_text(double ratio) {
  if (ratio < 1.05) return "as likely";
  return ratio < 1e9 ? fmt::format("{:.2g} times less likely", ratio) : "far less likely";
}

}  // namespace

bool SeriesAssignment::is_certain() const {
  return found.is_exhaustive && !found.ranked.empty() &&
         1 - found.ranked.front().probability <= found.false_alarm;
}

std::string SeriesAssignment::text() const {
  if (found.ranked.empty()) return "no pair of candidates matches the drawing";
  const Combination& best = found.ranked.front();
  std::string out = targets_text(best);
  const bool is_outside = found.ranked.size() == 1 || found.outside > found.ranked[1].probability;
  if (is_outside && found.outside > found.false_alarm) {
    return out + "; or farther away than the pictures show, which is less than the search radius";
  }
  if (found.ranked.size() == 1) return out + "; no other combination fits";
  const double ratio = best.probability / std::max(found.ranked[1].probability, 1e-300);
  return fmt::format("{}; or {}, {}", out, targets_text(found.ranked[1]), likelihood_text(ratio));
}

std::optional<SeriesAssignment> assign_series(std::span<const Measurement> measurements,
                                              const GateLimits& limits) {
  const bool can_choose = std::ranges::any_of(measurements, &Measurement::has_choice);
  const bool has_slots = std::ranges::any_of(
      measurements, [](const Measurement& m) { return m.request.axes != ObservedAxes::Both; });
  if (measurements.size() < 2 || !can_choose || has_slots) return std::nullopt;
  std::vector<ConstellationTarget> targets;
  SeriesAssignment out;
  for (const Measurement& measurement : measurements) {
    targets.push_back(constellation_target(measurement, limits.turned_deg));
    out.n_candidates.push_back(static_cast<std::size_t>(
        std::ranges::count(targets.back().candidates, true, &ConstellationCandidate::counts)));
  }
  out.found = assign_jointly(targets, {.limits = limits});
  return out;
}

void settle(const SeriesAssignment& assignment, std::span<Measurement> measurements) {
  const bool is_certain = assignment.is_certain();
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    Measurement& measurement = measurements[i];
    const std::vector<MeasuredCandidate> candidates = candidates_of(measurement);
    const bool may_be_one = std::ranges::any_of(candidates, &MeasuredCandidate::counts);
    if (!may_be_one) continue;  // its picture said why
    if (!is_certain) {
      measurement.status = MeasurementStatus::Ambiguous;
      measurement.reason = "the series can be assigned in several ways";
      continue;
    }
    const Combination& best = assignment.found.ranked.front();
    if (best.choice[i]) {
      choose(candidates[*best.choice[i]], measurement);
      continue;
    }
    const Eigen::Vector2d& at_mm = best.predicted_mm[i];
    measurement.status = MeasurementStatus::NotFound;
    measurement.reason = fmt::format(
        "the others have it at ({:.3f}, {:.3f}) mm, where it is {}; its picture shows "
        "{} like it elsewhere",
        at_mm.x(),
        at_mm.y(),
        name(best.presence[i]),
        assignment.n_candidates[i] == 1 ? std::string("one mark")
                                        : fmt::format("{} marks", assignment.n_candidates[i]));
  }
}

}  // namespace panelcal
