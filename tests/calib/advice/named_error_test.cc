// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/named_error.h"

#include <vector>

#include "calib/advice/noticed_error.h"
#include "calib/base/random.h"
#include "calib/faults/finder.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

constexpr double kErrorNoise_um = 5;

std::vector<DesignTarget> spread_design(int n) {
  Random random(3);
  std::vector<DesignTarget> out;
  for (int i = 0; i < n; ++i) {
    out.push_back({position_mm<frame::Nominal>(random.uniform(0, 300), random.uniform(0, 300))});
  }
  return out;
}

ErrorTrials trials_of(const std::vector<DesignTarget>& design,
                      PanelModel model,
                      const Eigen::Vector2d& error,
                      int n = 200) {
  return try_error({.targets = design,
                    .model = model,
                    .noise = um(kErrorNoise_um),
                    .limits = default_gate_limits(),
                    .i_target = 1,
                    .error = error},
                   n,
                   11);
}

TEST(NamedError, HealthySeriesAreLeftAlone) {
  const ErrorTrials trials =
      trials_of(spread_design(6), PanelModel::Similarity, Eigen::Vector2d::Zero(), 2000);
  EXPECT_EQ(trials.n, 2000);
  // A false alarm in 1,000: 7 or more of 2,000 come with a chance below 0.5 %.
  EXPECT_LT(trials.n_noticed, 7);
  EXPECT_LE(trials.n_named + trials.n_misnamed, trials.n_noticed);
}

TEST(NamedError, TakesMoreTargetsThanNoticingDoes) {
  // One equation to spare: any target might be the one.
  const ErrorTrials three =
      trials_of(spread_design(3), PanelModel::Stretch, Eigen::Vector2d(200, 0));
  EXPECT_EQ(three.n_noticed, three.n);
  EXPECT_EQ(three.n_named, 0);
  const ErrorTrials eight =
      trials_of(spread_design(8), PanelModel::Similarity, Eigen::Vector2d(12, 0));
  EXPECT_EQ(eight.n_noticed, eight.n);
  EXPECT_GT(eight.n_named, 180);
}

TEST(NamedError, TakesALargerErrorThanNoticingDoes) {
  const std::vector<DesignTarget> design = spread_design(6);
  const auto fit = predict_fit(design, PanelModel::Similarity).fit;
  ASSERT_TRUE(fit);
  const auto errors = noticed_errors(design, *fit, um(kErrorNoise_um), default_gate_limits());
  ASSERT_TRUE(errors[1].from);
  const Eigen::Vector2d once = *errors[1].from * errors[1].direction;
  const ErrorTrials at_once = trials_of(design, PanelModel::Similarity, once);
  const ErrorTrials at_twice = trials_of(design, PanelModel::Similarity, 2 * once);
  // The sentence "noticed, and which one it is" would be false: 80 % is the share noticed.
  EXPECT_LT(at_once.named_share(), 0.4);
  EXPECT_GT(at_twice.named_share(), 0.8);
}

/// The same jobs by the public fit and finder, with noise of its own: shares of 400 trials differ
/// by no more than 4 sigma of both, 0.14.
TEST(NamedError, IsNamedAsOftenAsByTheFinderOfAJob) {
  const std::vector<DesignTarget> design = spread_design(6);
  const double sigma_mm = kErrorNoise_um * 1e-3;
  const Eigen::Vector2d error(9, 0);
  Random random(99);
  constexpr int kJobs = 400;
  int n_named = 0;
  for (int job = 0; job < kJobs; ++job) {
    std::vector<ExaminedTarget<frame::Base, frame::Nominal>> targets;
    for (std::size_t i = 0; i < design.size(); ++i) {
      Eigen::Vector2d seen_mm = design[i].nominal.in_mm();
      seen_mm += sigma_mm * Eigen::Vector2d(random.normal(), random.normal());
      if (i == 1) seen_mm += sigma_mm * error;
      targets.push_back({.pair = {design[i].nominal,
                                  {position_mm<frame::Base>(seen_mm),
                                   sigma_mm * sigma_mm * Eigen::Matrix2d::Identity()}},
                         .score = 0.95,
                         .name = "target"});
    }
    const auto fault =
        find_fault(std::span<const ExaminedTarget<frame::Base, frame::Nominal>>(targets),
                   PanelModel::Affine,
                   {.limits = default_gate_limits()});
    if (fault && fault->i_outlier && *fault->i_outlier == 1) ++n_named;
  }
  const ErrorTrials trials = trials_of(design, PanelModel::Affine, error, kJobs);
  EXPECT_GT(n_named, 20);
  EXPECT_LT(n_named, 380);
  EXPECT_NEAR(trials.named_share(), n_named / double{kJobs}, 0.14);
}

}  // namespace
}  // namespace panelcal
