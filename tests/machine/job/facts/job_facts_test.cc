// SPDX-License-Identifier: Apache-2.0
#include "machine/job/facts/job_facts.h"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/machine/job/facts/facts_job.h"

namespace panelcal {
namespace {

using facts::Json;
using test::facts_of;
using test::kHoles;
using test::kProgram;
using test::kTargets;
using test::lose;
using test::run;
using test::shear;
using test::turn;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

std::string grounds(const Json& facts) {
  return facts["verdict"]["grounds"];
}

std::string next_of(const Json& facts) {
  return facts["verdict"]["next"];
}

TEST(JobFacts, SayDrillWhenAllIsInsideItsLimits) {
  const Json facts = facts_of(*run(kProgram));
  EXPECT_EQ(facts["facts"], "job");
  EXPECT_EQ(facts["verdict"]["word"], "drill");
  EXPECT_EQ(next_of(facts), "Load corrected.drl and drill.");
  EXPECT_EQ(facts["n_found"], kTargets);
  EXPECT_EQ(facts["targets"].size(), kTargets);
  EXPECT_EQ(facts["places"]["n_holes"], kHoles);
  EXPECT_EQ(facts["truth"]["all"]["n"], kHoles);
}

TEST(JobFacts, HaveEveryTargetWithItsPictureByName) {
  const auto job = run(kProgram);
  const Json facts = facts_of(*job);
  const auto pictures = job_pictures(job->input);
  ASSERT_EQ(pictures.size(), kTargets);
  for (int seq = 0; seq < kTargets; ++seq) {
    const Json& target = facts["targets"][static_cast<std::size_t>(seq)];
    EXPECT_EQ(target["seq"], seq);
    EXPECT_EQ(pictures.at(target["pictures"][0]["crop"]["name"].get<std::string>()),
              "jpeg of " + std::to_string(seq));
  }
}

/// Of several inspections of one view the last is enough.
TEST(JobFacts, HaveOnePictureOfEachView) {
  const auto job = run(kProgram);
  std::vector<SeenPicture>& seen = job->input.pictures[3];
  seen.resize(4);
  for (std::size_t i = 0; i < 4; ++i) {
    seen[i].i_view = static_cast<int>(i / 2);
    seen[i].picture.jpeg = "inspection " + std::to_string(i);
  }
  const Json pictures = facts_of(*job)["targets"][3]["pictures"];
  ASSERT_EQ(pictures.size(), 2);
  EXPECT_EQ(pictures[1]["view"], 1);
  EXPECT_EQ(job_pictures(job->input).at(pictures[1]["crop"]["name"].get<std::string>()),
            "inspection 3");
}

TEST(JobFacts, NameTheTargetThatWasNotFound) {
  const Json facts = facts_of(*run(kProgram, lose));
  EXPECT_EQ(facts["verdict"]["word"], "hold");
  EXPECT_TRUE(facts["output"].is_null());
  EXPECT_THAT(next_of(facts),
              HasSubstr("Look at G46 target #4 in line 17, board [0], nominal (95.000, 15.000)"));
  EXPECT_EQ(facts["targets"][4]["state"], "refused");
  EXPECT_EQ(facts["targets"][4]["reason"], "no disc <1 mm> & nothing like it");
  EXPECT_TRUE(facts["targets"][4]["measured"].is_null());
  EXPECT_TRUE(facts["places"].is_null());
}

TEST(JobFacts, NameTheWorstTargetOfARefusedFitAndClaimNoMore) {
  const Json facts = facts_of(*run(kProgram, shear));
  EXPECT_EQ(facts["verdict"]["word"], "hold");
  // One spare equation cannot tell which of the three moved.
  EXPECT_THAT(next_of(facts), ContainsRegex("Look at G46 target #[345] in line 1[678], board"));
  EXPECT_THAT(next_of(facts), HasSubstr("with 1 equation to spare, any of the 3 targets"));
  const Json& board = facts["series"][1];
  EXPECT_EQ(board["is_accepted"], false);
  EXPECT_EQ(board["fit"]["chi_square"]["means"], "too_large_weak");
}

TEST(JobFacts, SuspectTargetsWhenTheFitFollowsAWrongOne) {
  const Json facts = facts_of(*run(kProgram, turn));
  EXPECT_EQ(facts["verdict"]["word"], "hold");
  EXPECT_THAT(next_of(facts),
              HasSubstr("Look at targets #3, #4, #5 (Board [0], line 16: rotation is 5."));
  EXPECT_EQ(facts["targets"][3]["state"], "suspect");
}

/// It was found, so nothing else would tell it from those that the fit rests on.
TEST(JobFacts, MarkATargetThatWasLeftOut) {
  const auto job = run(kProgram);
  SeriesResult& board = job->survey.series.at(1);
  ASSERT_EQ(board.points, (std::vector<std::size_t>{3, 4, 5}));
  board.points = {3, 5};
  board.dropped = {4};
  const Json facts = facts_of(*job);
  EXPECT_EQ(facts["targets"][4]["state"], "left_out");
  EXPECT_EQ(facts["targets"][4]["status"], "found");
  EXPECT_EQ(facts["n_left_out"], 1);
  EXPECT_EQ(facts["series"][1]["left_out"], Json::array({4}));
  EXPECT_THAT(grounds(facts), HasSubstr("One target was left out of its fit."));
}

TEST(JobFacts, SayForcedWhenWrittenAllTheSame) {
  const Json facts = facts_of(*run(kProgram, shear, true));
  EXPECT_EQ(facts["verdict"]["word"], "forced");
  EXPECT_THAT(next_of(facts), HasSubstr("Before drilling: Look at"));
}

TEST(JobFacts, ShowAProgramWithoutTargets) {
  const Json facts =
      facts_of(*run("M48\nMETRIC,TZ\nFMAT,2\nT1C0.8\n%\nG90\nT1\nX10.0Y10.0\nX20.0Y10.0\nM30\n"));
  EXPECT_EQ(facts["verdict"]["word"], "drill");
  EXPECT_THAT(grounds(facts), HasSubstr("The program has no targets"));
  EXPECT_EQ(facts["places"]["table"]["nominal_x_mm"].dump(), "[10.0,20.0]");
}

TEST(JobFacts, ShowAnEmptyInput) {
  const Json facts = Json::parse(job_facts({}));
  EXPECT_EQ(facts["verdict"]["word"], "hold");
  EXPECT_EQ(facts["series"], Json::array());
}

/// A camera's wrong scale moves holes without any target that is off.
TEST(JobFacts, NameACommonScaleInTheVerdict) {
  const auto job = run(kProgram);
  const std::string words = "all 21 targets measure 2.0 % larger than stated";
  EXPECT_THAT(grounds(facts_of(*job)), Not(HasSubstr(words)));
  job->input.common_scale = words;
  EXPECT_THAT(grounds(facts_of(*job)), HasSubstr("But " + words + "."));
}

TEST(JobFacts, NameGatesThatAreOff) {
  const auto job = run(kProgram);
  EXPECT_THAT(grounds(facts_of(*job)),
              HasSubstr("Gates off: false alarm, false alarm of nested fits."));
  for (SeriesResult& series : job->survey.series) series.limits.false_alarm = 1e-3;
  const Json facts = facts_of(*job);
  EXPECT_THAT(grounds(facts), Not(HasSubstr("Gates off")));
  EXPECT_EQ(facts["series"][0]["limits"],
            "residual 25 um, rotation 5 mrad, stretch 500 ppm, offset 2 mm, false alarm 0.001, no "
            "mirror");
}

TEST(JobFacts, KeepHostileTextsAsTexts) {
  const std::string hostile = "\"></script><script>alert('x')</script>&\xff\x01\n";
  const std::string replaced = "\"></script><script>alert('x')</script>&\xef\xbf\xbd\x01\n";
  const auto job = run(kProgram, [&](Measurement& m) {
    m.image = hostile;
    m.reason = hostile;
    if (m.request.seq == 4) m.status = MeasurementStatus::Rejected;
  });
  JobFactsInput& input = job->input;
  input.program_file = input.machine_name = input.source = hostile;
  input.provenance.emplace_back(hostile, hostile);
  const std::vector<Diagnostic> diagnostics = {
      {Code::FileUnreadable, {hostile, 1, 2}, hostile, hostile}};
  input.diagnostics = diagnostics;
  const Json facts = facts_of(*job);
  EXPECT_EQ(facts["program"], replaced);
  EXPECT_EQ(facts["targets"][4]["reason"], replaced);
  EXPECT_EQ(facts["provenance"][1]["key"], replaced);
}

TEST(JobFacts, HaveNullForNumbersThatAreNone) {
  const auto job = run(kProgram);
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    job->survey.measurements[0].request.nominal = position_mm<frame::Nominal>(bad, -bad);
    job->survey.measurements[1].measured.position = position_mm<frame::Actual>(bad, bad);
    job->survey.series[0].gates[0].value = bad;
    const Json facts = facts_of(*job);
    EXPECT_TRUE(facts["targets"][0]["nominal_mm"][0].is_null());
    EXPECT_TRUE(facts["targets"][1]["measured"]["place_mm"][1].is_null());
    EXPECT_TRUE(facts["series"][0]["gates"][0]["value"].is_null());
  }
}

/// `history verify --against` reads it in a report as in a night's record.
TEST(JobFacts, NoteTheLedgersHead) {
  const auto job = run(kProgram);
  EXPECT_TRUE(facts_of(*job)["ledger_head"].is_null());
  job->input.provenance.emplace_back("ledger head", "12 " + std::string(64, 'a'));
  EXPECT_EQ(facts_of(*job)["ledger_head"], Json({{"id", 12}, {"hash", std::string(64, 'a')}}));
  job->input.provenance.back().second = "not known: cut off";
  EXPECT_TRUE(facts_of(*job)["ledger_head"].is_null());
}

/// Up to 10,000 places are numbers, more are bytes: 10,001 floats of 4 bytes, and 4 characters for
/// each 3 of them.
TEST(JobFacts, PackManyPlaces) {
  std::string text = "M48\nMETRIC,TZ\nFMAT,2\nT1C0.3\n%\nG90\nT1\n";
  for (int i = 0; i < 10'000; ++i) text += "X" + std::to_string(i) + ".0Y5.0\n";
  const Json few = facts_of(*run(text + "M30\n"))["places"]["table"];
  EXPECT_EQ(few["is_packed"], false);
  EXPECT_EQ(few["line"].size(), 10'000);
  const Json many = facts_of(*run(text + "X7.0Y9.0\nM30\n"))["places"]["table"];
  EXPECT_EQ(many["is_packed"], true);
  EXPECT_EQ(many["n"], 10'001);
  EXPECT_EQ(many["nominal_x_mm"]["type"], "float32");
  EXPECT_EQ(many["nominal_x_mm"]["base64"].get<std::string>().size(), (4 * 10'001 + 2) / 3 * 4);
  EXPECT_EQ(many["tool"]["type"], "uint32");
}

TEST(JobFacts, AreTheSameBytesForTheSameJob) {
  EXPECT_EQ(job_facts(run(kProgram)->input), job_facts(run(kProgram)->input));
}

}  // namespace
}  // namespace panelcal
