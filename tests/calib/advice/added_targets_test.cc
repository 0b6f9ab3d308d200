// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/added_targets.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/advice/convex_hull.h"
#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

namespace panelcal {
namespace {

using NominalPlace = Position<frame::Nominal>;

NominalPlace place(double x_mm, double y_mm) {
  return position_mm<frame::Nominal>(x_mm, y_mm);
}

std::vector<DesignTarget> targets_at(std::initializer_list<NominalPlace> places) {
  std::vector<DesignTarget> targets;
  for (const NominalPlace& p : places) targets.push_back({p});
  return targets;
}

const std::vector<NominalPlace> kCorners = {
    place(0, 0), place(300, 0), place(300, 300), place(0, 300)};

std::vector<NominalPlace> random_places(int n, std::uint64_t seed) {
  Random random(seed);
  std::vector<NominalPlace> out;
  for (int i = 0; i < n; ++i) out.push_back(place(random.uniform(0, 300), random.uniform(0, 300)));
  return out;
}

/// Straight from predict_fit, for designs that determine the model.
double worst_with(const std::vector<DesignTarget>& targets,
                  const std::vector<NominalPlace>& added,
                  const std::vector<NominalPlace>& holes,
                  PanelModel model) {
  std::vector<DesignTarget> all = targets;
  for (const NominalPlace& p : added) all.push_back({p});
  const auto result = predict_fit(all, model);
  if (!result.fit) return std::numeric_limits<double>::infinity();
  const LeverageMap leverage(result.fit->cov);
  double worst = 0;
  for (const NominalPlace& hole : holes) worst = std::max(worst, leverage(hole));
  return worst;
}

TEST(AddedTargets, FourthCornerCompletesThree) {
  const auto three = targets_at({kCorners[0], kCorners[1], kCorners[3]});
  std::vector<NominalPlace> candidates = random_places(50, 1);
  candidates.push_back(kCorners[2]);
  const Addition best = best_additions({.model = PanelModel::Affine,
                                        .targets = three,
                                        .candidates = candidates,
                                        .corners = kCorners},
                                       1);
  ASSERT_EQ(best.chosen.size(), 1u);
  EXPECT_EQ(best.chosen[0], 50u);
  EXPECT_NEAR(best.worst_before.value_or(0), std::sqrt(3), 1e-9);
  EXPECT_NEAR(best.worst_after.value_or(0), std::sqrt(0.75), 1e-9);
}

TEST(AddedTargets, SingleTargetIsTheBestOfAll) {
  for (const PanelModel model : {PanelModel::Rigid, PanelModel::Stretch, PanelModel::Affine}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const auto places = random_places(3, seed);
      const auto targets = targets_at({places[0], places[1], places[2]});
      const auto candidates = random_places(60, 100 + seed);
      const auto holes = random_places(200, 200 + seed);
      const auto corners = convex_hull(holes);
      const Addition best = best_additions(
          {.model = model, .targets = targets, .candidates = candidates, .corners = corners}, 1);
      double least = std::numeric_limits<double>::infinity();
      for (const NominalPlace& p : candidates) {
        least = std::min(least, worst_with(targets, {p}, holes, model));
      }
      ASSERT_TRUE(best.worst_after);
      EXPECT_NEAR(*best.worst_after, least, 1e-6 * least) << name(model) << " seed " << seed;
    }
  }
}

TEST(AddedTargets, TwoTogetherAreTheBestPairOfAll) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto places = random_places(3, seed);
    const auto targets = targets_at({places[0], places[1], places[2]});
    const auto candidates = random_places(25, 100 + seed);
    const Addition best = best_additions({.model = PanelModel::Affine,
                                          .targets = targets,
                                          .candidates = candidates,
                                          .corners = kCorners},
                                         2);
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      for (std::size_t j = i + 1; j < candidates.size(); ++j) {
        least = std::min(
            least,
            worst_with(targets, {candidates[i], candidates[j]}, kCorners, PanelModel::Affine));
      }
    }
    ASSERT_TRUE(best.worst_after);
    EXPECT_NEAR(*best.worst_after, least, 1e-6 * least) << "seed " << seed;
  }
}

/// The continuous D-optimal design of a plane over a square has equal weight in its corners, and is
/// G-optimal (Kiefer and Wolfowitz 1960): four times as many targets in the corners, worst^2 = 3/n.
TEST(AddedTargets, ManyTargetsReachTheBoundOfKieferAndWolfowitz) {
  std::vector<NominalPlace> candidates;
  for (int copy = 0; copy < 4; ++copy) {
    for (const NominalPlace& corner : kCorners) {
      const double inward_mm = 1e-3 * copy * (corner.in_mm().x() > 150 ? -1 : 1);
      candidates.push_back(place(corner.in_mm().x() + inward_mm, corner.in_mm().y()));
    }
  }
  for (const NominalPlace& p : random_places(100, 9)) candidates.push_back(p);
  const Addition best = best_additions(
      {.model = PanelModel::Affine, .targets = {}, .candidates = candidates, .corners = kCorners},
      8);
  ASSERT_EQ(best.chosen.size(), 8u);
  ASSERT_TRUE(best.worst_after);
  EXPECT_FALSE(best.worst_before);
  EXPECT_GE(*best.worst_after, std::sqrt(3.0 / 8) * (1 - 1e-9));  // nothing can be better
  EXPECT_LE(*best.worst_after, std::sqrt(3.0 / 8) * 1.001);
}

TEST(AddedTargets, MakesADesignDetermineItsModel) {
  const auto in_line = targets_at({place(0, 0), place(150, 0), place(300, 0)});
  const Addition best = best_additions({.model = PanelModel::Affine,
                                        .targets = in_line,
                                        .candidates = kCorners,
                                        .corners = kCorners},
                                       1);
  EXPECT_FALSE(best.worst_before);
  ASSERT_TRUE(best.worst_after);
  ASSERT_EQ(best.chosen.size(), 1u);
  EXPECT_GE(best.chosen[0], 2u);  // one of the far corners
  // One more of those in line does not help.
  const std::vector<NominalPlace> on_it = {place(100, 0)};
  EXPECT_FALSE(best_additions({.model = PanelModel::Affine,
                               .targets = in_line,
                               .candidates = on_it,
                               .corners = kCorners},
                              1)
                   .worst_after);
}

TEST(AddedTargets, TakesNoTargetTwice) {
  const auto four = targets_at({kCorners[0], kCorners[1], kCorners[2], kCorners[3]});
  const Addition best = best_additions(
      {.model = PanelModel::Affine, .targets = four, .candidates = kCorners, .corners = kCorners},
      2);
  EXPECT_TRUE(best.chosen.empty());
}

TEST(AddedTargets, LivesWithCoordinatesFarFromZero) {
  std::vector<NominalPlace> far;
  for (const NominalPlace& p : kCorners)
    far.push_back(place(p.in_mm().x() + 5e4, p.in_mm().y() - 3e4));
  const auto three = targets_at({far[0], far[1], far[3]});
  const Addition best = best_additions(
      {.model = PanelModel::Affine, .targets = three, .candidates = far, .corners = far}, 1);
  ASSERT_EQ(best.chosen.size(), 1u);
  EXPECT_EQ(best.chosen[0], 2u);
  EXPECT_NEAR(best.worst_after.value_or(0), std::sqrt(0.75), 1e-6);
}

}  // namespace
}  // namespace panelcal
