// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/recheck.h"

#include <cmath>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

using internal::farthest_pair;
using internal::look_again;

constexpr double kSigma_mm = 0.002;

Measurement measured(std::int64_t seq, double x_mm, double y_mm) {
  Measurement out;
  out.request.seq = seq;
  out.request.nominal = position_mm<frame::Nominal>(x_mm, y_mm);
  out.request.expected = position_mm<frame::Actual>(x_mm, y_mm);
  out.status = MeasurementStatus::Found;
  out.measured = {position_mm<frame::Actual>(x_mm, y_mm),
                  kSigma_mm * kSigma_mm * Eigen::Matrix2d::Identity()};
  return out;
}

/// The panel, moved.
class MovedPanel final : public MeasurementSource {
 public:
  explicit MovedPanel(Eigen::Vector2d by_mm) : by_mm_(std::move(by_mm)) {}
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    ++n_looks;
    if (is_gone) return Measurement{.request = request};
    Measurement out = measured(request.seq,
                               request.expected.in_mm().x() + by_mm_.x(),
                               request.expected.in_mm().y() + by_mm_.y());
    out.request = request;
    return out;
  }
  int n_looks = 0;
  bool is_gone = false;

 private:
  Eigen::Vector2d by_mm_;
};

Survey survey_of(const std::vector<Measurement>& all) {
  Survey out;
  out.measurements = all;
  return out;
}

TEST(Recheck, TakesTheTwoTargetsThatAreFarthestApart) {
  std::vector<Measurement> all = {measured(0, 0, 0), measured(1, 100, 0), measured(2, 50, 10)};
  EXPECT_EQ(farthest_pair(all), std::pair(std::size_t{0}, std::size_t{1}));
  // Where a person has pointed, the camera has not looked.
  all[1].decision.by = Decider::Hand;
  EXPECT_EQ(farthest_pair(all), std::pair(std::size_t{0}, std::size_t{2}));
  all[2].status = MeasurementStatus::Skipped;
  EXPECT_FALSE(farthest_pair(all));
  EXPECT_FALSE(farthest_pair({}));
}

TEST(Recheck, NoticesAPanelThatWasMoved) {
  const std::vector<Measurement> all = {measured(0, 0, 0), measured(1, 100, 0)};
  // chi^2 = 2 targets d^2 / (2 sigma^2) = (d / sigma)^2; its 4 degrees of freedom exceed 18.47 once
  // in a thousand times (tables of chi^2), so the limit is 4.30 sigma.
  for (const auto& [d_sigmas, agrees] : {std::pair(4.2, true), std::pair(4.4, false)}) {
    MovedPanel panel({d_sigmas * kSigma_mm, 0});
    const auto recheck = look_again(all[0], all[1], survey_of(all), {}, panel);
    ASSERT_TRUE(recheck);
    EXPECT_EQ(recheck->agrees, agrees) << recheck->words;
    EXPECT_EQ(panel.n_looks, 2);
  }
}

TEST(Recheck, KnowsThatTheStageDoesNotArriveTwiceAtOnePlace) {
  const std::vector<Measurement> all = {measured(0, 0, 0), measured(1, 100, 0)};
  MovedPanel panel({0.010, 0});
  MachineUncertainty machine;
  EXPECT_FALSE(look_again(all[0], all[1], survey_of(all), machine, panel)->agrees);
  machine.stage_repeatability = um(10);
  EXPECT_TRUE(look_again(all[0], all[1], survey_of(all), machine, panel)->agrees);
}

TEST(Recheck, TakesAPanelThatIsGoneForMoved) {
  const std::vector<Measurement> all = {measured(0, 0, 0), measured(1, 100, 0)};
  MovedPanel panel({0, 0});
  panel.is_gone = true;
  const auto recheck = look_again(all[0], all[1], survey_of(all), {}, panel);
  ASSERT_TRUE(recheck);
  EXPECT_FALSE(recheck->agrees);
}

}  // namespace
}  // namespace panelcal
