// SPDX-License-Identifier: Apache-2.0
#include "program/walk/series_assignment.h"

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::metric;
using test::ProgramRun;
using test::run_program;
using test::says;

/// Three fiducials from line 8 on, and a hole.
const std::string kAssignedBody = "G34,1\nT1\nG36X0.Y0.\nG36X120.Y0.\nG36X0.Y90.\nX60.Y40.\nM30\n";
/// A SIEB & MEYER program with a tool of 1 mm.
std::string optical_program(std::string_view body) {
  return "%%5000\n" + std::string(body) + "$\nT1D1.\n$\n";
}

MeasuredCandidate candidate_at(const Vector2d& place_mm, double score = 0.95) {
  MeasuredCandidate out;
  out.place = {position_mm<frame::Actual>(place_mm), 4e-6 * Eigen::Matrix2d::Identity()};
  out.score = score;
  out.counts = true;
  return out;
}

/// Pictures of 8 x 6 mm that show these pads about each expected place; the picture alone takes the
/// pad with the best score, or none of several that are alike.
class RowSource final : public MeasurementSource {
 public:
  explicit RowSource(std::vector<std::vector<Vector2d>> pads_mm) : pads_mm_(std::move(pads_mm)) {}

  Expected<Measurement> measure(const MeasurementRequest& request) override {
    Measurement out{.request = request};
    const Vector2d at = request.expected.in_mm();
    for (const Vector2d& off : pads_mm_[static_cast<std::size_t>(request.seq)]) {
      out.candidates.push_back(candidate_at(at + off));
    }
    out.listed.emplace();
    out.listed->corners = {position_mm<frame::Actual>(Vector2d(at + Vector2d(-4, -3))),
                           position_mm<frame::Actual>(Vector2d(at + Vector2d(4, -3))),
                           position_mm<frame::Actual>(Vector2d(at + Vector2d(4, 3))),
                           position_mm<frame::Actual>(Vector2d(at + Vector2d(-4, 3)))};
    const std::size_t n = out.candidates.size();
    out.status = n == 1  ? MeasurementStatus::Found
                 : n > 1 ? MeasurementStatus::Ambiguous
                         : MeasurementStatus::NotFound;
    if (n == 1) out.measured = out.candidates[0].place;
    if (n != 1) out.reason = std::to_string(n) + " candidates";
    return out;
  }

 private:
  std::vector<std::vector<Vector2d>> pads_mm_;
};

WalkOptions assigning() {
  WalkOptions options;
  options.base_limits.rotation = rad(4e-3);
  options.base_limits.stretch_ppm = 400;
  options.base_limits.residual = um(40);
  return options;
}

const Vector2d kRowShift(2.20, 0);
const Vector2d kRowPitch(2.19, 0);

TEST(SeriesAssignment, TakesTheShiftThatAllTargetsShare) {
  RowSource source(
      {{kRowShift - kRowPitch, kRowShift}, {kRowShift, kRowShift - kRowPitch}, {kRowShift}});
  const ProgramRun run = run_program(metric(kAssignedBody), assigning(), source);
  EXPECT_FALSE(run.has_errors);
  EXPECT_TRUE(run.survey.is_accepted());
  ASSERT_EQ(run.holes().size(), 1U);
  EXPECT_LT((run.holes()[0].corrected_mm() - Vector2d(62.20, 40)).norm(), 1e-3);
  ASSERT_TRUE(run.survey.series[0].assignment);
  const SeriesAssignment& assignment = *run.survey.series[0].assignment;
  EXPECT_TRUE(assignment.is_certain());
  EXPECT_EQ(assignment.n_candidates, (std::vector<std::size_t>{2, 2, 1}));
  EXPECT_NE(assignment.text().find("shift (+2.200, "), std::string::npos) << assignment.text();
}

TEST(SeriesAssignment, HoldsTheJobAndShowsBothWays) {
  const std::vector<Vector2d> row = {kRowShift - kRowPitch, kRowShift};
  RowSource source({row, row, row});
  const ProgramRun run = run_program(metric(kAssignedBody), assigning(), source);
  EXPECT_TRUE(run.has_errors);
  EXPECT_TRUE(run.holes().empty());
  ASSERT_EQ(run.texts.size(), 1U);
  EXPECT_THAT(run.texts[0], says(8, "error[series-ambiguous]"));
  EXPECT_THAT(run.texts[0], testing::HasSubstr("shift (+2.200, "));
  EXPECT_THAT(run.texts[0], testing::HasSubstr("shift (+0.010, "));
  for (const Measurement& measurement : run.survey.measurements) {
    EXPECT_EQ(measurement.status, MeasurementStatus::Ambiguous);
  }
}

/// The third picture shows a neighbour of the target, and the target's own place is empty.
TEST(SeriesAssignment, SaysWhereTheOthersHaveAMissingTarget) {
  RowSource source(
      {{kRowShift - kRowPitch, kRowShift}, {kRowShift}, {kRowShift + Vector2d(-3, 2)}});
  const ProgramRun run = run_program(metric(kAssignedBody), assigning(), source);
  EXPECT_THAT(run.texts, testing::Contains(says(10, "error[target-not-found]")));
  EXPECT_TRUE(run.holes().empty());
}

/// G32 waits for G31: what it found ambiguous is chosen then.
TEST(SeriesAssignment, ChoosesTheTargetsOfG31) {
  const std::string body = "X0.Y0.G32\nX120.Y0.G32\nX0.Y90.G32\nG31\nX60.Y40.T1\nG30\n";
  RowSource source(
      {{kRowShift - kRowPitch, kRowShift}, {kRowShift, kRowShift - kRowPitch}, {kRowShift}});
  const ProgramRun run = run_program(optical_program(body), assigning(), source);
  EXPECT_FALSE(run.has_errors);
  ASSERT_EQ(run.holes().size(), 1U);
  EXPECT_LT((run.holes()[0].corrected_mm() - Vector2d(62.20, 40)).norm(), 1e-3);
  ASSERT_TRUE(run.survey.series[0].assignment);

  const std::vector<Vector2d> row = {kRowShift - kRowPitch, kRowShift};
  RowSource alike({row, row, row});
  const ProgramRun held = run_program(optical_program(body), assigning(), alike);
  EXPECT_THAT(held.texts, testing::ElementsAre(testing::HasSubstr("error[series-ambiguous]")));
}

/// One picture alone has no others to be held against.
TEST(SeriesAssignment, LeavesSingleTargetsToTheirPicture) {
  RowSource source({{kRowShift - kRowPitch, kRowShift}});
  const ProgramRun run =
      run_program(metric("G34,1\nT1\nG35X0.Y0.\nX60.Y40.\nM30\n"), assigning(), source);
  EXPECT_THAT(run.texts, testing::Contains(says(8, "error[target-ambiguous]")));
  EXPECT_FALSE(run.survey.series[0].assignment);
}

/// As before: what each picture found alone goes to the gates.
TEST(SeriesAssignment, IsNotAskedWithoutAChoice) {
  RowSource source({{kRowShift}, {kRowShift}, {kRowShift + Vector2d(0, 0.3)}});
  const ProgramRun run = run_program(metric(kAssignedBody), assigning(), source);
  EXPECT_FALSE(run.survey.series[0].assignment);
  EXPECT_THAT(run.texts, testing::Contains(testing::HasSubstr("gate-failed")));
}

}  // namespace
}  // namespace panelcal
