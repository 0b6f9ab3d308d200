// SPDX-License-Identifier: Apache-2.0
// Boards that a person leaves out: copies of a pattern whose series has a target with the status
// board_left_out. No manual knows them; nothing of such a copy may be worked, whatever its blocks.
#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FunctionSource;
using test::metric;
using test::ProgramRun;
using test::run_program;

constexpr char kThreeBoards[] = "M01\nR2M02X10.\nM08\n";

/// Body lines count from 8; series of one G36 or G46; the targets with these numbers are of boards
/// that are left out.
ProgramRun run_without(const std::string& body, const std::vector<std::int64_t>& seqs) {
  FunctionSource source([](const MeasurementRequest& request) -> Vector2d {
    return request.nominal.in_mm() + Vector2d(0.1 * static_cast<double>(request.seq), 0);
  });
  for (const std::int64_t seq : seqs) {
    source.lose(seq, MeasurementStatus::BoardLeftOut, "board left out by Anna");
  }
  WalkOptions options;
  options.series_size = 1;
  return run_program(metric("G34,1\nT1\n" + body + "M30\n"), options, source);
}

/// The copies whose holes were drilled, in their order, each once.
std::vector<int> drilled_copies(const ProgramRun& run) {
  std::vector<int> copies;
  for (const test::Hole& hole : run.holes()) {
    const int copy = hole.path.empty() ? -1 : hole.path.front();
    if (copies.empty() || copies.back() != copy) copies.push_back(copy);
  }
  return copies;
}

using Copies = std::vector<int>;
using Texts = std::vector<std::string>;

TEST(LeftOutBoard, HasNoHoles) {
  const std::string body = std::string("M25\nG46X0.Y0.\nX1.Y1.\nX2.Y2.\n") + kThreeBoards;
  const ProgramRun run = run_without(body, {1});
  EXPECT_FALSE(run.has_errors) << run.texts.front();
  EXPECT_EQ(run.diagnostics, Texts{"p.exc:9:1: warning[target-dropped]"});
  EXPECT_NE(run.texts.front().find("board 1 is left out"), std::string::npos) << run.texts.front();
  EXPECT_EQ(drilled_copies(run), (Copies{0, 2}));
  ASSERT_EQ(run.holes().size(), 4U);
  // The others go where their own targets are.
  EXPECT_NEAR(run.holes()[3].actual_mm().x() - run.holes()[3].nominal_mm().x(), 0.2, 1e-10);
  EXPECT_TRUE(run.survey.is_complete());
  EXPECT_TRUE(run.survey.is_accepted());
  EXPECT_TRUE(run.survey.series[1].is_left_out);
  EXPECT_EQ(run.survey.left_out_boards().size(), 1U);
}

TEST(LeftOutBoard, HasNoHolesOfAnyToolThatComesLater) {
  const std::string use = std::string("M51,1\nM25\nM52\nX1.Y1.\n") + kThreeBoards;
  const ProgramRun run =
      run_without("M50,1\nM25\nG46X0.Y0.\n" + std::string(kThreeBoards) + use + "T2\n" + use, {2});
  EXPECT_FALSE(run.has_errors) << run.texts.front();
  EXPECT_EQ(drilled_copies(run), (Copies{0, 1, 0, 1}));
}

TEST(LeftOutBoard, HasNoHolesWhereEachBoardHasItsOwnLines) {
  const std::string boards = "M51,1\nM52\nX1.Y1.\nM52\nX11.Y1.\nM52\nX21.Y1.\n";
  const ProgramRun run =
      run_without("M50,1\nM25\nG46X0.Y0.\n" + std::string(kThreeBoards) + boards, {1});
  EXPECT_FALSE(run.has_errors) << run.texts.front();
  ASSERT_EQ(run.holes().size(), 2U);
  EXPECT_EQ(run.holes()[1].nominal_mm(), Vector2d(21, 1));
}

TEST(LeftOutBoard, LeavesNothingToACancelledCorrection) {
  const std::string body = std::string("M25\nG46X0.Y0.\nX1.Y1.\nG47\nX2.Y2.\n") + kThreeBoards;
  EXPECT_EQ(drilled_copies(run_without(body, {1})), (Copies{0, 2}));
}

TEST(LeftOutBoard, IsNotRouted) {
  const std::string body =
      "M25\nG46X0.Y0.\nG00X1.Y1.\nG41\nM15\nG01X2.Y1.\nG03X3.Y2.A1.\nM16\nG40\nG05\n";
  const ProgramRun run = run_without(body + kThreeBoards, {1});
  EXPECT_FALSE(run.has_errors) << run.texts.front();
  const ProgramRun whole = run_without(body + kThreeBoards, {});
  const auto is_contour = [](const std::string& line) {
    return line.find(" plunge") != std::string::npos ||
           line.find(" retract") != std::string::npos || line.find(" rout") != std::string::npos ||
           line.find(" position") != std::string::npos ||
           line.find(" compensation") != std::string::npos;
  };
  const auto n_of = [&](const ProgramRun& one) {
    return std::ranges::count_if(one.executed.lines(), is_contour);
  };
  ASSERT_GT(n_of(whole), 0);
  EXPECT_EQ(3 * n_of(run), 2 * n_of(whole));
  EXPECT_EQ(3 * run.executed.routs().size(), 2 * whole.executed.routs().size());
}

