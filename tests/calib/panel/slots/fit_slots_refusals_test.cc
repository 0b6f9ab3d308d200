// SPDX-License-Identifier: Apache-2.0
// Slots that do not determine a model, and slots whose numbers are not finite.
#include <cmath>
#include <limits>
#include <string_view>

#include "calib/panel/fit.h"
#include <gmock/gmock.h>

#include "tests/calib/panel/synthetic_panel.h"

namespace panelcal {
namespace {

using internal::fit_raw;
using test::kAllModels;
using test::RawFitResult;
using test::RawPair;
using test::seen_exactly;
using test::x_at;
using test::y_at;

using Pairs = std::vector<RawPair>;

void expect_fails(const Pairs& pairs, PanelModel model, FitFailure failure) {
  SCOPED_TRACE(name(model));
  const RawFitResult result = fit_raw(pairs, model);
  ASSERT_FALSE(result.fit.has_value());
  EXPECT_EQ(result.failure, failure);
}

struct Case {
  std::string_view why;
  PanelModel model;
  Pairs pairs;
  Pairs cure;  ///< slots that make it determined
};

std::vector<Case> degenerate_cases() {
  using enum PanelModel;
  return {
      {"no x at all", Offset, {y_at(0, 0), y_at(400, 300)}, {x_at(7, 7)}},
      {"no y at all", Offset, {x_at(0, 0), x_at(400, 300)}, {y_at(7, 7)}},
      {"three y and no x", Rigid, {y_at(0, 0), y_at(200, 0), y_at(400, 0)}, {x_at(0, 0)}},
      {"three y anywhere and no x",
       Rigid,
       {y_at(0, 9), y_at(200, 300), y_at(400, 0)},
       {x_at(9, 9)}},
      {"both y at one x: nothing turns them",
       Rigid,
       {y_at(200, 0), y_at(200, 300), x_at(0, 100)},
       {x_at(0, 101)}},
      {"both x at one y: nothing turns them",
       Rigid,
       {x_at(0, 100), x_at(400, 100), y_at(0, 100)},
       {y_at(1, 100)}},
      {"each pair in its own line",
       Rigid,
       {x_at(0, 200), y_at(250, 0), x_at(500, 200), y_at(250, 400)},
       {y_at(251, 0)}},
      {"at one place", Rigid, {x_at(9, 9), y_at(9, 9), x_at(9, 9), y_at(9, 9)}, {x_at(9, 10)}},
      {"a scale, but no rotation",
       Similarity,
       {x_at(0, 0), x_at(400, 0), y_at(0, 0), y_at(0, 300)},
       {y_at(400, 0)}},
      {"a rotation, but no scale",
       Similarity,
       {x_at(0, 0), x_at(0, 300), y_at(0, 0), y_at(400, 0)},
       {x_at(400, 0)}},
      {"no scale of x",
       Stretch,
       {x_at(50, 0), y_at(0, 0), y_at(400, 0), y_at(0, 300), y_at(400, 300)},
       {x_at(51, 0)}},
      {"no scale of y",
       Stretch,
       {x_at(50, 0), x_at(0, 60), x_at(400, 0), y_at(0, 300), y_at(400, 300)},
       {y_at(400, 301)}},
      {"targets in a slanted line",
       Stretch,
       {seen_exactly(0, 0), seen_exactly(200, 100), seen_exactly(400, 200), x_at(100, 50)},
       {y_at(0, 200)}},
      {"two x for three coefficients",
       Affine,
       {x_at(0, 0), x_at(400, 0), y_at(0, 0), y_at(400, 0), y_at(0, 300), y_at(400, 300)},
       {x_at(0, 300)}},
      {"three x in one line",
       Affine,
       {x_at(0, 0), x_at(200, 100), x_at(400, 200), y_at(0, 0), y_at(400, 0), y_at(0, 300)},
       {x_at(0, 300)}},
  };
}

TEST(PanelFitSlots, RefuseWhatLeavesTheModelOpen) {
  for (const Case& each : degenerate_cases()) {
    SCOPED_TRACE(each.why);
    expect_fails(each.pairs, each.model, FitFailure::Degenerate);
    Pairs cured = each.pairs;
    cured.insert(cured.end(), each.cure.begin(), each.cure.end());
    EXPECT_TRUE(fit_raw(cured, each.model).fit.has_value());
  }
}

TEST(PanelFitSlots, NoiseDoesNotHideWhatLeavesTheModelOpen) {
  Random random(50);
  for (const Case& each : degenerate_cases()) {
    SCOPED_TRACE(each.why);
    for (int trial = 0; trial < 50; ++trial) {
      Pairs pairs = each.pairs;
      const double angle_rad = random.uniform(-0.02, 0.02);
      for (RawPair& pair : pairs) {
        pair.from_mm += Eigen::Vector2d(1000, -700);
        pair.to_mm = test::rotation(angle_rad) * pair.to_mm +
                     test::draw(random, 1e-4 * Eigen::Matrix2d::Identity());
      }
      expect_fails(pairs, each.model, FitFailure::Degenerate);
    }
  }
}

TEST(PanelFitSlots, AreInOneLineToAMillionth) {
  // 0.1 um across 300 mm is a line; 10 um is fitted, and its covariance says how badly.
  const auto pair_apart = [](double x_mm) {
    return Pairs{y_at(200, 0), y_at(200 + x_mm, 300), x_at(200, 150)};
  };
  expect_fails(pair_apart(1e-4), PanelModel::Rigid, FitFailure::Degenerate);
  const RawFitResult result = fit_raw(pair_apart(0.010), PanelModel::Rigid);
  ASSERT_TRUE(result.fit.has_value());
  // The sigma of a difference of two y, 1 um each, over 10 um.
  EXPECT_NEAR(std::sqrt(result.fit->cov(2, 2)), std::sqrt(2.0) * 0.1, 1e-3);
}

TEST(PanelFitSlots, RefuseFewerEquationsThanParameters) {
  for (const PanelModel model : kAllModels) {
    Pairs pairs;
    for (int n = 0; n < parameter_count(model); ++n) {
      expect_fails(pairs, model, FitFailure::TooFewTargets);
      pairs.push_back(n % 2 == 0 ? x_at(50.0 * n, 7.0 * n * n) : y_at(9.0 * n * n, 40.0 * n));
    }
  }
  // Two targets and a slot are five equations.
  const Pairs two = {seen_exactly(0, 0), seen_exactly(400, 0)};
  expect_fails(two, PanelModel::Stretch, FitFailure::TooFewTargets);
  Pairs five = two;
  five.push_back(y_at(0, 300));
  EXPECT_TRUE(fit_raw(five, PanelModel::Stretch).fit.has_value());
}

TEST(PanelFitSlots, RefuseAVarianceThatIsNone) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {0.0, -1.0, kNan, kInf, 1e-320, 1e-200, 1e300}) {
    SCOPED_TRACE(bad);
    for (const int axis : {0, 1}) {
      Pairs pairs = {seen_exactly(0, 0),
                     seen_exactly(400, 0),
                     seen_exactly(0, 300),
                     axis == 0 ? x_at(200, 100) : y_at(200, 100)};
      pairs[3].cov_mm2(axis, axis) = bad;
      for (const PanelModel model : kAllModels) {
        expect_fails(pairs, model, FitFailure::BadCovariance);
      }
    }
  }
}

