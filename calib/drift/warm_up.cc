// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/warm_up.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "calib/base/statistics/chi_square.h"
#include "calib/drift/decay.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Samples of which chance would give so few as scatter like these do not follow an exponential.
constexpr double kMinWarmUpChance = 1e-6;

std::optional<WarmUp> no_warm_up(std::string* reason, std::string text) {
  if (reason != nullptr) *reason = std::move(text);
  return std::nullopt;
}

}  // namespace

std::optional<WarmUp> fit_warm_up(std::span<const WarmUpSample> samples,
                                  double limit,
                                  std::string* reason) {
  if (!(limit > 0)) return no_warm_up(reason, "the limit of a warm-up is not above 0");
  std::vector<internal::DecaySample> decaying;
  double last_s = 0;
  for (const WarmUpSample& s : samples) {
    decaying.push_back({s.since_start.in_s(), s.value, s.sigma});
    last_s = std::max(last_s, s.since_start.in_s());
  }
  const auto decay = internal::fit_decay(decaying, false, reason);
  if (!decay) return std::nullopt;
  if (decay->degrees_of_freedom < 1 ||
      !(chi_square_exceedance(decay->chi_square, decay->degrees_of_freedom) >= kMinWarmUpChance)) {
    return no_warm_up(reason, "the samples do not follow an exponential within their sigmas");
  }
  WarmUp out;
  out.warm = decay->rest;
  out.cold_offset = decay->cosine;
  out.is_seen = decay->shape != internal::DecayShape::Still;
  if (!out.is_seen) return out;
  const internal::DecayTime time = internal::time_to(*decay, limit);
  if (time.time > last_s) {
    return no_warm_up(
        reason,
        fmt::format("the samples end after {:.0f} min, and the machine is warm after about "
                    "{:.0f} min",
                    last_s / 60,
                    time.time / 60));
  }
  out.time_constant = seconds(decay->time_constant);
  out.time_constant_sigma = seconds(decay->time_constant * std::sqrt(decay->cov(0, 0)));
  out.wait = seconds(time.time);
  out.wait_sigma = seconds(time.sigma);
  return out;
}

}  // namespace panelcal
