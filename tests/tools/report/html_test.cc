// SPDX-License-Identifier: Apache-2.0
#include "tools/report/html.h"

#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/statistics/random.h"
#include "tools/figures/text.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/report/markup.h"
#include "tests/tools/report/report_job.h"

namespace panelcal {
namespace {

using test::attributes;
using test::count;
using test::decoded_base64;
using test::kHoles;
using test::kProgram;
using test::kTargets;
using test::lose;
using test::markup_problem;
using test::run;
using test::shear;
using test::turn;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(ReportHtml, SaysDrillWhenAllIsInsideItsLimits) {
  const auto job = run(kProgram);
  const std::string html = report_html(job->input);
  EXPECT_THAT(html, HasSubstr("DRILL"));
  EXPECT_THAT(html, Not(HasSubstr("HOLD")));
  EXPECT_THAT(html, HasSubstr("Load corrected.drl and drill."));
  EXPECT_THAT(html, HasSubstr("9 of 9"));
  EXPECT_EQ(job->tally.n_holes(), kHoles);
  EXPECT_THAT(html, HasSubstr("<dt>holes</dt><dd>5<"));
  EXPECT_THAT(html, HasSubstr("Errors against truth"));
}

TEST(ReportHtml, HasOneCardForEveryTarget) {
  const std::string html = report_html(run(kProgram)->input);
  EXPECT_EQ(count(html, "<article class=\"card"), kTargets);
  for (int seq = 0; seq < kTargets; ++seq) {
    EXPECT_EQ(count(html, " id=\"target-" + std::to_string(seq) + "\""), 1) << seq;
  }
}

TEST(ReportHtml, EmbedsThePicturesWhole) {
  const auto job = run(kProgram);
  std::map<std::size_t, int> n_by_size;
  constexpr std::string_view kPrefix = "data:image/png;base64,";
  for (const std::string& src : attributes(report_html(job->input), "src")) {
    ASSERT_TRUE(src.starts_with(kPrefix));
    const auto png = decoded_base64(std::string_view(src).substr(kPrefix.size()));
    ASSERT_TRUE(png.has_value());
    ASSERT_GE(png->size(), 8);
    EXPECT_EQ(*png, job->input.crops_png.at(static_cast<std::int64_t>(png->size() - 8)));
    ++n_by_size[png->size()];
  }
  EXPECT_EQ(n_by_size.size(), kTargets);
}

TEST(ReportHtml, StatesHowMuchArrowsAreMagnified) {
  const std::string html = report_html(run(kProgram)->input);
  EXPECT_THAT(html, testing::ContainsRegex("drawn <b>[0-9,]+ times</b>"));
  EXPECT_THAT(html, testing::ContainsRegex("[0-9.]+ &#181;m residual</text>"));
  EXPECT_EQ(count(html, "<svg"), 3);
}

TEST(ReportHtml, NeedsNothingFromElsewhere) {
  const std::string html = report_html(run(kProgram)->input);
  for (const std::string& href : attributes(html, "href"))
    EXPECT_TRUE(href.starts_with('#')) << href;
  EXPECT_EQ(count(html, "http"), attributes(html, "xmlns").size());
  for (const char* forbidden : {"<script", "<link", "<iframe", "url(", "@import", "javascript:"}) {
    EXPECT_THAT(html, Not(HasSubstr(forbidden)));
  }
}

TEST(ReportHtml, NamesTheTargetThatWasNotFound) {
  const std::string html = report_html(run(kProgram, lose)->input);
  EXPECT_THAT(html, HasSubstr("HOLD"));
  EXPECT_THAT(html,
              HasSubstr("Look at G46 target #4 in line 17, board [0], nominal (95.000, 15.000)"));
  EXPECT_THAT(html, HasSubstr("no disc &lt;1 mm&gt; &amp; nothing like it"));
  EXPECT_THAT(html, HasSubstr("<article class=\"card refused\" id=\"target-4\">"));
  EXPECT_LT(html.find("id=\"target-4\""), html.find("id=\"target-0\""))
      << "refused ones come first";
}

TEST(ReportHtml, NamesTheWorstTargetOfARefusedFitAndClaimsNoMore) {
  const std::string html = report_html(run(kProgram, shear)->input);
  EXPECT_THAT(html, HasSubstr("HOLD"));
  // One spare equation cannot tell which of the three moved.
  EXPECT_THAT(html,
              testing::ContainsRegex("Look at G46 target #[345] in line 1[678], board \\[0\\]"));
  EXPECT_THAT(html, HasSubstr("with 1 equation to spare, any of the 3 targets"));
  EXPECT_THAT(html, HasSubstr("residual too large"));
  EXPECT_THAT(html, HasSubstr("one spare equation cannot say which target is off"));
}

TEST(ReportHtml, SuspectsTargetsWhenTheFitFollowsAWrongOne) {
  const std::string html = report_html(run(kProgram, turn)->input);
  EXPECT_THAT(html, HasSubstr("HOLD"));
  EXPECT_THAT(html, HasSubstr("Look at targets #3, #4, #5 (Board [0], line 16: rotation is 5."));
  EXPECT_THAT(html, HasSubstr("found, fit refused"));
}

/// It was found, so nothing else would tell it from those that the fit rests on.
TEST(ReportHtml, MarksATargetThatWasLeftOut) {
  const auto job = run(kProgram);
  ASSERT_THAT(report_html(job->input), Not(HasSubstr("left out")));
  SeriesResult& board = job->survey.series.at(1);
  ASSERT_EQ(board.points, (std::vector<std::size_t>{3, 4, 5}));
  board.points = {3, 5};
  board.dropped = {4};
  const std::string html = report_html(job->input);
  EXPECT_THAT(html, HasSubstr("<article class=\"card suspect\" id=\"target-4\">"));
  EXPECT_EQ(count(html, "<article class=\"card good\""), kTargets - 1);
  EXPECT_EQ(count(html, "<span class=\"chip suspect\">found, left out of the fit</span>"), 1);
  EXPECT_LT(html.find("id=\"target-4\""), html.find("id=\"target-0\""));
  EXPECT_THAT(html, HasSubstr("<a href=\"#target-4\" class=\"mark suspect\">"));
  EXPECT_THAT(html,
              HasSubstr("9 of 9<small>3 fits; <span class=\"chip suspect\">1 left out of its "
                        "fit</span></small>"));
  EXPECT_THAT(html, HasSubstr("One target was left out of its fit."));
  EXPECT_EQ(markup_problem(html), "");
}

TEST(ReportHtml, SaysForcedWhenWrittenAllTheSame) {
  const std::string html = report_html(run(kProgram, shear, true)->input);
  EXPECT_THAT(html, HasSubstr("FORCED"));
  EXPECT_THAT(html, HasSubstr("Before drilling: Look at"));
}

TEST(ReportHtml, ShowsAProgramWithoutTargets) {
  const std::string html = report_html(
      run("M48\nMETRIC,TZ\nFMAT,2\nT1C0.8\n%\nG90\nT1\nX10.0Y10.0\nX20.0Y10.0\nM30\n")->input);
  EXPECT_THAT(html, HasSubstr("DRILL"));
  EXPECT_THAT(html, HasSubstr("The program has no targets"));
  EXPECT_EQ(markup_problem(html), "");
}

TEST(ReportHtml, ShowsAnEmptyInput) {
  const std::string html = report_html({});
  EXPECT_THAT(html, HasSubstr("HOLD"));
  EXPECT_EQ(markup_problem(html), "");
}

TEST(ReportHtml, IsWellFormedWhateverHappened) {
  EXPECT_EQ(markup_problem(report_html(run(kProgram)->input)), "");
  EXPECT_EQ(markup_problem(report_html(run(kProgram, lose)->input)), "");
  EXPECT_EQ(markup_problem(report_html(run(kProgram, shear)->input)), "");
  EXPECT_EQ(markup_problem(report_html(run(kProgram, shear, true)->input)), "");
}

/// A camera's wrong scale moves holes without any target that is off.
TEST(ReportHtml, NamesACommonScaleInTheVerdict) {
  const auto job = run(kProgram);
  const std::string words = "all 21 targets measure 2.0 % larger than stated";
  EXPECT_THAT(report_html(job->input), Not(HasSubstr(words)));
  job->input.common_scale = words;
  const std::string html = report_html(job->input);
  EXPECT_LT(html.find("But " + words + "."), html.find("<h2"));
  EXPECT_EQ(markup_problem(html), "");
}

TEST(ReportHtml, NamesGatesThatAreOff) {
  const auto job = run(kProgram);
  EXPECT_THAT(report_html(job->input),
              HasSubstr("Gates off: false alarm, false alarm of nested fits."));
  for (SeriesResult& series : job->survey.series) series.limits.false_alarm = 1e-3;
  const std::string html = report_html(job->input);
  EXPECT_THAT(html, Not(HasSubstr("Gates off")));
  EXPECT_THAT(html,
              HasSubstr("Gates: residual 25 um, rotation 5 mrad, stretch 500 ppm, offset 2 mm, "
                        "false alarm 0.001, no mirror."));
}

TEST(ReportHtml, EscapesHostileTexts) {
  const std::string hostile = "\"><script>alert('x')</script>&\xff\x01\n";
  const auto job = run(kProgram, [&](Measurement& m) {
    m.image = hostile;
    m.reason = hostile;
    if (m.request.seq == 4) m.status = MeasurementStatus::Rejected;
  });
  ReportInput& input = job->input;
  input.program_file = input.machine_name = input.source = hostile;
  input.provenance.emplace_back(hostile, hostile);
  const std::vector<Diagnostic> diagnostics = {
      {Code::FileUnreadable, {hostile, 1, 2}, hostile, hostile}};
  input.diagnostics = diagnostics;
  const std::string html = report_html(input);
  EXPECT_EQ(markup_problem(html), "");
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;&amp;\\xff\\x01 "));
  input.output_file = hostile;
  EXPECT_EQ(markup_problem(report_html(input)), "");
}

TEST(ReportHtml, SurvivesNumbersThatAreNone) {
  const auto job = run(kProgram);
  for (const double bad : {std::nan(""), HUGE_VAL, 1e300}) {
    job->survey.measurements[0].request.nominal = position_mm<frame::Nominal>(bad, -bad);
    job->survey.measurements[1].measured.position = position_mm<frame::Actual>(bad, bad);
    job->survey.series[0].gates[0].value = bad;
    EXPECT_EQ(markup_problem(report_html(job->input)), "") << bad;
  }
}

TEST(ReportHtml, StaysSmallForManyHoles) {
  std::string text = "M48\nMETRIC,TZ\nFMAT,2\nT1C0.3\n%\nG90\nT1\n";
  Random random(5);
  for (std::size_t i = 0; i < Tally::kSample; ++i) {
    text += "X" + report::fixed(random.uniform(10, 590), 3) + "Y" +
            report::fixed(random.uniform(10, 390), 3) + "\n";
  }
  const auto job = run(text + "M30\n");
  ASSERT_EQ(job->tally.sample().size(), Tally::kSample);
  EXPECT_LT(report_html(job->input).size(), 400'000U);
}

}  // namespace
}  // namespace panelcal
