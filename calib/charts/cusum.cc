// SPDX-License-Identifier: Apache-2.0
#include "calib/charts/cusum.h"

#include "calib/charts/run_length.h"

namespace panelcal {

// The rates of two sums add up, for they never alarm in the same night (van Dobben de Bruyn 1968).
CusumChart::CusumChart(Shift shift, double allowance, double nights_per_false_alarm)
    : shift_(shift),
      allowance_(allowance),
      limit_(cusum_limit(
          allowance, shift == Shift::Both ? 2 * nights_per_false_alarm : nights_per_false_alarm)) {
}

bool CusumChart::add(double score) {
  // Written so that what is not a number stays and alarms.
  const auto positive = [](double v) { return v < 0 ? 0 : v; };
  up_ = positive(up_ + score - allowance_);
  if (shift_ == Shift::Both) down_ = positive(down_ - score - allowance_);
  n_up_ = up_ > 0 ? n_up_ + 1 : 0;
  n_down_ = down_ > 0 ? n_down_ + 1 : 0;
  return !(up_ <= limit_ && down_ <= limit_);
}

}  // namespace panelcal
