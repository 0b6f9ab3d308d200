// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/panel_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using FitPairs = std::vector<TargetPair<frame::Base, frame::Nominal>>;

ModelScore score(PanelModel model, double parameters, double chi_square, double left_out_um) {
  ModelScore s;
  s.model = model;
  s.parameters = parameters;
  s.chi_square = chi_square;
  s.criterion = chi_square + 2 * parameters;
  if (left_out_um > 0) s.left_out_mm = left_out_um * 1e-3;
  s.is_eligible = left_out_um > 0;
  return s;
}

/// Rigid is chosen, and in force.
PanelFitSummary chosen_rigid() {
  PanelFitSummary summary;
  summary.model = PanelModel::Rigid;
  summary.chose_model = true;
  summary.compared = {score(PanelModel::Offset, 2, 40, 21),
                      score(PanelModel::Rigid, 3, 3.25, 6.5),
                      score(PanelModel::Stretch, 5, 1.5, 8.25),
                      score(PanelModel::Affine, 6, 0, 0)};
  summary.compared[1].is_chosen = true;
  return summary;
}

/// Four targets of a panel that `linear` and a shift by (1, 2) mm carry, each known to 1 um.
FitPairs carried_by(const Eigen::Matrix2d& linear) {
  const Transform<frame::Base, frame::Nominal> truth(linear, Eigen::Vector2d(1, 2));
  FitPairs pairs;
  for (const Eigen::Vector2d& p_mm : {Eigen::Vector2d(0, 0),
                                      Eigen::Vector2d(100, 0),
                                      Eigen::Vector2d(0, 100),
                                      Eigen::Vector2d(100, 100)}) {
    const auto nominal = position_mm<frame::Nominal>(p_mm);
    pairs.push_back({nominal, {truth(nominal), 1e-6 * Eigen::Matrix2d::Identity()}});
  }
  return pairs;
}

Eigen::Matrix2d diagonal(double x, double y) {
  return Eigen::Vector2d(x, y).asDiagonal();
}

TEST(FitPanel, SumsUpAFitInOneLine) {
  const FitPairs pairs = carried_by(diagonal(1.0001, 0.9998));
  PanelFitSummary summary;
  const auto fit = fit_panel({.model = PanelModel::Stretch, .limits = default_gate_limits()},
                             std::span(std::as_const(pairs)),
                             summary);
  ASSERT_NE(fit, nullptr);
  EXPECT_EQ(summary.failure, std::nullopt);
  EXPECT_TRUE(all_accepted(summary.gates));
  EXPECT_EQ(summary.gates.size(), 3U);
  EXPECT_EQ(summary.misfit_ratio, 1);
  EXPECT_NEAR(summary.stretch_x_ppm.value, 100, 1e-6);
  EXPECT_THAT(summary.brief(),
              EndsWith("stretched +100.0 ppm in x and -200.0 ppm in y, worst "
                       "residual 0.000 um"));
  EXPECT_EQ(summary.full("panel"), "panel: " + summary.brief() + "\n");
}

TEST(FitPanel, RefusesAMirroredPanelUnlessItIsMeant) {
  const FitPairs pairs = carried_by(diagonal(1, -1));
  PanelFitOptions options{.model = PanelModel::Stretch, .limits = default_gate_limits()};
  PanelFitSummary summary;
  EXPECT_EQ(fit_panel(options, std::span(std::as_const(pairs)), summary), nullptr);
  EXPECT_EQ(summary.failure, FitFailure::Mirrored);
  options.limits.refuses_mirror = false;
  EXPECT_NE(fit_panel(options, std::span(std::as_const(pairs)), summary), nullptr);
  EXPECT_EQ(summary.failure, std::nullopt);
  EXPECT_TRUE(summary.is_mirrored);
}

TEST(FitPanel, SaysWhyThereIsNoFit) {
  FitPairs pairs = carried_by(diagonal(1, 1));
  pairs.resize(1);
  PanelFitSummary summary = chosen_rigid();
  const PanelFitOptions options{.model = PanelModel::Rigid};
  EXPECT_EQ(fit_panel(options, std::span(std::as_const(pairs)), summary), nullptr);
  EXPECT_EQ(summary.failure, FitFailure::TooFewTargets);
  EXPECT_FALSE(summary.chose_model);
  EXPECT_TRUE(summary.compared.empty());
}

