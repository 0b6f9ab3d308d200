// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/recheck.h"

#include <algorithm>
#include <array>
#include <vector>

#include "calib/base/statistics/chi_square.h"
#include "machine/look/picture_locator.h"
#include <Eigen/Dense>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr std::size_t kMaxCompared = 2000;

bool may_be_compared(const Measurement& measurement) {
  const Decider by = measurement.decision.by;
  return measurement.status == MeasurementStatus::Found &&
         measurement.request.axes == ObservedAxes::Both &&
         (by == Decider::Source || by == Decider::Camera);
}

}  // namespace

std::optional<std::pair<std::size_t, std::size_t>> farthest_pair(
    std::span<const Measurement> measured) {
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < measured.size() && usable.size() < kMaxCompared; ++i) {
    if (may_be_compared(measured[i])) usable.push_back(i);
  }
  std::optional<std::pair<std::size_t, std::size_t>> best;
  double greatest_mm = 0;
  for (std::size_t i = 0; i < usable.size(); ++i) {
    for (std::size_t k = i + 1; k < usable.size(); ++k) {
      const Displacement<frame::Nominal> apart =
          measured[usable[i]].request.nominal - measured[usable[k]].request.nominal;
      const double distance_mm = apart.in_mm().norm();
      if (!(distance_mm > greatest_mm)) continue;
      greatest_mm = distance_mm;
      best = {usable[i], usable[k]};
    }
  }
  return best;
}

Expected<Recheck> look_again(const Measurement& first,
                             const Measurement& second,
                             const Survey& nominal,
                             const MachineUncertainty& machine,
                             MeasurementSource& source) {
  double chi_square = 0;
  double greatest_um = 0;
  for (const Measurement* const before : {&first, &second}) {
    const auto i = static_cast<std::size_t>(before->request.seq);
    if (i >= nominal.measurements.size()) return Recheck{false, "the program has changed"};
    MeasurementRequest request = nominal.measurements[i].request;
    request.expected = before->request.expected;
    PANELCAL_TRY(const Measurement now, source.measure(request));
    if (now.status != MeasurementStatus::Found) {
      return Recheck{false, fmt::format("{} is not found again", describe(request))};
    }
    const Eigen::Vector2d apart_mm =
        now.measured.position.in_mm() - before->measured.position.in_mm();
    const Eigen::Matrix2d cov_mm2 =
        before->measured.cov + now.measured.cov + 2 * machine.stage_mm2();
    chi_square += apart_mm.dot(cov_mm2.ldlt().solve(apart_mm));
    greatest_um = std::max(greatest_um, 1e3 * apart_mm.norm());
  }
  constexpr int kDegreesOfFreedom = 4;
  const double chance = chi_square_exceedance(chi_square, kDegreesOfFreedom);
  // Written so that what is no number does not agree.
  const bool agrees = chance >= kMovedChance;
  return Recheck{agrees,
                 fmt::format("two targets looked at again: moved by at most {:.1f} um, chi-square "
                             "{:.1f} with {} degrees of freedom, limit {:.1f} (p = {:g})",
                             greatest_um,
                             chi_square,
                             kDegreesOfFreedom,
                             chi_square_limit(kMovedChance, kDegreesOfFreedom),
                             kMovedChance)};
}

}  // namespace panelcal::internal
