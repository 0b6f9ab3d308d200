// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/named_error.h"

#include <string>
#include <vector>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/base/statistics/plane_normal.h"
#include "calib/faults/finder.h"
#include "calib/panel/system.h"

namespace panelcal {
namespace {

/// The targets as a job measures them. Of a slot the other coordinate is where it is drawn.
std::vector<internal::ExaminedTarget> measured(const ErrorTrial& trial, Random& random) {
  const double noise_mm = trial.noise.in_mm();
  std::vector<internal::ExaminedTarget> out;
  for (std::size_t i = 0; i < trial.targets.size(); ++i) {
    const DesignTarget& target = trial.targets[i];
    Eigen::Vector2d off = internal::plane_root(target.cov) * internal::plane_normal(random);
    if (i == trial.i_target) off += trial.error;
    off = internal::observed_part(off, target.axes);
    const Eigen::Vector2d at_mm = target.nominal.in_mm();
    out.push_back({at_mm,
                   at_mm + noise_mm * off,
                   noise_mm * noise_mm * target.cov,
                   target.axes,
                   std::nullopt,
                   std::string(),
                   noise_mm * noise_mm * target.picture_cov.value_or(target.cov)});
  }
  return out;
}

bool is_refused(std::span<const internal::ExaminedTarget> targets, const ErrorTrial& trial) {
  std::vector<internal::RawPair> pairs;
  for (const internal::ExaminedTarget& target : targets) {
    pairs.push_back({target.from_mm, target.to_mm, target.cov_mm2, target.axes});
  }
  const internal::RawFitResult result = internal::fit_raw(pairs, trial.model);
  if (!result.fit) return false;
  std::vector<double> lengths_mm;
  Eigen::Vector2d deviation_mm = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    lengths_mm.push_back(result.fit->residuals_mm[i].norm());
    const Eigen::Vector2d fitted_mm =
        result.fit->linear * pairs[i].from_mm + result.fit->translation_mm;
    Eigen::Vector2d place_mm = pairs[i].to_mm;
    if (!observes_x(pairs[i].axes)) place_mm.x() = fitted_mm.x();
    if (!observes_y(pairs[i].axes)) place_mm.y() = fitted_mm.y();
    deviation_mm += (place_mm - pairs[i].from_mm) / static_cast<double>(pairs.size());
  }
  return !all_accepted(
      internal::check_gates_raw(result.fit->linear, deviation_mm, lengths_mm, trial.limits));
}

}  // namespace

ErrorTrials try_error(const ErrorTrial& trial, int n_trials, std::uint64_t seed) {
  ErrorTrials out;
  const Random seeds(seed);
  for (int t = 0; t < n_trials; ++t) {
    Random random = seeds.fork(static_cast<std::uint64_t>(t));
    const auto targets = measured(trial, random);
    FaultContext context{.limits = trial.limits};
    context.is_refused = is_refused(targets, trial);
    const auto fault = internal::find_fault_raw(targets, trial.model, context);
    ++out.n;
    if (!fault) continue;
    ++out.n_noticed;
    if (!fault->i_outlier) continue;
    ++(*fault->i_outlier == trial.i_target ? out.n_named : out.n_misnamed);
  }
  return out;
}

}  // namespace panelcal
