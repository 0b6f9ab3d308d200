// SPDX-License-Identifier: Apache-2.0
#include "surface/plan/probe_plan.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "surface/fit/fit.h"
#include <gmock/gmock.h>

#include "tests/support/matchers.h"
#include "tests/surface/fit/simulated_warp.h"

namespace panelcal {
namespace {

using test::FailsWith;
using ::testing::HasSubstr;
using Places = std::vector<Position<frame::Nominal>>;

/// Places of a lattice over 0 .. width x 0 .. height.
Places lattice(int n_columns, int n_rows, double width_mm, double height_mm) {
  Places out;
  for (int j = 0; j < n_rows; ++j) {
    for (int i = 0; i < n_columns; ++i) {
      out.push_back(position_mm<frame::Nominal>(width_mm * i / (n_columns - 1),
                                                height_mm * j / (n_rows - 1)));
    }
  }
  return out;
}

/// Holes all over a panel of 200 x 150 mm that bends by 50 um over 80 mm; a probe scatters 3 um.
ProbePlanRequest bent() {
  ProbePlanRequest request;
  request.amplitude = mm(0.05);
  request.length = mm(80);
  request.probe_sigma = um(3);
  request.tolerance = um(6);
  request.places = lattice(21, 16, 200, 150);
  request.candidates = lattice(21, 16, 200, 150);
  return request;
}

ProbePlanRequest flat() {
  ProbePlanRequest request = bent();
  request.model = SurfaceModel::Plane;
  request.kernel = BendingKernel::None;
  request.amplitude = request.length = mm(0);
  return request;
}

ProbePlan planned(const ProbePlanRequest& request) {
  auto plan = plan_probes(request);
  EXPECT_TRUE(plan) << plan.error().text();
  return *std::move(plan);
}

/// Greatest sigma of a map of these probes, whatever they find.
double worst_um(const ProbePlanRequest& request, const Places& probes) {
  std::vector<ProbePoint> points = request.present;
  for (const auto& place : probes) points.push_back({place, {mm(7), request.probe_sigma}, "", {}});
  const auto fit = fit_surface(points, request.model, request.shape());
  double worst = 0;
  if (!fit) return std::numeric_limits<double>::infinity();
  for (const auto& height : fit->at(request.places)) worst = std::max(worst, height.sigma.in_um());
  return worst;
}

TEST(ProbePlan, TakesTheCornersOfAPlane) {
  // Least squares: sigma of a plane of four corners is sqrt(3/4) of a probe's there, of three
  // corners sqrt(3) at the fourth.
  ProbePlanRequest request = flat();
  request.tolerance = um(3);
  const ProbePlan plan = planned(request);
  ASSERT_TRUE(plan.is_reached) << plan.why_not;
  EXPECT_EQ(plan.probes.size(), 4U);
  EXPECT_NEAR(plan.worst.sigma.in_um(), 3 * std::sqrt(0.75), 1e-6);
  EXPECT_FALSE(plan.before);
  ASSERT_TRUE(plan.grid);
  EXPECT_EQ(plan.grid->n_probes(), 4);
  request.tolerance = um(3 * std::sqrt(3) + 0.01);
  EXPECT_EQ(planned(request).probes.size(), 3U);
}

TEST(ProbePlan, KeepsTheToleranceWithFewerProbesThanAGrid) {
  const ProbePlanRequest request = bent();
  const ProbePlan plan = planned(request);
  ASSERT_TRUE(plan.is_reached) << plan.why_not;
  EXPECT_LE(worst_um(request, plan.probes), 6.0);
  EXPECT_NEAR(worst_um(request, plan.probes), plan.worst.sigma.in_um(), 1e-6);
  ASSERT_TRUE(plan.grid);
  EXPECT_LT(static_cast<int>(plan.probes.size()), plan.grid->n_probes());
  EXPECT_LE(plan.grid->worst.sigma, um(6));
}

TEST(ProbePlan, NeedsEachOfItsProbes) {
  const ProbePlanRequest request = bent();
  const ProbePlan plan = planned(request);
  for (std::size_t i = 0; i < plan.probes.size(); ++i) {
    Places others = plan.probes;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    // The search works a little below the tolerance.
    EXPECT_GT(worst_um(request, others), 6.0 * (1 - 2e-4)) << i;
  }
}

TEST(ProbePlan, NeedsMoreForLess) {
  std::size_t last = 0;
  for (const double tolerance_um : {30.0, 12.0, 6.0, 4.0}) {
    ProbePlanRequest request = bent();
    request.tolerance = um(tolerance_um);
    const ProbePlan plan = planned(request);
    ASSERT_TRUE(plan.is_reached) << plan.why_not;
    EXPECT_GT(plan.probes.size(), last);
    last = plan.probes.size();
  }
}

TEST(ProbePlan, AsksForNothingThatIsKnown) {
  ProbePlanRequest request = bent();
  const ProbePlan all = planned(request);
  const std::size_t n_half = all.probes.size() / 2;
  for (std::size_t i = 0; i < n_half; ++i) {
    request.present.push_back({all.probes[i], {mm(1), request.probe_sigma}, "", {}});
  }
  const ProbePlan rest = planned(request);
  ASSERT_TRUE(rest.is_reached) << rest.why_not;
  EXPECT_LE(rest.probes.size(), all.probes.size() - n_half + 3);
  ASSERT_TRUE(rest.before);
  EXPECT_GT(rest.before->sigma, um(6));
  for (const auto& place : all.probes) {
    request.present.push_back({place, {mm(1), request.probe_sigma}, "", {}});
  }
  const ProbePlan done = planned(request);
  EXPECT_TRUE(done.is_reached);
  EXPECT_TRUE(done.probes.empty());
}

TEST(ProbePlan, RefusesToAddToTooMany) {
  ProbePlanRequest request = bent();
  const ProbePoint unsure{request.candidates.front(), {mm(1), mm(1)}, "", {}};
  request.present.assign(kMostPlanned, unsure);
  EXPECT_THAT(plan_probes(request), FailsWith(Code::ConfigValue, "600 probes"));
}

TEST(ProbePlan, ProbesNearHolesThatStandApart) {
  ProbePlanRequest request = bent();
  request.places = {position_mm<frame::Nominal>(20, 20), position_mm<frame::Nominal>(180, 130)};
  const ProbePlan plan = planned(request);
  ASSERT_TRUE(plan.is_reached) << plan.why_not;
  EXPECT_LT(plan.probes.size(), planned(bent()).probes.size() / 3);
  EXPECT_LE(worst_um(request, plan.probes), 6.0);
}

TEST(ProbePlan, FindsUnsurePlacesAmongVeryMany) {
  ProbePlanRequest request = bent();
  request.tolerance = um(9);
  request.places = lattice(101, 76, 200, 150);
  const ProbePlan plan = planned(request);
  ASSERT_TRUE(plan.is_reached) << plan.why_not;
  EXPECT_LE(worst_um(request, plan.probes), 9.0);
}

TEST(ProbePlan, SaysWhatCannotBeReached) {
  ProbePlanRequest request = bent();
  request.tolerance = um(2.9);
  ProbePlan plan = planned(request);
  EXPECT_FALSE(plan.is_reached);
  EXPECT_THAT(plan.why_not, HasSubstr("less than what one probe scatters (3 um)"));
  request = bent();
  request.candidates = lattice(3, 3, 60, 60);
  plan = planned(request);
  EXPECT_FALSE(plan.is_reached);
  EXPECT_TRUE(plan.probes.empty());
  EXPECT_THAT(plan.why_not, HasSubstr("with all of 9 probes sigma would still be"));
  EXPECT_GT(plan.worst.sigma, um(6));
  request.candidates = {request.candidates.front()};
  plan = planned(request);
  EXPECT_FALSE(plan.is_reached);
  EXPECT_THAT(plan.why_not, HasSubstr("make no surface"));
}

TEST(ProbePlan, RefusesNumbersThatMakeNoRequest) {
  ProbePlanRequest request = bent();
  request.length = mm(0);
  EXPECT_THAT(plan_probes(request), FailsWith(Code::ConfigValue, "length"));
  request = bent();
  request.tolerance = um(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(plan_probes(request), FailsWith(Code::ConfigValue, "tolerance"));
  request = bent();
  request.places.clear();
  EXPECT_THAT(plan_probes(request), FailsWith(Code::ConfigValue));
  request = bent();
  request.model = SurfaceModel::ThinPlate;
  EXPECT_THAT(plan_probes(request), FailsWith(Code::ConfigValue, "thin plate"));
}

}  // namespace
}  // namespace panelcal
