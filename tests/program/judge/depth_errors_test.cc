// SPDX-License-Identifier: Apache-2.0
#include "program/judge/depth_errors.h"

#include <cmath>
#include <vector>

#include "program/judge/depth_verdict.h"
#include "program/judge/probed_surface.h"

#include "tests/program/operations.h"

namespace panelcal {
namespace {

using namespace test;
using ::testing::HasSubstr;

/// 36 probes over 100 mm; the second Z axis stands 50 um higher, on a board that falls along x.
Survey probed_by_two() {
  Survey survey;
  for (int i = 0; i < 36; ++i) {
    const Eigen::Vector2d p_mm = 20.0 * Eigen::Vector2d(i % 6, i / 6);
    ProbeReading reading;
    reading.request.line = 3;
    reading.request.command = "G79";
    reading.request.nominal = position_mm<frame::Nominal>(p_mm);
    reading.status = ProbeStatus::Found;
    reading.heights = {{mm(1.6), um(2)}, {mm(1.65 - 1e-3 * p_mm.x()), um(2)}};
    survey.probes.push_back(reading);
  }
  return survey;
}

DepthErrors by_two() {
  return {um(3), probed_surfaces(probed_by_two(), mm(5))};
}

const DepthTolerance kEither{um(30), um(30)};

/// Both axes count on what they read at x = 0.
DepthOfCut counted_at_zero() {
  DepthOfCut cut{.z = {}, .depth = mm(0.2), .surface = mm(1.6)};
  cut.other_surfaces = {mm(1.65)};
  return cut;
}

TEST(DepthErrors, AreThoseOfTheWorstAxis) {
  const auto far =
      by_two().worst_at(position_mm<frame::Nominal>(40, 40), counted_at_zero(), kEither);
  ASSERT_TRUE(far);
  EXPECT_EQ(far->axis, 1U);
  EXPECT_NEAR(far->mean.in_um(), -40, 1);
  EXPECT_NEAR(far->sigma.in_um(), std::hypot(far->map_sigma.in_um(), 3), 1e-9);
  EXPECT_THAT(error_text(*far), HasSubstr("um too shallow if the map is right, sigma"));
  EXPECT_THAT(error_text(*far), HasSubstr(", Z axis 1"));
  // Only the side that is asked decides which axis is worse.
  const auto deep =
      by_two().worst_at(position_mm<frame::Nominal>(40, 40), counted_at_zero(), {{}, um(30)});
  ASSERT_TRUE(deep);
  EXPECT_EQ(deep->axis, 0U);
}

TEST(DepthErrors, AreNotKnownIfOneAxisIsNot) {
  DepthOfCut first_only = counted_at_zero();
  first_only.other_surfaces.clear();
  const Position<frame::Nominal> place = position_mm<frame::Nominal>(40, 40);
  EXPECT_FALSE(by_two().worst_at(place, first_only, kEither));
  Survey lame = probed_by_two();
  for (ProbeReading& reading : lame.probes) {
    if (reading.request.nominal.in_mm().x() > 30) reading.heights.resize(1);
  }
  lame.probes.resize(20);  // the second axis has ten left
  const DepthErrors errors(um(3), probed_surfaces(lame, mm(5)));
  ASSERT_EQ(errors.maps().size(), 2U);
  EXPECT_TRUE(errors.maps()[0]);
  EXPECT_FALSE(errors.maps()[1]);
  EXPECT_FALSE(errors.worst_at(position_mm<frame::Nominal>(20, 20), counted_at_zero(), kEither));
}

TEST(DepthErrors, OfAReferenceAreThoseOfEachAxis) {
  DepthOfCut cut = counted_at_zero();
  cut.z = mm(1.4);
  cut.reference = PlaneReference{position_mm<frame::Nominal>(0, 0), mm(1.6), {mm(1.63)}};
  const auto error = by_two().worst_at(position_mm<frame::Nominal>(0, 0), cut, kEither);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->axis, 1U);  // its reference was read 20 um too low
  EXPECT_NEAR(error->mean.in_um(), -20, 1);
  EXPECT_GT(error->reference_sigma, Length());
  EXPECT_NEAR(error->sigma.in_um(),
              std::hypot(error->map_sigma.in_um(), error->reference_sigma.in_um(), 3),
              1e-9);
}

TEST(DepthVerdict, NamesTheAxisOfItsWorstDepth) {
  Tolerances tolerances;
  tolerances.depth = kEither;
  DepthVerdict verdict(tolerances, by_two());
  Drill hole = drill(1, 40.25, 40.5);
  hole.cut = counted_at_zero();
  put_all(verdict, {hole});
  EXPECT_EQ(verdict.decision(), JobDecision::Hold);
  EXPECT_EQ(verdict.worst_tool()->worst.error.axis, 1U);
  EXPECT_THAT(verdict.sentence(), HasSubstr("Z axis 1"));
}

TEST(DepthJudge, JudgesHolesAndEndsOfRouts) {
  Tolerances tolerances;
  tolerances.depth = kEither;
  DepthJudge judge(tolerances, by_two());
  judge.begin(metric_info());
  Drill hole = drill(1, 40.25, 40.5);
  hole.cut = counted_at_zero();
  const Operation asked{.line = 1, .path = {}, .what = hole, .file = {}};
  const auto judged = judge.judge(asked);
  ASSERT_TRUE(judged);
  EXPECT_GT(judged->risk.too_shallow, 0.9);
  EXPECT_LT(judged->risk.too_deep, 1e-9);
  Drill through = drill(1, 40, 40);
  through.cut.z = mm(-0.3);
  EXPECT_FALSE(judge.judge({.line = 1, .path = {}, .what = through, .file = {}}));
}

}  // namespace
}  // namespace panelcal
