// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/sector_turns.h"

#include <algorithm>
#include <cstddef>

namespace panelcal::internal {

std::vector<double> wave_powers(const Eigen::VectorXd& values,
                                const std::vector<char>& use,
                                int first,
                                int last) {
  Eigen::VectorXd used = values;
  for (std::size_t i = 0; i < use.size(); ++i) {
    if (use[i] == 0) used[static_cast<Eigen::Index>(i)] = 0;
  }
  const auto n_used = use.empty()
                          ? values.size()
                          : std::ranges::count_if(use, [](char is_used) { return is_used != 0; });
  const SectorTurns turns(values.size());
  std::vector<double> powers;
  for (int k = first; k <= last; ++k) {
    double cosine = 0;
    double sine = 0;
    turns.for_each(k, [&](Eigen::Index i, const std::complex<double>& turn) {
      cosine += used[i] * turn.real();
      sine += used[i] * turn.imag();
    });
    const double power = cosine * cosine + sine * sine;
    powers.push_back(n_used > 0 ? power / static_cast<double>(n_used) : 0);
  }
  return powers;
}

}  // namespace panelcal::internal
