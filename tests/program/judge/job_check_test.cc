// SPDX-License-Identifier: Apache-2.0
#include "program/judge/job_check.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::Reports;
using testing::ElementsAre;

using Texts = std::vector<std::string>;

/// Texts of the check of a program that is in order otherwise.
Texts texts_of(const std::string& text,
               std::optional<Travel> travel = std::nullopt,
               const WalkOptions& options = {}) {
  DiagnosticLog log;
  Program program = load_program({"p.exc", text}, log);
  program.patterns.emplace("PINS", SourceText{"PINS", "X0.Y0.\nX5.Y0.\n"});
  NominalSource source;
  const Survey survey = panelcal::survey(program, options, source, log);
  EXPECT_FALSE(log.has_errors()) << log.kept().front().text();
  JobCheck check(travel);
  execute(program, options, survey, check, log);
  DiagnosticLog found;
  check.report(program, found);
  Texts texts;
  for (const Diagnostic& diagnostic : found.kept()) texts.push_back(diagnostic.text());
  return texts;
}

/// The same without the wording.
Texts checked(const std::string& text,
              const std::optional<Travel>& travel = std::nullopt,
              const WalkOptions& options = {}) {
  Texts briefs;
  for (const std::string& one : texts_of(text, travel, options)) {
    briefs.push_back(one.substr(0, one.find(']') + 1));
  }
  return briefs;
}

/// Metric, with two tools that have feeds; the body begins in line 6.
std::string program(const std::string& body) {
  return "M48\nMETRIC,LZ\nT1C1.0F100\nT2C2.0F100\n%\n" + body + "M30\n";
}

/// `n` holes in blocks of their own, step_um apart along x.
std::string row(int n, int step_um) {
  std::string out;
  for (int i = 0; i < n; ++i) {
    std::string micrometres = std::to_string(1'000'000 + i * step_um);
    out += "X" + micrometres.substr(1, 3) + "." + micrometres.substr(4) + "Y0.\n";
  }
  return out;
}

Travel square_mm(double low, double high) {
  return {position_mm<frame::Machine>(low, low), position_mm<frame::Machine>(high, high)};
}

