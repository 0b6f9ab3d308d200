// SPDX-License-Identifier: Apache-2.0
// Are predicted ellipses the real ones, over whole jobs? The full table is made by
// tests/bench/honesty_bench.
#include <string>

#include <gtest/gtest.h>

#include "tests/program/honesty/honesty_trial.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

using test::Coverage;
using test::HonestyResult;
using test::HonestyTrial;
using test::kStatisticalLimit;

constexpr int kJobs = 400;

void expect_honest(const Coverage& coverage) {
  EXPECT_GT(coverage.n_holes, kJobs);
  EXPECT_NEAR(coverage.share, 0.95, kStatisticalLimit * coverage.sigma);
}

class HonestModel : public testing::TestWithParam<PanelModel> {};

TEST_P(HonestModel, EllipsesHoldTheTruthInsideAndOutsideTheHull) {
  for (const bool has_nested : {false, true}) {
    SCOPED_TRACE(has_nested ? "base and nested" : "base");
    const HonestyResult result = test::run({.model = GetParam(),
                                            .detector_um = 3,
                                            .has_nested = has_nested,
                                            .n_jobs = kJobs,
                                            .seed = 20261121});
    EXPECT_EQ(result.n_failed, 0);
    expect_honest(result.all);
    expect_honest(result.outside);
    EXPECT_LT(result.all.sigma, 0.01);  // so that one in a hundred would be seen
    EXPECT_TRUE(
        test::chi_square_agrees(result.chi_square, static_cast<int>(result.degrees_of_freedom)));
  }
}

INSTANTIATE_TEST_SUITE_P(Every,
                         HonestModel,
                         testing::Values(PanelModel::Offset,
                                         PanelModel::Rigid,
                                         PanelModel::Similarity,
                                         PanelModel::Stretch,
                                         PanelModel::Affine),
                         [](const auto& model) {
                           return std::string(panelcal::name(model.param));
                         });

TEST(Honesty, IsLostWhereTheMachineIsNotStated) {
  // That the test above would notice: pictures alone promise far too much.
  const HonestyResult result =
      test::run({.detector_um = 3, .n_jobs = kJobs, .seed = 20261121, .hides_machine = true});
  EXPECT_LT(result.all.share, 0.8);
  EXPECT_GT(result.chi_square, 1.2 * static_cast<double>(result.degrees_of_freedom));
}

}  // namespace
}  // namespace panelcal
