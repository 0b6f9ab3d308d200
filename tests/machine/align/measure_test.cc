// SPDX-License-Identifier: Apache-2.0
#include "machine/align/measure.h"

#include <cmath>
#include <string>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"

namespace panelcal {
namespace {

const std::chrono::sys_seconds kNow = *from_iso_8601("2026-11-28T02:00:00Z");
constexpr double kSigma_mm = 1e-3;

/// Pads of a panel that lies turned and moved; each may be moved by itself.
class TurnedPanel final : public MeasurementSource {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    lines.push_back(request.line);
    Measurement pad;
    pad.request = request;
    if (request.seq == i_lost) {
      pad.status = MeasurementStatus::NotFound;
      return pad;
    }
    pad.status = MeasurementStatus::Found;
    Eigen::Vector2d at_mm = true_mm(request.nominal.in_mm());
    if (request.seq == i_moved) at_mm.x() += moved_mm;
    pad.measured = {position_mm<frame::Actual>(at_mm.x(), at_mm.y()),
                    kSigma_mm * kSigma_mm * Eigen::Matrix2d::Identity()};
    return pad;
  }
  static Eigen::Vector2d true_mm(const Eigen::Vector2d& p) {
    const double c = std::cos(2e-3);
    const double s = std::sin(2e-3);
    return {c * p.x() - s * p.y() + 0.3, s * p.x() + c * p.y() - 0.2};
  }

  std::vector<int> lines;
  std::int64_t i_moved = -1;
  std::int64_t i_lost = -1;
  double moved_mm = 0;
};

/// A machine whose file exists, pads of a file, and their alignment.
class AlignedBoard : public testing::Test {
 protected:
  AlignedBoard() {
    write_machine("[machine]\nname = \"m\"\n");
    const double corners_mm[4][2] = {{0, 0}, {100, 0}, {100, 80}, {0, 80}};
    for (int i = 0; i < 4; ++i) {
      pads_.pads.push_back(
          {.nominal = position_mm<frame::Nominal>(corners_mm[i][0], corners_mm[i][1]),
           .line = 100 + i,
           .settings = {.tools = {1}}});
    }
  }

  void write_machine(const std::string& text) {
    const auto file = folder_.path() / "machine.toml";
    ASSERT_TRUE(write_file(file, text));
    machine_ = *read_machine_config(file);
  }
  OpenJobSources open() {
    return [this](const Survey& nominal) -> Expected<JobSources> {
      asked_ = nominal;
      return JobSources{
          {std::shared_ptr<void>(), &panel_}, std::make_shared<NominalProbeSource>(), "a panel"};
    };
  }
  Alignment align() {
    const auto result = measure_pads(pads_, open(), machine_, kNow);
    EXPECT_TRUE(result) << result.error().text();
    Alignment alignment{.file = "b.json", .time = kNow, .names = std::vector<std::string>(4)};
    alignment.inputs = *alignment_inputs(machine_);
    put_result(*result, alignment);
    return alignment;
  }
  std::string refusal(const Alignment& alignment) {
    const auto panel = restore_panel(alignment, machine_, kNow);
    return panel ? "none" : std::string(info(panel.error().code).slug);
  }

  test::TemporaryFolder folder_;
  MachineConfig machine_;
  PadList pads_{"F_Cu.gbr", {}, {}};
  TurnedPanel panel_;
  Survey asked_;
};

TEST_F(AlignedBoard, CarriesAnyPlaceToWhereThePanelHasIt) {
  const Alignment alignment = align();
  EXPECT_EQ(panel_.lines, (std::vector<int>{100, 101, 102, 103})) << "lines of the pads' file";
  EXPECT_EQ(asked_.measurements[2].request.line, 102);
  const auto panel = restore_panel(alignment, machine_, kNow);
  ASSERT_TRUE(panel) << panel.error().text();
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(50, 40), Eigen::Vector2d(-20, 130)}) {
    const auto place = panel->place_of(position_mm<frame::Nominal>(p.x(), p.y()));
    EXPECT_NEAR((place.position.in_mm() - TurnedPanel::true_mm(p)).norm(), 0, 1e-9);
  }
  // In the middle of four pads nothing but the mean of their noise is left.
  const auto middle = panel->place_of(position_mm<frame::Nominal>(50, 40));
  EXPECT_NEAR(std::sqrt(middle.cov(0, 0)), kSigma_mm / 2, 1e-9);
}