TEST(JobCheck, SaysNothingOfAGoodProgram) {
  const std::string all =
      "T1\n" + row(12, 2'540) + "T2\nX9.Y9.\nG00X1.Y1.\nF030\nM15\nG01X20.\nM17\nG05\n";
  EXPECT_EQ(checked(program(all), square_mm(0, 100)), Texts{});
}

TEST(JobCheck, SaysNothingOfAProgramThatDoesNothing) {
  EXPECT_EQ(checked(program("")), Texts{});
}

// --- tools and feeds -----------------------------------------------------------------------------

TEST(JobCheck, CamFilesWithoutFeedsAreToldOnce) {
  EXPECT_THAT(texts_of("M48\nMETRIC\nT1C0.6\nT2C1.0\n%\nG90\nG05\nT1\nX1.Y1.\nX2.Y1.\nT2\nX3.Y1.\n"
                       "T1\nX9.Y9.\nM30\n"),
              ElementsAre(Reports("p.exc: warning[feed-missing]", "T1, T2")));
}

TEST(JobCheck, AnInfeedMayComeInTheBody) {
  const std::string header = "M48\nMETRIC\nT1C1.0\n%\n";
  EXPECT_EQ(checked(header + "T1F100\nX1.Y1.\nM30\n"), Texts{});
  EXPECT_EQ(checked(header + "T1\nF100\nX1.Y1.\nM30\n"), Texts{});
}

TEST(JobCheck, RoutingNeedsATableFeed) {
  const std::string rout = "T1\nG00X1.Y1.\nM15\nG01X9.\nM17\nT2\nX1.Y1.\n";
  EXPECT_EQ(checked(program(rout.substr(0, rout.find("T2")) + "T2\nG05\nX1.Y1.\n")),
            Texts{"p.exc: warning[feed-missing]"});
  EXPECT_EQ(checked(program("T1\nG00X1.Y1.\nM15\nG01X9.F050\nM17\nT2\nG05\nX1.Y1.\n")), Texts{});
}

TEST(JobCheck, EachToolOfTheHeaderIsToBeUsed) {
  const std::string t2 = "p.exc:4:1: warning[tool-unused]";
  EXPECT_EQ(checked(program("T1\nX1.Y1.\n")), Texts{t2});
  EXPECT_EQ(checked(program("T1\nX1.Y1.\nT2\n")), Texts{t2});
  EXPECT_EQ(checked(program("T1\nX1.Y1.\nT2\nG00X1.Y1.\nF050\nM15\nG01X9.\nM17\n")), Texts{});
  EXPECT_EQ(checked(program("T1\nX1.Y1.\nT2\nX1.Y1.G85X9.Y1.\n")), Texts{});
}

TEST(JobCheck, CompensationNeedsAValue) {
  const std::string t1 = "T1\nG00X1.Y1.F050\nG41\nM15\nG01X9.\nM17\n";
  const std::string t2 = "T2\nG00X1.Y2.\nG42\nM15\nG01X9.\nM17\n";
  const auto with = [](const std::string& header, const std::string& body) {
    return "M48\nMETRIC,LZ\n" + header + "T1C1.0F100\nT2C1.0F100\n%\n" + body + "M30\n";
  };
  EXPECT_EQ(checked(with("CP,1,1.0\nCP,2,1.0\n", t1 + t2)), Texts{});
  EXPECT_THAT(texts_of(with("", t1 + t2)),
              ElementsAre(Reports("p.exc:9:1: warning[compensation-missing]", "T1, T2")));
  EXPECT_THAT(texts_of(with("CP,1,1.0\n", t1 + t2)),
              ElementsAre(Reports("p.exc:16:1: warning[compensation-missing]", "T2")));
}

TEST(JobCheck, NoCompensationNeedsNoValue) {
  EXPECT_EQ(checked(program("T1\nG00X1.Y1.F050\nG40\nM15\nG01X9.\nM17\nT2\nG05\nX1.Y1.\n")),
            Texts{});
}

// --- travel --------------------------------------------------------------------------------------

TEST(JobCheck, TheTravelIncludesItsEdges) {
  EXPECT_EQ(checked(program("T1\nX0.Y0.\nT2\nX100.Y100.\n"), square_mm(0, 100)), Texts{});
}

TEST(JobCheck, NamesTheFirstPlaceOutsideTheTravel) {
  EXPECT_THAT(texts_of(program("T1\nX0.Y0.\nX-.001\nX50.\nT2\nX100.001\n"), square_mm(0, 100)),
              ElementsAre(Reports("p.exc:8:1: error[travel-exceeded]",
                                  "(-0.001, 0.000)",
                                  "(0.000, 0.000)",
                                  "(100.000, 100.000) mm")));
}

TEST(JobCheck, TravelHoldsForMachineCoordinates) {
  WalkOptions options;
  options.work_zero = position_mm<frame::Machine>(200, 0);
  const std::string text = program("T1\nX1.Y1.\nT2\nX2.Y2.\n");
  EXPECT_EQ(checked(text, square_mm(0, 100)), Texts{});
  EXPECT_EQ(checked(text, square_mm(0, 100), options).size(), 1U);
}

TEST(JobCheck, TravelHoldsForMovesRoutsAndSlots) {
  for (const char* body : {"G00X101.Y1.\n",
                           "G00X1.Y1.\nF050\nM15\nG01X101.\nM17\n",
                           "X1.Y1.G85X101.Y1.\n",
                           "X101.Y1.G85X1.Y1.\n",
                           "X101.Y1.G87X1.Y1.Z-1.U2.\n",
                           "G38X101.Y1.\n"}) {
    for (const Cycles cycles : {Cycles::Kept, Cycles::Expanded}) {
      WalkOptions options;
      options.slots = options.step_slots = cycles;
      const Texts texts =
          checked(program("G34,1\nT1\n" + std::string(body)), square_mm(0, 100), options);
      const auto is_told = [](const std::string& text) {
        return text.find("p.exc:") == 0 && text.find("travel-exceeded") != std::string::npos;
      };
      EXPECT_EQ(std::ranges::count_if(texts, is_told), 1) << body;
    }
  }
}

TEST(JobCheck, NamesTheFileOfAStoredPattern) {
  EXPECT_THAT(texts_of(program("T2\nX1.Y1.\nT1\nM99,PINS\nX97.Y0.\n"), square_mm(0, 100)),
              ElementsAre(Reports("PINS:2:1: error[travel-exceeded]", "(102.000, 0.000)")));
}

// --- scale ---------------------------------------------------------------------------------------

TEST(JobCheck, HolesThatOverlapAreSuspicious) {
  EXPECT_THAT(texts_of(program("T2\nX0.Y0.\nT1\n" + row(12, 100))),
              ElementsAre(Reports("p.exc: warning[scale-suspicious]", "1.1 x 0 mm")));
}

TEST(JobCheck, HolesThatTouchAreNot) {
  EXPECT_EQ(checked(program("T2\nX0.Y0.\nT1\n" + row(12, 500))), Texts{});
}

TEST(JobCheck, FewHolesSayNothing) {
  EXPECT_EQ(checked(program("T2\nX0.Y0.\nT1\n" + row(9, 100))), Texts{});
}

TEST(JobCheck, HolesOfOneBlockMayOverlap) {
  EXPECT_EQ(checked(program("T1\nX0.Y0.\nT2\nX9.Y9.\nR20X.1\nX9.Y9.G84X5.\n")), Texts{});
}

TEST(JobCheck, AJobLargerThanAnyTableIsSuspicious) {
  EXPECT_THAT(texts_of(program("T2\nX0.Y0.\nT1\nX1.Y1.\nM25\nX2.Y0.\nM01\nR3M02X999.\nM08\n")),
              ElementsAre(Reports("p.exc: warning[scale-suspicious]", "2999 x 1 mm")));
}

TEST(JobCheck, AJobSmallerThanAHoleIsSuspicious) {
  EXPECT_THAT(texts_of("M48\nMETRIC,LZ\nT1C.05F100\n%\nT1\n" + row(12, 50) + "M30\n"),
              ElementsAre(Reports("p.exc: warning[scale-suspicious]", "0.55 x 0 mm")));
}

TEST(JobCheck, DiametersOfNoDrillAreSuspicious) {
  EXPECT_THAT(texts_of("M48\nMETRIC,LZ\nT1C.01F100\n%\nT1\n" + row(12, 2'540) + "M30\n"),
              ElementsAre(Reports("p.exc: warning[scale-suspicious]", "27.94 x 0 mm")));
}

}  // namespace
}  // namespace panelcal
