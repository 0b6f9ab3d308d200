// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/noticed_error.h"

#include <cmath>
#include <vector>

#include "calib/advice/named_error.h"
#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

constexpr double kNoise_um = 5;

std::vector<DesignTarget> design_at(const std::vector<Eigen::Vector2d>& places_mm) {
  std::vector<DesignTarget> out;
  for (const Eigen::Vector2d& p : places_mm) out.push_back({position_mm<frame::Nominal>(p)});
  return out;
}

const std::vector<Eigen::Vector2d> kCorners = {{0, 0}, {300, 0}, {300, 300}, {0, 300}};

GateLimits only_false_alarm() {
  GateLimits limits;
  limits.false_alarm = 1e-3;
  return limits;
}

std::vector<NoticedError> noticed(const std::vector<DesignTarget>& design,
                                  PanelModel model,
                                  const GateLimits& limits) {
  const auto result = predict_fit(design, model);
  if (!result.fit) return {};
  return noticed_errors(design, *result.fit, um(kNoise_um), limits);
}

// One of four corners under an affine map shows a quarter of its error's square, in both axes, and
// leaves two equations: the noncentrality of 0.1 % and 80 % is 19.7 there.
TEST(NoticedError, OfACornerIsKnown) {
  const auto errors = noticed(design_at(kCorners), PanelModel::Affine, only_false_alarm());
  ASSERT_EQ(errors.size(), 4U);
  for (const NoticedError& error : errors) {
    EXPECT_EQ(error.by, NoticingGate::FalseAlarm);
    EXPECT_NEAR(error.from.value_or(0), std::sqrt(19.70 / 0.25), 0.02);
  }
}

/// Targets on a lattice of 10 mm, each of which an error is held against all residuals.
std::vector<Eigen::Vector2d> lattice_of(int n_a_side) {
  std::vector<Eigen::Vector2d> out;
  for (int k = 0; k < n_a_side * n_a_side; ++k) {
    out.emplace_back(10.0 * (k % n_a_side), 10.0 * std::floor(k / n_a_side));
  }
  return out;
}

// By symmetry all corners of a lattice are alike. Of an offset of n targets an error d moves its
// own residual by d (1 - 1 / n), whose variance is 1 - 1 / n, and each other one by d / n only.
TEST(NoticedError, OfAThousandTargetsIsThatOfItsOwnResidual) {
  GateLimits limits;
  limits.residual = um(100);
  const auto errors = noticed(design_at(lattice_of(32)), PanelModel::Offset, limits);
  ASSERT_EQ(errors.size(), 1024U);
  const double own = 1 - 1.0 / 1024;
  for (const NoticedError& error : errors) {
    EXPECT_EQ(error.by, NoticingGate::Residual);
    EXPECT_NEAR(error.from.value_or(0), (100 / kNoise_um + 0.8416212 * std::sqrt(own)) / own, 1e-5);
  }
}

TEST(NoticedError, NeedsAGateThatLooks) {
  // Three targets leave an affine map no equation, and nothing else looks.
  const auto three = design_at({kCorners[0], kCorners[1], kCorners[3]});
  for (const NoticedError& error : noticed(three, PanelModel::Affine, only_false_alarm())) {
    EXPECT_FALSE(error.from);
    EXPECT_EQ(error.by, NoticingGate::None);
  }
  // Without any gate no number of targets helps.
  for (const NoticedError& error : noticed(design_at(kCorners), PanelModel::Offset, {})) {
    EXPECT_FALSE(error.from);
  }
  // Two targets of a rigid fit check their distance only: across it no residual shows anything.
  const auto two = design_at({kCorners[0], kCorners[1]});
  GateLimits residual = only_false_alarm();
  residual.residual = um(100);
  for (const NoticedError& error : noticed(two, PanelModel::Rigid, residual)) {
    EXPECT_FALSE(error.from);
    EXPECT_NEAR(std::abs(error.direction.y()), 1, 1e-9);
  }
}

