// SPDX-License-Identifier: Apache-2.0
#include "calib/faults/finder.h"

#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/faults/simulated_faults.h"

namespace panelcal {
namespace {

using internal::ExaminedTarget;
using internal::find_fault_raw;
using ::testing::HasSubstr;

ExaminedTarget target(double x_mm, double y_mm, double to_x_mm, double to_y_mm) {
  return {{x_mm, y_mm},
          {to_x_mm, to_y_mm},
          25e-6 * Eigen::Matrix2d::Identity(),
          ObservedAxes::Both,
          0.95,
          "target at " + std::to_string(x_mm)};
}

/// Four targets that are not symmetric, seen where they should be.
std::vector<ExaminedTarget> healthy() {
  return {target(0, 0, 0, 0),
          target(290, 5, 290, 5),
          target(280, 250, 280, 250),
          target(3, 270, 3, 270)};
}

FaultContext context() {
  return {.limits = test::usual_settings().limits};
}

FaultCause likeliest(const std::optional<SeriesFault>& fault) {
  return fault->suspicions.at(0).cause;
}

TEST(FaultFinder, SaysNothingOfTargetsThatFit) {
  EXPECT_FALSE(find_fault_raw(healthy(), PanelModel::Stretch, context()));
}

TEST(FaultFinder, SaysNothingWithoutARateUnlessTheSeriesIsRefused) {
  std::vector<ExaminedTarget> targets = healthy();
  targets[2].to_mm.x() += 1;
  FaultContext unasked = context();
  unasked.limits.false_alarm.reset();
  EXPECT_FALSE(find_fault_raw(targets, PanelModel::Stretch, unasked));
  unasked.is_refused = true;
  const auto fault = find_fault_raw(targets, PanelModel::Stretch, unasked);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->i_outlier, 2U);
}

TEST(FaultFinder, NamesADamagedMark) {
  std::vector<ExaminedTarget> targets = healthy();
  targets[1].to_mm += Eigen::Vector2d(0.7, -0.4);
  const KnownPads pads({{{200, 100}, 9, 1}});
  FaultContext with_pads = context();
  with_pads.pads = &pads;
  const auto fault = find_fault_raw(targets, PanelModel::Stretch, with_pads);
  ASSERT_TRUE(fault);
  EXPECT_TRUE(fault->is_named());
  EXPECT_EQ(fault->i_outlier, 1U);
  EXPECT_EQ(likeliest(fault), FaultCause::DamagedMark);
  EXPECT_THAT(fault->text(), HasSubstr("target at 290"));
  EXPECT_THAT(fault->text(), HasSubstr("nothing"));
  EXPECT_LT(fault->p_value, 1e-9);
}

TEST(FaultFinder, NamesThePadThatWasTaken) {
  std::vector<ExaminedTarget> targets = healthy();
  targets[1].to_mm = {291.5, 4.2};
  const KnownPads pads({{{288.5, 4.2}, 30, 2}, {{291.5, 4.2}, 31, 3}, {{290, 7}, 32, 3}});
  FaultContext with_pads = context();
  with_pads.pads = &pads;
  const auto fault = find_fault_raw(targets, PanelModel::Stretch, with_pads);
  ASSERT_TRUE(fault);
  EXPECT_TRUE(fault->is_named());
  EXPECT_EQ(likeliest(fault), FaultCause::WrongPad);
  EXPECT_EQ(fault->i_outlier, 1U);
  EXPECT_THAT(fault->text(), HasSubstr("tool 3 at nominal (291.5000, 4.2000) mm (line 31)"));
}

TEST(FaultFinder, BlamesTheBadPicture) {
  std::vector<ExaminedTarget> targets = healthy();
  targets[0].to_mm += Eigen::Vector2d(0.3, 0.4);
  targets[0].cov_mm2 *= 16;
  targets[0].score = 0.4;
  const auto fault = find_fault_raw(targets, PanelModel::Stretch, context());
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->i_outlier, 0U);
  EXPECT_EQ(likeliest(fault), FaultCause::OutOfFocus);
}

/// One equation to spare: a shift of any of the three explains it, and so the finder says.
TEST(FaultFinder, CannotTellWhichOfThreeLies) {
  std::vector<ExaminedTarget> targets = {
      target(0, 0, 0, 0), target(300, 0, 300, 0.06), target(0, 300, 0, 300)};
  const auto fault = find_fault_raw(targets, PanelModel::Stretch, context());
  ASSERT_TRUE(fault);
  EXPECT_FALSE(fault->i_outlier);
  EXPECT_FALSE(fault->is_named());
  EXPECT_GE(fault->suspicions.size(), 3U);
  EXPECT_THAT(fault->text(), HasSubstr("one cause"));
}

struct Lying {
  FaultCause cause;
  Eigen::Matrix2d turn;
};

Eigen::Matrix2d matrix(double a, double b, double c, double d) {
  Eigen::Matrix2d m;
  m << a, b, c, d;
  return m;
}

