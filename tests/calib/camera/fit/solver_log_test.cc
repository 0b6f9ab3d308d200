// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/fit/solver_log.h"

#include <limits>

#include <ceres/ceres.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

class NoNumber final : public ceres::SizedCostFunction<1, 1> {
 public:
  bool Evaluate(const double* const* /*in*/, double* out, double** /*jacobians*/) const override {
    out[0] = std::numeric_limits<double>::quiet_NaN();
    return true;
  }
};

/// Text of a solver on standard error for a problem without a solution.
std::string said() {
  double parameter = 1;
  ceres::Problem problem;
  problem.AddResidualBlock(new NoNumber, nullptr, &parameter);
  testing::internal::CaptureStderr();
  double cost = 0;
  EXPECT_FALSE(problem.Evaluate({}, &cost, nullptr, nullptr, nullptr));
  return testing::internal::GetCapturedStderr();
}

TEST(SolverLog, KeepsTheSolverOffStandardError) {
  EXPECT_THAT(said(), testing::HasSubstr("ResidualBlock"));
  silence_solver_log();
  EXPECT_EQ(said(), "");
}

}  // namespace
}  // namespace panelcal