TEST(LeftOutBoard, ChangesToolsAsTheOthersDo) {
  const std::string body = "M25\nG46X0.Y0.\nT2\nX1.Y1.\nT1\nX2.Y2.\n";
  const ProgramRun run = run_without(body + kThreeBoards, {0});
  EXPECT_FALSE(run.has_errors) << run.texts.front();
  ASSERT_EQ(run.holes().size(), 4U);
  EXPECT_EQ(run.holes()[0].drill.tool, 2);
  EXPECT_EQ(run.holes()[1].drill.tool, 1);
}

TEST(LeftOutBoard, NeedsNoneOfItsOtherTargets) {
  // Base series, nested series and a hole at its own target in each copy.
  const std::string body =
      std::string("M25\nG36X0.Y0.\nG46X1.Y0.\nG48X2.Y0.\nX3.Y0.\n") + kThreeBoards;
  const ProgramRun run = run_without(body, {3, 4, 5});
  EXPECT_FALSE(run.has_errors) << run.texts.front();
  EXPECT_EQ(run.diagnostics.size(), 1U);
  EXPECT_EQ(drilled_copies(run), (Copies{0, 2}));
  EXPECT_EQ(run.holes().size(), 4U);
  EXPECT_EQ(run.survey.left_out_boards().size(), 1U);
}

TEST(LeftOutBoard, DrillsNothingAtATargetThatWasFoundAllTheSame) {
  const std::string body = std::string("M25\nG46X0.Y0.\nG48X2.Y0.\n") + kThreeBoards;
  const ProgramRun run = run_without(body, {2});
  EXPECT_FALSE(run.has_errors) << run.texts.front();
  EXPECT_EQ(drilled_copies(run), (Copies{0, 2}));
}

TEST(LeftOutBoard, IsRefusedWhereItIsWorkedAheadOfItsTargets) {
  const std::string body = std::string("M25\nX1.Y1.\nG46X0.Y0.\nX2.Y2.\n") + kThreeBoards;
  const ProgramRun run = run_without(body, {1});
  EXPECT_TRUE(run.has_errors);
  EXPECT_TRUE(run.holes().empty());
  EXPECT_FALSE(run.survey.is_complete());
}

TEST(LeftOutBoard, IsRefusedOutsideOfCopies) {
  EXPECT_TRUE(run_without("G46X0.Y0.\nX1.Y1.\nG46X10.Y0.\nX11.Y1.\n", {0}).has_errors);
  EXPECT_TRUE(run_without("G36X0.Y0.\nX1.Y1.\n", {0}).has_errors);
}

TEST(LeftOutBoard, IsLeftOutByAllSectionsOrByNone) {
  // Each section measures its copies itself: targets 0 to 2, then 3 to 5.
  const std::string section = std::string("M25\nG46X0.Y0.\nX1.Y1.\n") + kThreeBoards;
  const std::string body = section + "T2\n" + section;
  EXPECT_FALSE(run_without(body, {}).has_errors);
  for (const std::int64_t seq : {1, 4}) {
    const ProgramRun run = run_without(body, {seq});
    EXPECT_EQ(run.diagnostics.back(), "p.exc:16:1: error[command-misplaced]");
    EXPECT_NE(run.texts.back().find("lines 9 and 16 both work board 1"), std::string::npos)
        << run.texts.back();
    EXPECT_TRUE(run.holes().empty());
  }
  const ProgramRun run = run_without(body, {1, 4});
  EXPECT_FALSE(run.has_errors) << run.texts.back();
  EXPECT_EQ(drilled_copies(run), (Copies{0, 2, 0, 2}));
}

TEST(LeftOutBoard, IsKnownByItsTargetsWhereAnotherSectionPlacesItOtherwise) {
  const std::string first = std::string("M25\nG46X0.Y0.\nX1.Y1.\n") + kThreeBoards;
  // From the last board, at 20 mm, to the left.
  const std::string second = "T2\nM25\nG46X20.Y0.\nX21.Y1.\nM01\nR2M02X-10.\nM08\n";
  EXPECT_FALSE(run_without(first + second, {}).has_errors);
  EXPECT_TRUE(run_without(first + second, {2}).has_errors);
}