TEST(FaultFinder, NamesHowThePanelLies) {
  const std::vector<Lying> all = {{FaultCause::TurnedQuarter, matrix(0, -1, 1, 0)},
                                  {FaultCause::TurnedQuarter, matrix(0, 1, -1, 0)},
                                  {FaultCause::TurnedHalf, matrix(-1, 0, 0, -1)},
                                  {FaultCause::Mirrored, matrix(-1, 0, 0, 1)},
                                  {FaultCause::Mirrored, matrix(1, 0, 0, -1)},
                                  {FaultCause::Mirrored, matrix(0, 1, 1, 0)},
                                  {FaultCause::WrongScale, matrix(25.4, 0, 0, 25.4)},
                                  {FaultCause::WrongScale, matrix(0.1, 0, 0, 0.1)},
                                  {FaultCause::WrongScale, matrix(100, 0, 0, 100)}};
  for (const PanelModel model : {PanelModel::Rigid, PanelModel::Stretch, PanelModel::Affine}) {
    for (const Lying& lying : all) {
      std::vector<ExaminedTarget> targets = healthy();
      for (ExaminedTarget& t : targets) {
        t.to_mm = lying.turn * (t.from_mm - Eigen::Vector2d(150, 140)) + Eigen::Vector2d(151, 139);
      }
      FaultContext refused = context();
      refused.is_refused = true;
      const auto fault = find_fault_raw(targets, model, refused);
      ASSERT_TRUE(fault);
      EXPECT_TRUE(fault->is_named()) << fault->text();
      EXPECT_EQ(likeliest(fault), lying.cause) << fault->text();
    }
  }
}

/// On a square of targets turned by 180 degrees every one is seen at the opposite one's place: the
/// panel looks healthy, and nothing may be said.
TEST(FaultFinder, SaysNothingWhereATurnCannotBeSeen) {
  std::vector<ExaminedTarget> targets = {target(0, 0, 0, 0),
                                         target(300, 0, 300, 0),
                                         target(300, 300, 300, 300),
                                         target(0, 300, 0, 300)};
  EXPECT_FALSE(find_fault_raw(targets, PanelModel::Stretch, context()));
}

/// Fiducials that look the same after a half turn and after a mirroring, each 3 mm longer on one
/// side: the camera takes them for each other, and both stories explain it.
TEST(FaultFinder, ListsAllStoriesOfASymmetricPanel) {
  std::vector<ExaminedTarget> targets = {target(0, 0, 0, 3),
                                         target(300, 0, 300, 3),
                                         target(300, 297, 300, 300),
                                         target(0, 297, 0, 300)};
  // The panel's middle is (150, 150): a half turn and a mirroring of y carry these onto each other.
  const KnownPads pads(
      {{{0, 0}, 1, 0}, {{300, 0}, 2, 0}, {{300, 297}, 3, 0}, {{0, 297}, 4, 0}, {{150, 300}, 5, 1}});
  FaultContext refused = context();
  refused.is_refused = true;
  refused.pads = &pads;
  const auto fault = find_fault_raw(targets, PanelModel::Rigid, refused);
  ASSERT_TRUE(fault);
  bool is_half = false;
  bool is_mirrored = false;
  for (const auto& suspicion : fault->suspicions) {
    is_half |= suspicion.cause == FaultCause::TurnedHalf;
    is_mirrored |= suspicion.cause == FaultCause::Mirrored;
  }
  EXPECT_TRUE(is_half && is_mirrored) << fault->text();
  EXPECT_FALSE(fault->is_named());
}

TEST(FaultFinder, NamesNoneWhereEveryPadMayBeEveryTarget) {
  std::vector<KnownPad> grid;
  for (int row = 0; row < 100; ++row) {
    for (int column = 0; column < 100; ++column) {
      grid.push_back({{3.0 * column, 3.0 * row}, row, 1});
    }
  }
  const KnownPads pads(std::move(grid));
  std::vector<ExaminedTarget> targets = healthy();
  targets[1].to_mm.x() += 2;
  for (ExaminedTarget& one : targets) one.cov_mm2 = 1e6 * Eigen::Matrix2d::Identity();
  FaultContext refused = context();
  refused.is_refused = true;
  refused.pads = &pads;
  const auto fault = find_fault_raw(targets, PanelModel::Stretch, refused);
  ASSERT_TRUE(fault);
  EXPECT_FALSE(fault->weighs_taken_pads);
  EXPECT_FALSE(fault->is_named());
  EXPECT_FALSE(fault->i_outlier);
  EXPECT_THAT(fault->text(), HasSubstr("other pads"));
}

TEST(FaultFinder, TakesWhatItIsGiven) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  FaultContext refused = context();
  refused.is_refused = true;
  EXPECT_FALSE(find_fault_raw({}, PanelModel::Stretch, refused));
  std::vector<ExaminedTarget> targets = healthy();
  targets[1].to_mm.x() = kNan;
  EXPECT_FALSE(find_fault_raw(targets, PanelModel::Stretch, refused));
  targets[1].to_mm.x() = 1e300;
  (void)find_fault_raw(targets, PanelModel::Stretch, refused);
  const std::vector<ExaminedTarget> one = {target(0, 0, 5, 0)};
  const auto fault = find_fault_raw(one, PanelModel::Offset, refused);
  ASSERT_TRUE(fault);
  EXPECT_FALSE(fault->i_outlier);
}

/// Ten jobs of each kind; the figures are in the slow test and in tests/bench.
TEST(FaultFinder, NamesMostSimulatedFaults) {
  const Random all(20261121);
  for (const auto kind : {test::SimulatedFault::WrongPad,
                          test::SimulatedFault::Damaged,
                          test::SimulatedFault::MirroredSeen,
                          test::SimulatedFault::Revision}) {
    int n_named = 0;
    int n = 0;
    for (std::uint64_t i = 0; n < 10; ++i) {
      Random random = all.fork(i);
      const auto job = test::draw_job(random, kind, test::usual_settings());
      if (!job) continue;
      ++n;
      if (test::finding_of(*job, job->examine()) == test::Finding::Named) ++n_named;
    }
    // Of ten at 0.99 each, fewer than eight are named once in 9,000 times.
    EXPECT_GE(n_named, 8) << name(kind);
  }
}

}  // namespace
}  // namespace panelcal
