// SPDX-License-Identifier: Apache-2.0
// Errors of a smooth model at holes of simulated panels, against their predicted covariance.
#include <cmath>
#include <tuple>

#include "calib/panel/smooth_panel.h"
#include <gmock/gmock.h>

#include "tests/calib/panel/bowed_panel.h"
#include "tests/calib/panel/synthetic_panel.h"

namespace panelcal {
namespace {

using internal::fit_raw;
using internal::fit_smooth_raw;
using internal::RawSmooth;
using test::affine_truth;
using test::Bow;
using test::bowed_pairs;
using test::Coefficients;
using test::RawPair;

constexpr double kSigma_mm = test::kBowedSigma_mm;

struct AtHoles {
  double smooth = 0;  ///< sums of squares, mm^2
  double affine = 0;
  double parameters = 0;
  int n_inside = 0;
};

AtHoles at_holes(Random& random, int n, double bow_mm, int n_panels) {
  AtHoles out;
  for (int i = 0; i < n_panels; ++i) {
    const Coefficients truth = affine_truth(random);
    const Bow bow(random, bow_mm);
    const auto pairs = bowed_pairs(random, n, truth, bow);
    const RawSmooth fit = *fit_smooth_raw(pairs);
    const auto affine = *fit_raw(pairs, PanelModel::Affine).fit;
    const Eigen::Vector2d hole_mm = test::random_place(random);
    const Eigen::Vector2d right_mm = test::mapped(truth, hole_mm) + bow(hole_mm);
    const Eigen::Vector2d error_mm = fit.map_mm(hole_mm) - right_mm;
    out.smooth += error_mm.squaredNorm();
    out.affine += (test::mapped(test::coefficients_of(affine), hole_mm) - right_mm).squaredNorm();
    out.parameters += fit.parameters / n_panels;
    out.n_inside += test::is_in_ellipse(error_mm, fit.cov_mm2(hole_mm)) ? 1 : 0;
  }
  return out;
}

TEST(SmoothPanel, FollowsABowedPanelAndKnowsHowWell) {
  constexpr int kPanels = 300;
  Random random(75);
  // The ratio is of sums of squares. With few targets anywhere on a panel much of it lies outside
  // their hull, where the bow is not known. A plate is rougher than this bow, so that ellipses
  // become too large with many targets.
  for (const auto& [n, ratio, least] : {std::tuple(9, 0.7, 0.88),
                                        std::tuple(16, 0.4, 0.93),
                                        std::tuple(25, 0.25, 0.94),
                                        std::tuple(40, 0.12, 0.94)}) {
    const AtHoles found = at_holes(random, n, 0.03, kPanels);
    EXPECT_LT(found.smooth, ratio * found.affine) << n;
    EXPECT_GE(found.n_inside, least * kPanels) << n;
  }
}

TEST(SmoothPanel, OfSixTargetsKnowsHowBadlyTheyTellABendingsSize) {
  // 20 times the noise. A prior whose tail in the strength is s^-2, and sigmas of a mean variance,
  // hold 89 %.
  constexpr int kPanels = 4000;
  Random random(77);
  const AtHoles found = at_holes(random, 6, 0.1, kPanels);
  EXPECT_GE(found.n_inside, 0.92 * kPanels);
  EXPECT_LE(found.n_inside, 0.98 * kPanels);
}

TEST(SmoothPanel, HardlyBendsAnAffinePanel) {
  constexpr int kPanels = 300;
  Random random(76);
  for (const int n : {9, 16, 40}) {
    const AtHoles found = at_holes(random, n, 0, kPanels);
    EXPECT_LT(std::sqrt(found.smooth / found.affine), 1.12) << n;
    EXPECT_LT(found.parameters, 8.5) << n;
    EXPECT_GE(found.n_inside, 0.93 * kPanels) << n;
  }
}

}  // namespace
}  // namespace panelcal
