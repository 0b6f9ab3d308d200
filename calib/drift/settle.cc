// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/settle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "calib/base/statistics/chi_square.h"
#include "calib/drift/decay.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::Decay;
using internal::DecaySample;
using internal::DecayShape;

/// Views of which chance would give so few as scatter like these are not described by a decay.
constexpr double kMinSettleChance = 1e-6;
/// A motion as large as this number of standard deviations of the mean view is seen for certain.
constexpr double kSeen = 5;
/// A wait that is too short blurs every picture, one that is too long costs milliseconds.
constexpr double kBoundSigmas = 4;

std::optional<SettleTime> no_settle_time(std::string* reason, std::string text) {
  if (reason != nullptr) *reason = std::move(text);
  return std::nullopt;
}

SettleMotion motion_of(DecayShape shape) {
  switch (shape) {
    case DecayShape::Exponential:
      return SettleMotion::Creeping;
    case DecayShape::Oscillation:
      return SettleMotion::Vibrating;
    default:
      return SettleMotion::Still;
  }
}

double frequency_hz_of(const Decay& decay) {
  return std::abs(decay.frequency) / (2 * std::numbers::pi);
}

/// The bound over all motions that the views allow, and which ones those are.
void take_bound(const std::vector<Decay>& decays, Length limit, SettleTime& out) {
  const double scatter = std::sqrt(decays.front().variance());
  for (const Decay& decay : decays) {
    const internal::DecayTime time = internal::time_to(decay, limit.in_mm());
    out.bound = std::max(out.bound, seconds(time.time + kBoundSigmas * scatter * time.sigma));
    if (&decay == &decays.front()) continue;
    out.aliases.push_back({seconds(time.time), frequency_hz_of(decay)});
  }
}

}  // namespace

std::optional<SettleTime> fit_settle(std::span<const SettleView> views,
                                     Length limit,
                                     std::string* reason) {
  if (!(limit > mm(0))) return no_settle_time(reason, "the limit of a settle time is not above 0");
  std::vector<DecaySample> samples;
  double last_s = 0;
  double first_s = std::numeric_limits<double>::infinity();
  double best_sigma_mm = std::numeric_limits<double>::infinity();
  for (const SettleView& view : views) {
    const double sigma_mm = std::sqrt(0.5 * view.seen.cov.trace());
    samples.push_back({view.since_move.in_s(), view.seen.position.in_mm(), sigma_mm});
    last_s = std::max(last_s, view.since_move.in_s());
    if (view.since_move > Time()) first_s = std::min(first_s, view.since_move.in_s());
    best_sigma_mm = std::min(best_sigma_mm, sigma_mm);
  }
  const std::vector<Decay> decays = internal::fit_decays(samples, true, reason);
  if (decays.empty()) return std::nullopt;
  const Decay* const decay = &decays.front();
  if (decay->degrees_of_freedom < 2)
    return no_settle_time(reason, "the views are too few for a decay");
  if (!(chi_square_exceedance(decay->chi_square, decay->degrees_of_freedom) >= kMinSettleChance)) {
    return no_settle_time(
        reason,
        fmt::format("the views scatter {:.1f} times their stated sigma, and not as a decay",
                    std::sqrt(decay->chi_square / decay->degrees_of_freedom)));
  }
  SettleTime out;
  out.motion = motion_of(decay->shape);
  if (out.motion == SettleMotion::Still) {
    if (best_sigma_mm * kSeen > limit.in_mm()) {
      return no_settle_time(reason,
                            fmt::format("the views' sigma of {:.1f} um hides a motion of {:.1f} um",
                                        best_sigma_mm * 1e3,
                                        limit.in_um()));
    }
    out.sigma = seconds(0.5 * first_s);
    return out;
  }
  const internal::DecayTime time = internal::time_to(*decay, limit.in_mm());
  if (time.time > last_s) {
    return no_settle_time(
        reason,
        fmt::format("the last view, after {:.3f} s, is from before the mark is at rest; that "
                    "takes about {:.3f} s",
                    last_s,
                    time.time));
  }
  out.wait = seconds(time.time);
  out.sigma = seconds(std::sqrt(decay->variance()) * time.sigma);
  take_bound(decays, limit, out);
  out.time_constant = seconds(decay->time_constant);
  out.frequency_hz = frequency_hz_of(*decay);
  out.amplitude = mm(decay->amplitude());
  return out;
}

}  // namespace panelcal