TEST_F(AlignedBoard, IsHeldByTheGatesOfAJob) {
  panel_.i_moved = 2;
  panel_.moved_mm = 0.5;
  const auto result = measure_pads(pads_, open(), machine_, kNow);
  ASSERT_TRUE(result);
  EXPECT_FALSE(result->may_be_drilled());
  const Diagnostic reason = result->refusal();
  EXPECT_EQ(reason.place.file, "F_Cu.gbr");
  EXPECT_GE(reason.place.line, 100) << "of the pads' file: " << reason.text();
  const Alignment alignment = align();
  EXPECT_FALSE(alignment.held.empty());
  EXPECT_EQ(refusal(alignment), "gate-failed");
}

TEST_F(AlignedBoard, IsRefusedOnAnotherMachine) {
  const Alignment alignment = align();
  EXPECT_EQ(refusal(alignment), "none");
  write_machine("[machine]\nname = \"m\"\n# another\n");
  EXPECT_EQ(refusal(alignment), "usage");
}

TEST_F(AlignedBoard, IsRefusedIfItsFitIsNotThatOfItsMeasurements) {
  Alignment alignment = align();
  alignment.fit->linear(0, 1) += 1e-6;
  EXPECT_EQ(refusal(alignment), "calibration-invalid");
}

TEST_F(AlignedBoard, HasAnAge) {
  const Alignment alignment = align();
  EXPECT_TRUE(check_age(alignment, kNow + std::chrono::hours(4), std::chrono::hours(4)));
  const auto late =
      check_age(alignment, kNow + std::chrono::seconds(4 * 3600 + 1), std::chrono::hours(4));
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, Code::GateFailed);
  EXPECT_FALSE(check_age(alignment, kNow - std::chrono::seconds(1), std::chrono::hours(4)));
}

/// d = 10 um of one pad, noise of both looks 1 um: chi square = 10^2 / (1 + 1).
TEST_F(AlignedBoard, IsLookedAtAgainAtTheFarthestPads) {
  const auto panel = restore_panel(align(), machine_, kNow);
  ASSERT_TRUE(panel);
  auto look = look_again(*panel, machine_, open());
  ASSERT_TRUE(look) << look.error().text();
  EXPECT_EQ(look->check.pads, (std::vector<int>{1, 3}));
  EXPECT_TRUE(look->check.is_accepted);
  EXPECT_FALSE(look->lost);
  EXPECT_NEAR(look->check.chi_square, 0, 1e-9);
  EXPECT_NEAR(look->check.limit, 18.467, 1e-3) << "four degrees of freedom, 0.1 %";
  panel_.i_moved = 1;  // of the two that are asked for
  panel_.moved_mm = 10e-3;
  look = look_again(*panel, machine_, open());
  ASSERT_TRUE(look);
  EXPECT_NEAR(look->check.chi_square, 50, 1e-6);
  EXPECT_FALSE(look->check.is_accepted);
}

TEST_F(AlignedBoard, IsRefusedOnceAPadIsNotFoundAgain) {
  Alignment alignment = align();
  const auto panel = restore_panel(alignment, machine_, kNow);
  ASSERT_TRUE(panel);
  panel_.i_lost = 1;  // of the two that are asked for: the third pad
  const auto look = look_again(*panel, machine_, open());
  ASSERT_TRUE(look) << look.error().text();
  ASSERT_TRUE(look->lost);
  EXPECT_EQ(look->lost->code, Code::TargetNotFound);
  EXPECT_FALSE(look->check.is_accepted);
  EXPECT_EQ(look->check.pads, (std::vector<int>{1, 3}));
  EXPECT_EQ(look->check.seen.size(), 1U);
  alignment.checks.push_back(look->check);
  const auto refused = restore_panel(alignment, machine_, kNow);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::GateFailed);
  EXPECT_NE(refused.error().text().find("pad 3 was not found"), std::string::npos);
}

/// Work zero of the walk is [-1000, 20] + [100, 50].
TEST_F(AlignedBoard, IsLookedAtFromTheZeroOfItsMeasurement) {
  write_machine(
      "[machine]\nname = \"m\"\n[program]\nabsolute_zero_mm = [-1000, 20]\nwork_zero_mm = [100, "
      "50]\n");
  const auto panel = restore_panel(align(), machine_, kNow);
  ASSERT_TRUE(panel) << panel.error().text();
  const Eigen::Vector2d zero_mm(-900, 70);
  EXPECT_EQ(asked_.measurements[0].request.work_zero.in_mm(), zero_mm);
  ASSERT_TRUE(look_again(*panel, machine_, open()));
  EXPECT_EQ(asked_.measurements[0].request.work_zero.in_mm(), zero_mm);
}

}  // namespace
}  // namespace panelcal
