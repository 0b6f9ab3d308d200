// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/pipeline.h"

#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

/// Sees its target where it is told to, with the score that it is told.
struct ToldFamily {
  struct Fit {
    TargetFit target;
  };
  std::vector<Eigen::Vector3d> seen;  ///< x, y, score
  std::optional<Judgement> if_none = {};

  Proposals<Eigen::Vector3d> propose() const { return {seen, if_none}; }
  Fit fit(const Eigen::Vector3d& s) const {
    Fit fit;
    fit.target.center = {position_px(s.x(), s.y()), Eigen::Matrix2d::Identity()};
    fit.target.score = s.z();
    return fit;
  }
  Judgement judge(const Fit& fit) const {
    if (auto problem = score_problem(fit.target.score, 0.5)) return unlikely(*problem);
    return {};
  }
};

class Pipeline : public testing::Test {
 protected:
  Image image{100, 80, 255};
  Target target;
  LocateOptions options;

  std::vector<FittedCandidate> detected(const ToldFamily& family, double apart_px = 0) {
    return detect({image, target, nullptr, options, SearchArea(options)}, family, apart_px);
  }
};

TEST_F(Pipeline, JudgesEveryCandidate) {
  const auto found = detected({{{10, 10, 0.9}, {50, 50, 0.2}}});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_TRUE(found[0].is_good());
  EXPECT_EQ(found[1].judgement.verdict, Verdict::Unlikely);
  EXPECT_EQ(found[1].judgement.reason, "its score is 0.20, at least 0.50 is asked for (min_score)");
}

TEST_F(Pipeline, LeavesOutFitsThatEndOutsideOfTheArea) {
  options.search_center = position_px<frame::Image>(Eigen::Vector2d(10, 10));
  options.search_radius = px(5);
  const auto found = detected({{{12, 10, 0.9}, {16, 10, 0.9}}});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].fit.center.position.in_px().x(), 12);
}

TEST_F(Pipeline, KeepsTheBestOfOnePlace) {
  const auto found = detected({{{10, 10, 0.6}, {11, 10, 0.9}, {40, 10, 0.7}}}, 3);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].fit.score, 0.9);
  EXPECT_EQ(found[1].fit.score, 0.7);
  EXPECT_EQ(detected({{{10, 10, 0.6}, {11, 10, 0.9}}}).size(), 2U);
}

TEST_F(Pipeline, RefusesTheWholeAreaWhereNoCandidateIsLeft) {
  EXPECT_TRUE(detected({}).empty());
  const auto found = detected({.seen = {}, .if_none = unfit("no picture of it")});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].judgement.reason, "no picture of it");
  EXPECT_EQ(found[0].fit.center.position.in_px(), Eigen::Vector2d(49.5, 39.5));
  EXPECT_EQ(detected({.seen = {{1, 1, 1}}, .if_none = unfit("none")}).front().is_good(), true);
}

}  // namespace
}  // namespace panelcal::internal
