// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "calib/charts/cusum.h"
#include "calib/charts/ewma.h"
#include "calib/drift/model.h"

#include "tests/bench/drift/year.h"

namespace panelcal::bench {

/// The charts that together are one rule.
struct Method {
  std::string_view name;
  bool has_night = false;
  bool has_average = false;
  bool has_sum = false;
  bool has_moved = false;
  double nights_per_false_alarm = 1000;
};

/// A night as charts see it.
struct Look {
  bool is_judged = false;
  Eigen::VectorXd scores;   ///< independent and standard normal while nothing happens
  Eigen::VectorXd here_mm;  ///< the model's estimate after the night; of offsets
};

/// Learns a channel night by night. What the charts say does not come back into the model.
class Learner {
 public:
  explicit Learner(Channel channel);
  Look add(const Year::Night& night);

 private:
  Channel channel_;
  DriftModel model_;
  SpreadMonitor spread_;
};

/// The charts of a method, each with its share of the false alarms: half to single nights if there
/// are others, the rest in equal parts. All start again after an alarm.
class Detector {
 public:
  Detector(const Method& method, Channel channel, double nights_per_false_alarm);
  bool add(const Look& look);

 private:
  bool has_moved(const Look& look);

  bool looks_up_only_;
  std::optional<double> night_limit_;
  std::optional<EwmaChart> average_;
  std::vector<CusumChart> sums_;
  bool watches_moves_;
  std::optional<Eigen::VectorXd> anchor_mm_;
};

}  // namespace panelcal::bench
