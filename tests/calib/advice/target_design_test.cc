// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/target_design.h"

#include <cmath>
#include <vector>

#include "calib/base/random.h"
#include "calib/correction/stack.h"
#include <Eigen/LU>
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using NominalPlace = Position<frame::Nominal>;
using test::IsNearMatrix;

NominalPlace place(double x_mm, double y_mm) {
  return position_mm<frame::Nominal>(x_mm, y_mm);
}

std::vector<DesignTarget> targets_at(const std::vector<NominalPlace>& places) {
  std::vector<DesignTarget> targets;
  for (const NominalPlace& p : places) targets.push_back({p});
  return targets;
}

const std::vector<NominalPlace> kSquare = {
    place(0, 0), place(300, 0), place(300, 300), place(0, 300)};

/// Over the corners of the square, which are the corners of any panel of holes in it.
double worst_leverage(const std::vector<NominalPlace>& targets, PanelModel model) {
  const auto result = predict_fit(targets_at(targets), model);
  if (!result.fit) return NAN;
  const LeverageMap leverage(result.fit->cov);
  double worst = 0;
  for (const NominalPlace& corner : kSquare) worst = std::max(worst, leverage(corner));
  return worst;
}

struct KnownLeverage {
  const char* name;
  std::vector<NominalPlace> targets;
  PanelModel model;
  double squared;  ///< by hand, see below
};

/// Every figure by hand. Similarity: 1/n + r^2/S with r the corner's distance from the targets'
/// middle and S the sum of theirs; a rigid fit has the same across the radius. Affine: barycentric
/// weights, whose squares add up.
std::vector<KnownLeverage> known_table() {
  const std::vector<NominalPlace> edge = {kSquare[0], kSquare[1]};
  const std::vector<NominalPlace> diagonal = {kSquare[0], kSquare[2]};
  const std::vector<NominalPlace> three = {kSquare[0], kSquare[1], kSquare[3]};
  const std::vector<NominalPlace> cluster = {place(0, 0), place(100, 0), place(0, 100)};
  return {
      {"two on one edge, rigid", edge, PanelModel::Rigid, 1.0 / 2 + 112'500.0 / 45'000},
      {"two on one edge, similarity", edge, PanelModel::Similarity, 1.0 / 2 + 112'500.0 / 45'000},
      {"diagonal, rigid", diagonal, PanelModel::Rigid, 1.0 / 2 + 45'000.0 / 90'000},
      {"diagonal, similarity", diagonal, PanelModel::Similarity, 1.0 / 2 + 45'000.0 / 90'000},
      {"three corners, similarity", three, PanelModel::Similarity, 1.0 / 3 + 80'000.0 / 120'000},
      {"three corners, affine", three, PanelModel::Affine, 1 + 1 + 1},
      {"four corners, similarity", kSquare, PanelModel::Similarity, 1.0 / 4 + 45'000.0 / 180'000},
      {"four corners, affine", kSquare, PanelModel::Affine, 1.0 / 4 + 2 * (22'500.0 / 90'000)},
      {"cluster of three, affine", cluster, PanelModel::Affine, 25 + 9 + 9},
  };
}

TEST(TargetDesign, GivesTheKnownLeverageTable) {
  for (const KnownLeverage& known : known_table()) {
    EXPECT_NEAR(worst_leverage(known.targets, known.model), std::sqrt(known.squared), 1e-9)
        << known.name;
  }
}

TEST(TargetDesign, GivesThePublishedFiguresToTheirLastDigit) {
  const std::vector<double> published = {1.73, 1.73, 1.00, 1.00, 1.00, 1.73, 0.71, 0.87, 6.56};
  const auto table = known_table();
  ASSERT_EQ(table.size(), published.size());
  for (std::size_t i = 0; i < table.size(); ++i) {
    EXPECT_NEAR(worst_leverage(table[i].targets, table[i].model), published[i], 0.005)
        << table[i].name;
  }
}

/// Least squares by the normal equations of the linearised model, independent of panel_fit.
TEST(TargetDesign, AgreesWithTheNormalEquations) {
  Random random(11);
  for (const PanelModel model : {PanelModel::Offset,
                                 PanelModel::Rigid,
                                 PanelModel::Similarity,
                                 PanelModel::Stretch,
                                 PanelModel::Affine}) {
    for (int trial = 0; trial < 20; ++trial) {
      std::vector<DesignTarget> targets;
      MapCovariance information = MapCovariance::Zero();
      for (int i = 0; i < 5; ++i) {
        const auto axes = i == 4 ? ObservedAxes::X : ObservedAxes::Both;
        targets.push_back({place(random.uniform(-1, 1), random.uniform(-1, 1)), axes});
        information += internal::information(targets.back().nominal.in_mm(), targets.back());
      }
      const auto result = predict_fit(targets, model);
      ASSERT_TRUE(result.fit);
      const MapCovariance other =
          internal::covariance_of(information, model, MapCovariance::Zero(), 0);
      EXPECT_THAT(result.fit->cov, IsNearMatrix(other, 1e-6 * other.norm())) << name(model);
    }
  }
}