TEST(PanelFitSlots, RefuseNumbersThatAreNotFinite) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Pairs pairs = {seen_exactly(0, 0), seen_exactly(400, 0), seen_exactly(0, 300), x_at(200, 100)};
    for (const PanelModel model : kAllModels) {
      Pairs seen_nowhere = pairs;
      seen_nowhere[3].to_mm.x() = bad;
      expect_fails(seen_nowhere, model, FitFailure::BadCovariance);
      // The place of a slot across it counts, though it shows nothing there: rotation moves it.
      Pairs nowhere = pairs;
      nowhere[3].from_mm.y() = bad;
      EXPECT_FALSE(fit_raw(nowhere, model).fit.has_value());
    }
  }
}

TEST(PanelFitSlots, AnswerWhateverIsMeasured) {
  // Measurements that have nothing to do with the slots: an answer or a failure, never NaN.
  Random random(51);
  int n_answers = 0;
  for (int trial = 0; trial < 400; ++trial) {
    Pairs pairs = test::random_slots(
        random, 2 + trial % 4, trial % 3, test::Coefficients::Zero(), 0.005, false);
    for (RawPair& pair : pairs) {
      if (trial % 3 == 0) continue;  // all seen at one place
      const Eigen::Vector2d anywhere_mm(random.uniform(-500, 500), random.uniform(-500, 500));
      if (observes_x(pair.axes)) pair.to_mm.x() = anywhere_mm.x();
      if (observes_y(pair.axes)) pair.to_mm.y() = anywhere_mm.y();
    }
    for (const PanelModel model : kAllModels) {
      const RawFitResult result = fit_raw(pairs, model);
      if (!result.fit) continue;
      ++n_answers;
      EXPECT_TRUE(test::coefficients_of(*result.fit).allFinite());
      EXPECT_TRUE(result.fit->cov.allFinite());
      EXPECT_TRUE(result.fit->gain.allFinite());
      EXPECT_TRUE(std::isfinite(result.fit->chi_square));
    }
  }
  EXPECT_GT(n_answers, 1500);
}

}  // namespace
}  // namespace panelcal
