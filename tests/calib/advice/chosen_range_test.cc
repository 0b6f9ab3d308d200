// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/chosen_range.h"

#include <algorithm>
#include <vector>

#include "calib/base/random.h"
#include "calib/panel/model_choice.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

using ChosenPlace = Position<frame::Nominal>;

constexpr double kSigma_mm = 2e-3;

std::vector<DesignTarget> six_targets() {
  std::vector<DesignTarget> out;
  for (const auto& [x, y] : {std::pair{5.0, 5.0},
                             {290.0, 10.0},
                             {280.0, 190.0},
                             {10.0, 185.0},
                             {150.0, 20.0},
                             {140.0, 180.0}}) {
    out.push_back({position_mm<frame::Nominal>(x, y)});
  }
  return out;
}

const std::vector<ChosenPlace> kHoleCorners = {position_mm<frame::Nominal>(0, 0),
                                               position_mm<frame::Nominal>(300, 0),
                                               position_mm<frame::Nominal>(300, 200),
                                               position_mm<frame::Nominal>(0, 200)};

/// The greatest leverage that a job states of a panel whose map is `linear`.
double stated_leverage(const std::vector<DesignTarget>& design,
                       const Eigen::Matrix2d& linear,
                       Random& random) {
  std::vector<TargetPair<frame::Base, frame::Nominal>> pairs;
  for (const DesignTarget& target : design) {
    const Eigen::Vector2d seen_mm = linear * target.nominal.in_mm() +
                                    kSigma_mm * Eigen::Vector2d(random.normal(), random.normal());
    pairs.push_back(
        {target.nominal,
         {position_mm<frame::Base>(seen_mm), kSigma_mm * kSigma_mm * Eigen::Matrix2d::Identity()}});
  }
  const std::span<const TargetPair<frame::Base, frame::Nominal>> all(pairs);
  const auto scores = compare_models(all, PanelModel::Stretch);
  const auto fit = fit_chosen(all, scores).fit;
  if (!fit) return NAN;
  const LeverageMap leverage(fit->map.cov);
  double worst = 0;
  for (const ChosenPlace& corner : kHoleCorners) worst = std::max(worst, leverage(corner));
  return worst / kSigma_mm;
}

/// Panels of sizes of deformation that the range was not made from.
TEST(ChosenRange, HoldsNineOfTenJobs) {
  const std::vector<DesignTarget> design = six_targets();
  const auto range = chosen_range({.targets = design, .corners = kHoleCorners});
  ASSERT_TRUE(range);
  EXPECT_LT(range->low, range->high);
  Random random(23);
  for (const double size : {0.0, 1.0, 2.0, 5.0, 100.0}) {
    int n_inside = 0;
    constexpr int kJobs = 200;
    for (int job = 0; job < kJobs; ++job) {
      // So many noises at 150 mm from the middle; rotated beyond doubt.
      const double part = size * kSigma_mm / 150;
      Eigen::Matrix2d linear;
      linear << 1 + part, -1e-3 + random.uniform(-part, part), 1e-3, 1 - random.uniform(0, part);
      const double leverage = stated_leverage(design, linear, random);
      n_inside += leverage >= range->low * (1 - 1e-9) && leverage <= range->high * (1 + 1e-9);
    }
    // Within 4 sigma of nine in ten, of 200 jobs.
    EXPECT_GE(n_inside, 163) << size;
  }
}

TEST(ChosenRange, ReachesFromTheStiffestModelToBeyondTheSoftest) {
  const std::vector<DesignTarget> design = six_targets();
  const auto range = chosen_range({.targets = design, .corners = kHoleCorners});
  ASSERT_TRUE(range);
  const auto worst = [&](PanelModel model) {
    const LeverageMap leverage(predict_fit(design, model).fit->cov);
    double out = 0;
    for (const ChosenPlace& corner : kHoleCorners) out = std::max(out, leverage(corner));
    return out;
  };
  EXPECT_LT(range->low, worst(PanelModel::Rigid));
  EXPECT_GE(range->low, worst(PanelModel::Offset) * (1 - 1e-6));
  EXPECT_GE(range->high, worst(PanelModel::Affine) * (1 - 1e-6));
  EXPECT_LT(range->high, 2 * worst(PanelModel::Affine));
}

TEST(ChosenRange, IsAbsentWithoutTargets) {
  EXPECT_FALSE(chosen_range({.targets = {}, .corners = kHoleCorners}));
}

}  // namespace
}  // namespace panelcal
