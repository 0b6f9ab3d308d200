// SPDX-License-Identifier: Apache-2.0
#include "calib/charts/ewma.h"

#include <cmath>

#include "calib/charts/run_length.h"

namespace panelcal {

EwmaChart::EwmaChart(int n_axes, double weight, double nights_per_false_alarm)
    : weight_(weight),
      sigma_(std::sqrt(weight / (2 - weight))),
      limit_(ewma_limit(n_axes, weight, nights_per_false_alarm)),
      average_(Eigen::VectorXd::Zero(n_axes)) {
}

bool EwmaChart::add(const Eigen::VectorXd& scores) {
  average_ = (1 - weight_) * average_ + weight_ * scores;
  // Written so that what is not a number alarms.
  return !(statistic() <= limit_);
}

}  // namespace panelcal