/// Weighted least squares by whitened rows and a pseudo-inverse, with nothing of panel/ in it: each
/// target has a covariance of its own, as a recorded job's have.
TEST(TargetDesign, TakesTheNoiseOfEachTarget) {
  Random random(17);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<DesignTarget> targets;
    Eigen::MatrixXd rows(10, 6);
    for (int i = 0; i < 5; ++i) {
      const Eigen::Vector2d at(random.uniform(-1, 1), random.uniform(-1, 1));
      Eigen::Matrix2d root;
      root << random.uniform(0.3, 3), 0, random.uniform(-1, 1), random.uniform(0.3, 3);
      targets.push_back(
          {position_mm<frame::Nominal>(at), ObservedAxes::Both, root * root.transpose()});
      Eigen::Matrix<double, 2, 6> j;
      j << at.x(), at.y(), 0, 0, 1, 0, 0, 0, at.x(), at.y(), 0, 1;
      rows.middleRows<2>(2 * i) = root.inverse() * j;
    }
    const Eigen::MatrixXd expected = (rows.transpose() * rows).inverse();
    const auto affine = predict_fit(targets, PanelModel::Affine);
    ASSERT_TRUE(affine.fit);
    EXPECT_THAT(affine.fit->cov, IsNearMatrix(expected, 1e-9 * expected.norm()));
    // Of a similarity the coefficients are [a -b b a tx ty].
    Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(6, 4);
    basis(0, 0) = basis(3, 0) = basis(2, 1) = basis(4, 2) = basis(5, 3) = 1;
    basis(1, 1) = -1;
    const Eigen::MatrixXd small = rows * basis;
    const Eigen::MatrixXd of_similarity =
        basis * (small.transpose() * small).inverse() * basis.transpose();
    const auto similarity = predict_fit(targets, PanelModel::Similarity);
    ASSERT_TRUE(similarity.fit);
    EXPECT_THAT(similarity.fit->cov, IsNearMatrix(of_similarity, 1e-9 * of_similarity.norm()));
  }
}

TEST(TargetDesign, CountsWhatANestedFitLeavesOfTheBase) {
  // The stack's own covariance is the judge: base and nested fits on the drawn panel.
  const std::vector<NominalPlace> base_places = {place(0, 0), place(500, 0), place(0, 400)};
  const std::vector<NominalPlace> nested_places = {place(300, 100), place(360, 110)};
  const double base_sigma = 3;  // in units of the nested targets' noise
  constexpr double kUnit_mm = 1e-3;
  std::vector<TargetPair<frame::Base, frame::Nominal>> base_pairs;
  for (const NominalPlace& p : base_places) {
    base_pairs.push_back({p,
                          {position_mm<frame::Base>(p.in_mm()),
                           std::pow(base_sigma * kUnit_mm, 2) * Eigen::Matrix2d::Identity()}});
  }
  std::vector<TargetPair<frame::Actual, frame::Base>> nested_pairs;
  for (const NominalPlace& p : nested_places) {
    nested_pairs.push_back({position_mm<frame::Base>(p.in_mm()),
                            {position_mm<frame::Actual>(p.in_mm()),
                             std::pow(kUnit_mm, 2) * Eigen::Matrix2d::Identity()}});
  }
  const auto base = fit_panel<frame::Base, frame::Nominal>(base_pairs, PanelModel::Stretch);
  const auto nested = fit_panel<frame::Actual, frame::Base>(nested_pairs, PanelModel::Rigid);
  ASSERT_TRUE(base.fit && nested.fit);
  CorrectionStack stack;
  stack.set_base(std::make_shared<const BaseFit>(*base.fit));
  stack.set_nested(std::make_shared<const NestedFit>(*nested.fit));

  const auto base_design = predict_fit(targets_at(base_places), PanelModel::Stretch);
  ASSERT_TRUE(base_design.fit);
  const auto design = predict_fit(
      targets_at(nested_places), PanelModel::Rigid, base_sigma * base_sigma * base_design.fit->cov);
  ASSERT_TRUE(design.fit);
  const LeverageMap leverage(design.fit->cov);
  for (const NominalPlace& hole : {place(330, 140), place(280, 90), place(400, 200)}) {
    const Eigen::Matrix2d expected = stack.actual_from_nominal()(hole).cov / (kUnit_mm * kUnit_mm);
    EXPECT_THAT(leverage.covariance(hole), IsNearMatrix(expected, 1e-6 * expected.norm()));
  }
}

TEST(TargetDesign, RefusesWhatTheFitRefuses) {
  const auto in_line = targets_at({place(0, 0), place(100, 100), place(250, 250)});
  EXPECT_EQ(predict_fit(in_line, PanelModel::Affine).failure, FitFailure::Degenerate);
  const auto one = targets_at({place(0, 0)});
  EXPECT_FALSE(predict_fit(one, PanelModel::Rigid).fit);
  EXPECT_EQ(predict_fit(one, PanelModel::Rigid).failure, FitFailure::TooFewTargets);
  EXPECT_FALSE(predict_fit({}, PanelModel::Offset).fit);
}

TEST(TargetDesign, LeverageHasItsGreatestValueAtACorner) {
  const auto result =
      predict_fit(targets_at({place(3, 4), place(90, 10), place(40, 70)}), PanelModel::Stretch);
  ASSERT_TRUE(result.fit);
  const LeverageMap leverage(result.fit->cov);
  Random random(5);
  for (int trial = 0; trial < 1000; ++trial) {
    const Eigen::Vector2d a(random.uniform(-200, 200), random.uniform(-200, 200));
    const Eigen::Vector2d b(random.uniform(-200, 200), random.uniform(-200, 200));
    const double between = random.uniform();
    const double at_ends = between * leverage(position_mm<frame::Nominal>(a)) +
                           (1 - between) * leverage(position_mm<frame::Nominal>(b));
    EXPECT_LE(leverage(position_mm<frame::Nominal>((between * a + (1 - between) * b).eval())),
              at_ends * (1 + 1e-12));
  }
}

}  // namespace
}  // namespace panelcal