TEST(PanelFitSummary, SaysWhichModelAndWhy) {
  PanelFitSummary summary = chosen_rigid();
  EXPECT_EQ(summary.full("panel"),
            "panel: " + summary.brief() +
                "\n  model \"rigid\", criterion 9.25; \"stretch\" has 11.50, which is worse; "
                "left-out rms 6.50 um\n");
  summary.compared[2].chi_square = -2;
  summary.compared[2].criterion = 8;
  EXPECT_THAT(summary.full("panel"), HasSubstr("too little better to be softer for"));
  summary.chose_model = false;
  EXPECT_EQ(summary.full("panel"), "panel: " + summary.brief() + "\n");
}

TEST(PanelFitSummary, CallsASmoothModelSmooth) {
  PanelFitSummary summary = chosen_rigid();
  summary.model = PanelModel::Affine;
  summary.smooth_parameters = 9.5;
  for (ModelScore& other : summary.compared) other.is_chosen = false;
  ModelScore smooth = score(PanelModel::Affine, 9.5, -30, 2.5);
  smooth.is_smooth = smooth.is_eligible = smooth.is_chosen = true;
  summary.compared.push_back(smooth);
  EXPECT_THAT(
      summary.full("panel"),
      HasSubstr("\npanel: smooth, 9.5 effective parameters\n  model \"smooth\", criterion"));
}

/// Draws many fits of one model and holds the scatter of each number against its sigma.
TEST(PanelFitSummary, PredictsTheScatterOfEveryNumber) {
  constexpr int kDraws = 1000;
  // Standard deviation of a sample's standard deviation is 1 / sqrt(2 N); four of them.
  const double tolerance = 4 / std::sqrt(2.0 * kDraws);
  Eigen::Matrix2d linear;
  linear << 0.8, -0.5, 0.7, 0.9;  // far from the identity, so that every derivative matters
  const Transform<frame::Base, frame::Nominal> truth(linear, Eigen::Vector2d(10, -20));
  Eigen::Matrix2d cov_mm2;
  cov_mm2 << 4e-6, 1.5e-6, 1.5e-6, 1e-6;
  const Eigen::Matrix2d root =
      (Eigen::Matrix2d() << 2e-3, 0, 0.75e-3, std::sqrt(0.4375e-6)).finished();
  Random random(11);
  std::array<double, 6> sum{}, squares{}, sigma{};
  for (int i = 0; i < kDraws; ++i) {
    std::vector<TargetPair<frame::Base, frame::Nominal>> pairs;
    for (const Eigen::Vector2d& p_mm : {Eigen::Vector2d(5, 5),
                                        Eigen::Vector2d(205, 15),
                                        Eigen::Vector2d(0, 150),
                                        Eigen::Vector2d(180, 190)}) {
      const Eigen::Vector2d noise_mm = root * Eigen::Vector2d(random.normal(), random.normal());
      const auto nominal = position_mm<frame::Nominal>(p_mm);
      pairs.push_back(
          {nominal, {truth(nominal) + displacement_mm<frame::Base>(noise_mm), cov_mm2}});
    }
    auto fit = fit_panel<frame::Base, frame::Nominal>(pairs, PanelModel::Affine).fit;
    ASSERT_TRUE(fit.has_value());
    PanelFitSummary n;
    put_numbers(*fit, n);
    const std::array<Uncertain, 6> all = {
        n.rotation_rad, n.stretch_x_ppm, n.stretch_y_ppm, n.shear_ppm, n.shift_x_mm, n.shift_y_mm};
    for (std::size_t k = 0; k < all.size(); ++k) {
      sum[k] += all[k].value;
      squares[k] += all[k].value * all[k].value;
      sigma[k] = all[k].sigma;
    }
  }
  for (std::size_t k = 0; k < sum.size(); ++k) {
    const double mean = sum[k] / kDraws;
    const double scatter = std::sqrt(std::max(0.0, squares[k] / kDraws - mean * mean));
    EXPECT_NEAR(scatter / sigma[k], 1, tolerance) << "number " << k;
  }
}

}  // namespace
}  // namespace panelcal
