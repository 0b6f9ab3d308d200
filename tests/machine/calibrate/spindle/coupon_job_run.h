// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "machine/sim/sim_machine.h"
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/machine/calibrate/spindle/coupon_job.h"
#include "tests/machine/virtual_machine.h"

namespace panelcal::test {

/// Five sigmas of a located hole, which is 0.2 um in these pictures.
inline constexpr Length kLocated = um(1);
/// Of two squared standard scores: passed by one healthy job in 20,000.
inline constexpr double kMostSquare = 20;

inline constexpr std::string_view kCoupon = R"([sim.coupon]
drill_wander_um = 3
stage_repeatability_um = 1
[coupon]
origin_mm = [300, 100]
rows_per_run = 3
)";

/// A machine whose offset is 30 and 20 um off what its file says.
inline MachineConfig machine_with_coupon(const TemporaryFolder& folder,
                                         const std::string& more = "") {
  auto config = coupon_machine(folder.path(), more + std::string(kCoupon));
  EXPECT_TRUE(config) << config.error().text();
  return std::move(config).value();
}

inline std::string excellon_program(std::string_view body) {
  return "M48\nMETRIC,TZ\nFMAT,2\nVER,1\nT1C0.8\n%\nG90\nG34,1\n" + std::string(body) + "M30\n";
}

struct SimulatedJob {
  Survey survey;
  DiagnosticLog log;
  std::vector<Hole> holes;
};

inline SimulatedJob run_job(const Program& program,
                            const MachineConfig& config,
                            MeasurementSource& source) {
  SimulatedJob job;
  job.survey = survey(program, config.walk, source, job.log);
  if (job.log.has_errors()) return job;
  HoleSink sink;
  execute(program, config.walk, job.survey, sink, job.log);
  job.holes = sink.holes();
  return job;
}

inline SimulatedJob run_simulated(const std::string& text, const MachineConfig& config) {
  const Program program = program_of(text);
  auto machine = SimMachine::create(config, program);
  EXPECT_TRUE(machine) << machine.error().text();
  return run_job(program, config, *machine);
}

/// Error of a measured place: the simulated panel lies as it is drawn.
inline Eigen::Vector2d error_mm(const Measurement& m) {
  return m.measured.position.in_mm() - m.request.nominal.in_mm();
}

/// Squared error of a measured place by its covariance.
inline double squared_score(const Measurement& m, const CalibrationAnswer& calibration) {
  const Eigen::Matrix2d cov_mm2 = m.measured.cov + calibration.offset->cov_mm2;
  return error_mm(m).dot(cov_mm2.inverse() * error_mm(m));
}

}  // namespace panelcal::test
