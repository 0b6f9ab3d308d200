// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cmath>
#include <optional>

#include "calib/base/statistics/random.h"
#include "calib/drift/series.h"
#include <Eigen/Cholesky>

namespace panelcal::test {

/// A machine whose offset moves as the model says; one standard deviation each, mm.
struct SimulatedMachine {
  double drift = 0.0005;  ///< per square root of a day
  double repeatability = 0.0007;
  double stated = 0.001;     ///< of a night's calibration
  double correlation = 0.3;  ///< of its errors in x and y
  double x_per_kelvin = 0.0015;
  double temperature_sigma = 2;  ///< kelvin about 21 C
};

/// Truth and measurement, night by night.
class SimulatedNights {
 public:
  SimulatedNights(const SimulatedMachine& machine, Random random)
      : machine_(machine), random_(random) {}

  /// The next night, a day after the last; `fault` is added to the truth.
  DriftPoint next(const Eigen::Vector2d& fault = Eigen::Vector2d::Zero()) {
    constexpr std::chrono::seconds kDay(86400);
    time_ += kDay;
    walk_ += machine_.drift * Eigen::Vector2d(random_.normal(), random_.normal());
    DriftPoint point;
    point.time = time_;
    point.temperature_c = 21 + machine_.temperature_sigma * random_.normal();
    point.cov.resize(2, 2);
    point.cov << 1, machine_.correlation, machine_.correlation, 1;
    point.cov *= machine_.stated * machine_.stated;
    truth_ = Eigen::Vector2d(51.2, -3.7) + walk_ + fault;
    truth_.x() += machine_.x_per_kelvin * (*point.temperature_c - 20);
    const Eigen::Vector2d unit(random_.normal(), random_.normal());
    point.value = truth_ + Eigen::LLT<Eigen::MatrixXd>(point.cov).matrixL() * unit +
                  machine_.repeatability * Eigen::Vector2d(random_.normal(), random_.normal());
    return point;
  }

  /// True value of the last night.
  const Eigen::Vector2d& truth() const { return truth_; }

 private:
  SimulatedMachine machine_;
  Random random_;
  std::chrono::sys_seconds time_{std::chrono::seconds(1'790'000'000)};
  Eigen::Vector2d walk_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d truth_ = Eigen::Vector2d::Zero();
};

}  // namespace panelcal::test