TEST(LeftOutBoard, IsNotWorkedByASectionWithoutTargets) {
  const std::string body = std::string("G36X50.Y50.\nM25\nG46X0.Y0.\nX1.Y1.\nG47\n") +
                           kThreeBoards + "T2\nM25\nX2.Y2.\n" + kThreeBoards;
  EXPECT_FALSE(run_without(body, {}).has_errors);
  const ProgramRun run = run_without(body, {2});
  EXPECT_EQ(run.diagnostics.back(), "p.exc:18:1: error[command-misplaced]");
  EXPECT_TRUE(run.has_errors);
}

TEST(LeftOutBoard, LeavesNoCorrectionToWhatFollowsItsPattern) {
  const std::string body = std::string("M25\nG46X0.Y0.\nX1.Y1.\n") + kThreeBoards;
  EXPECT_FALSE(run_without(body + "X50.Y50.\n", {1}).has_errors);
  const ProgramRun run = run_without(body + "X50.Y50.\n", {2});
  EXPECT_EQ(run.diagnostics.back(), "p.exc:14:1: error[command-misplaced]");
  EXPECT_TRUE(run.holes().empty());
  EXPECT_FALSE(run_without(body + "G47\nX50.Y50.\n", {2}).has_errors);
}

TEST(LeftOutBoard, OfItsOwnLinesHasAnEndOnlyAtTheNextBoard) {
  const std::string measure = "M50,1\nM25\nG46X0.Y0.\n" + std::string(kThreeBoards);
  const std::string use = "M51,1\nM52\nX1.Y1.\nG47\nX2.Y2.\nM52\nX11.Y1.\nM52\nX21.Y1.\n";
  EXPECT_FALSE(run_without(measure + use, {1}).has_errors);
  EXPECT_TRUE(run_without(measure + use, {0}).has_errors);  // X2.Y2. may be of the first board
}

/// Answers once more where a series contradicts a target.
class SecondLook final : public MeasurementSource {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    PANELCAL_TRY(Measurement out, panel_.measure(request));
    if (request.seq == 2)
      out.measured.position =
          out.measured.position + displacement_mm<frame::Actual>(Vector2d(0.5, 0));
    out.measured.cov = 4e-6 * Eigen::Matrix2d::Identity();
    return out;
  }
  bool reconsiders() const override { return true; }
  Expected<std::optional<Measurement>> reconsider(const Contradiction& contradiction) override {
    reasons.push_back(contradiction.reason);
    seqs.push_back(contradiction.worst.request.seq);
    if (answers.empty()) return std::nullopt;
    Measurement out = contradiction.worst;
    out.status = answers.back();
    out.measured.position = position_mm<frame::Actual>(out.request.expected.in_mm());
    answers.pop_back();
    return out;
  }

  std::vector<MeasurementStatus> answers;
  std::vector<std::int64_t> seqs;
  Texts reasons;

 private:
  NominalSource panel_;
};

constexpr char kFourTargets[] =
    "G34,1\nG36X0.Y0.\nG36X100.Y0.\nG36X100.Y80.\nG36X0.Y80.\nT1\nX50.Y50.\nM30\n";

ProgramRun run_four(SecondLook& source) {
  WalkOptions options;
  options.series_size = 4;
  options.base_limits.residual = um(50);
  options.base_limits.false_alarm = 0.001;
  return run_program(metric(kFourTargets), options, source);
}

TEST(ContradictedTarget, HoldsTheJobWhereItStays) {
  SecondLook source;
  EXPECT_TRUE(run_four(source).has_errors);
  EXPECT_EQ(source.seqs, std::vector<std::int64_t>{2});
  EXPECT_NE(source.reasons[0].find("target 3"), std::string::npos) << source.reasons[0];
}

TEST(ContradictedTarget, IsFittedAgainByItsNewAnswer) {
  SecondLook source;
  source.answers = {MeasurementStatus::Found};
  const ProgramRun run = run_four(source);
  EXPECT_TRUE(run.diagnostics.empty()) << run.texts.front();
  EXPECT_EQ(source.seqs.size(), 1U);
  EXPECT_EQ(run.holes().size(), 1U);
}

TEST(ContradictedTarget, MayBeSkipped) {
  SecondLook source;
  source.answers = {MeasurementStatus::Skipped};
  const ProgramRun run = run_four(source);
  EXPECT_FALSE(run.has_errors) << run.texts.front();
  ASSERT_EQ(run.survey.series.size(), 1U);
  EXPECT_EQ(run.survey.series[0].points, (std::vector<std::size_t>{0, 1, 3}));
}

TEST(ContradictedTarget, HoldsTheJobWhereItIsLostAtTheSecondLook) {
  SecondLook source;
  source.answers = {MeasurementStatus::NotFound};
  const ProgramRun run = run_four(source);
  EXPECT_EQ(run.diagnostics.front(), "p.exc:9:1: error[target-not-found]");
  EXPECT_EQ(source.seqs.size(), 1U);
}

}  // namespace
}  // namespace panelcal