// Three targets of an affine map: the target at (300, 0) moves l00 by u/300 along x, and nothing
// else does; sigma of l00 is sqrt(2) noises over 300 mm.
TEST(NoticedError, IsLimitedByTheStretchThatItMakes) {
  const auto three = design_at({kCorners[0], kCorners[1], kCorners[3]});
  GateLimits limits;
  limits.stretch_ppm = 2000;
  const auto errors = noticed(three, PanelModel::Affine, limits);
  ASSERT_EQ(errors.size(), 3U);
  const double along_x_um = 2e-3 * 300e3 + 0.8416 * std::sqrt(2.0) * kNoise_um;
  ASSERT_TRUE(errors[1].from);
  EXPECT_EQ(errors[1].by, NoticingGate::Stretch);
  // The worst direction lies between x, which stretches, and y, which shears.
  EXPECT_GT(*errors[1].from * kNoise_um, along_x_um);
  EXPECT_LT(*errors[1].from * kNoise_um, std::sqrt(2.0) * (along_x_um + 2 * kNoise_um));
}

TEST(NoticedError, OfAPreciseTargetShowsLessThanOfAPoorOne) {
  std::vector<DesignTarget> design = design_at(kCorners);
  design.push_back({position_mm<frame::Nominal>(150, 150)});
  design[0].cov *= 9;
  const auto errors = noticed(design, PanelModel::Similarity, only_false_alarm());
  ASSERT_EQ(errors.size(), 5U);
  EXPECT_GT(errors[0].from.value_or(0), 1.5 * errors[2].from.value_or(0));
}

TEST(NoticedError, ComesFirstWhereItIsNeverNoticed) {
  const std::vector<NoticedError> errors = {{.from = 3}, {.from = std::nullopt}, {.from = 9}};
  EXPECT_EQ(least_noticed(errors), 1U);
}

struct Layout {
  int n;
  PanelModel model;
};

/// The judge is what a job does with drawn noise: fit, gates, test of chi square.
TEST(NoticedError, IsNoticedInFourOfFiveJobs) {
  constexpr int kTrials = 400;
  // 4 sigma of a share of 0.8 in 400 trials.
  constexpr double kShareTolerance = 0.08;
  Random random(7);
  for (const Layout& layout : {Layout{4, PanelModel::Stretch},
                               Layout{4, PanelModel::Affine},
                               Layout{5, PanelModel::Stretch},
                               Layout{6, PanelModel::Similarity}}) {
    std::vector<DesignTarget> design;
    for (int i = 0; i < layout.n; ++i) {
      const double sigma = random.uniform(0.5, 2);
      // About the middle, so that no error has to be so large that a rotation bends its way.
      const double angle = 2 * M_PI * (i + random.uniform(0, 0.5)) / layout.n;
      const double radius_mm = random.uniform(100, 200);
      design.push_back(
          {position_mm<frame::Nominal>(radius_mm * std::cos(angle), radius_mm * std::sin(angle)),
           ObservedAxes::Both,
           sigma * sigma * Eigen::Matrix2d::Identity()});
    }
    GateLimits limits = only_false_alarm();
    limits.false_alarm = 2e-3;
    const auto errors = noticed(design, layout.model, limits);
    ASSERT_EQ(errors.size(), design.size());
    for (std::size_t i = 0; i < 2; ++i) {
      ASSERT_TRUE(errors[i].from);
      const ErrorTrials trials = try_error({.targets = design,
                                            .model = layout.model,
                                            .noise = um(kNoise_um),
                                            .limits = limits,
                                            .i_target = i,
                                            .error = *errors[i].from * errors[i].direction},
                                           kTrials,
                                           5);
      EXPECT_NEAR(trials.noticed_share(), kNoticedShare, kShareTolerance)
          << layout.n << " targets, " << name(layout.model) << ", target " << i;
    }
  }
}

/// Several gates together notice no less than the best of them.
TEST(NoticedError, IsNoticedAtLeastSoOftenWithTheDefaultGates) {
  const auto three = design_at({{10, 20}, {280, 40}, {60, 270}});
  for (const PanelModel model : {PanelModel::Stretch, PanelModel::Affine}) {
    const auto errors = noticed(three, model, default_gate_limits());
    ASSERT_EQ(errors.size(), 3U);
    for (std::size_t i = 0; i < errors.size(); ++i) {
      ASSERT_TRUE(errors[i].from);
      const ErrorTrials trials = try_error({.targets = three,
                                            .model = model,
                                            .noise = um(kNoise_um),
                                            .limits = default_gate_limits(),
                                            .i_target = i,
                                            .error = *errors[i].from * errors[i].direction},
                                           400,
                                           5);
      // 4 sigma of 200 trials below 0.8.
      EXPECT_GT(trials.noticed_share(), 0.69) << name(model) << " " << i;
    }
  }
}

}  // namespace
}  // namespace panelcal
