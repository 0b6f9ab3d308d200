// SPDX-License-Identifier: Apache-2.0
#include "tools/report/html.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/random.h"
#include "program/walk/walk.h"
#include "tools/figures/text.h"
#include "tools/report/fit_numbers.h"
#include "tools/report/surface.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Three panel targets; 2 x 1 boards with three targets and two holes each.
constexpr const char* kProgram =
    "M48\nMETRIC,TZ\nFMAT,2\nT1C0.700\nT2C1.500\n%\nG05\nG90\nG34,1\n"
    "G36X6.0Y6.0\nG36X224.0Y6.0\nG36X6.0Y269.0\nG34,2\nM50,1\nM25\n"
    "G46X15.0Y15.0\nG46X95.0Y15.0\nG46X95.0Y80.0\nM01\nR1M02X105.0\nM08\n"
    "T1\nM51,1\nM25\nM52,3\nX20.0Y20.0\nX40.0Y60.0\nM01\nR1M02X105.0\nM08\nT2\nX100.0Y200.0\nM30\n";
constexpr int kTargets = 9;
constexpr int kHoles = 5;
constexpr double kSigma_mm = 0.001;

/// Sees every target through a known map; `change` may shear an answer.
class FakeCamera final : public MeasurementSource {
 public:
  using Change = std::function<void(Measurement&)>;
  FakeCamera(const Transform<frame::Actual, frame::Nominal>& panel, Change change)
      : panel_(panel), change_(std::move(change)) {}

  Expected<Measurement> measure(const MeasurementRequest& request) override {
    Measurement m;
    m.request = request;
    m.status = MeasurementStatus::Found;
    const Eigen::Vector2d noise_mm(kSigma_mm * random_.normal(), kSigma_mm * random_.normal());
    m.measured = {panel_(request.nominal) + displacement_mm<frame::Actual>(noise_mm),
                  kSigma_mm * kSigma_mm * Eigen::Matrix2d::Identity()};
    m.score = 0.98;
    m.image = "image_" + std::to_string(request.seq) + ".png";
    if (change_) change_(m);
    return m;
  }

 private:
  Transform<frame::Actual, frame::Nominal> panel_;
  Change change_;
  Random random_{1};
};

/// Everything a report points to.
struct Job {
  DiagnosticLog log;
  Truth truth;
  std::optional<TruthComparison> comparison;
  Survey survey;
  Tally tally;
  std::optional<JobVerdict> verdict;
  ReportInput input;
};

Truth known_truth() {
  Eigen::Matrix2d linear;
  linear << 1.0002, -0.002, 0.002, 0.9999;
  Truth truth;
  truth.panel = {linear, Eigen::Vector2d(0.4, -0.3)};
  return truth;
}

/// Surveys and, where allowed, executes `text`, as `panelcal run` does.
std::unique_ptr<Job> run(const std::string& text,
                         FakeCamera::Change change = {},
                         bool force = false,
                         const Tolerances& tolerances = {}) {
  auto job = std::make_unique<Job>();
  job->truth = known_truth();
  job->comparison.emplace(job->truth);
  WalkOptions options;
  options.base_limits = {um(25), rad(5e-3), 500.0, mm(2)};
  options.nested_limits = {um(25), rad(2e-3), 5000.0, mm(2)};
  options.tolerances = tolerances;
  const Program program = load_program({"panel.exc", text}, job->log);
  FakeCamera camera(job->truth.panel, std::move(change));
  job->survey = survey(program, options, camera, job->log);
  ReportInput& input = job->input;
  input.program_file = "panel.exc";
  input.machine_name = "drill 1";
  input.source = "a fake camera";
  input.survey = &job->survey;
  input.forced = force && job->log.has_errors();
  if (job->survey.is_complete() && (force || !job->log.has_errors())) {
    job->verdict.emplace(tolerances);
    Tee tee({&job->tally, &*job->comparison, &*job->verdict});
    execute(program, options, job->survey, tee, job->log);
    input.tally = &job->tally;
    input.truth = &*job->comparison;
    input.output_file = "corrected.drl";
    if (tolerances.asks_positions()) input.verdict = &*job->verdict;
  }
  for (const Measurement& m : job->survey.measurements) {
    input.crops_png[m.request.seq] = std::string("\x89PNG\r\n\x1a\n", 8) +
                                     std::string(static_cast<std::size_t>(m.request.seq), '\0');
  }
  input.diagnostics = job->log.kept();
  input.provenance = {{"made by", "panelcal test"}};
  return job;
}

/// One corner of a board moved so that the board would be sheared, which no stretch follows.
void shear(Measurement& m) {
  if (m.request.seq != 4) return;
  m.measured.position = m.measured.position + displacement_mm<frame::Actual>(0.3, -0.3);
}

/// One corner moved so that the board would be turned: hardly a residual is left.
void turn(Measurement& m) {
  if (m.request.seq != 4) return;
  m.measured.position = m.measured.position + displacement_mm<frame::Actual>(0.325, 0.4);
}

void lose(Measurement& m) {
  if (m.request.seq != 4) return;
  m.status = MeasurementStatus::NotFound;
  m.reason = "no disc <1 mm> & nothing like it";
}

std::size_t count(std::string_view text, std::string_view what) {
  std::size_t n = 0;
  for (auto at = text.find(what); at != std::string_view::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

/// The values of all attributes `name`.
std::vector<std::string> attributes(std::string_view html, const std::string& name) {
  std::vector<std::string> values;
  const std::string begin = " " + name + "=\"";
  for (auto at = html.find(begin); at != std::string_view::npos; at = html.find(begin, at + 1)) {
    const auto first = at + begin.size();
    values.emplace_back(html.substr(first, html.find('"', first) - first));
  }
  return values;
}

std::optional<std::string> decoded_base64(std::string_view text) {
  constexpr std::string_view kAlphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  if (text.size() % 4 != 0) return std::nullopt;
  std::size_t n_padding = 0;
  while (n_padding < 2 && text.ends_with('=')) {
    text.remove_suffix(1);
    ++n_padding;
  }
  std::string bytes;
  std::uint32_t bits = 0;
  int n_bits = 0;
  for (const char c : text) {
    const auto value = kAlphabet.find(c);
    if (value == std::string_view::npos) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    n_bits += 6;
    if (n_bits >= 8) {
      n_bits -= 8;
      bytes += static_cast<char>(bits >> n_bits & 0xffU);
    }
  }
  return bytes;
}

/// Empty if all that follows the tag's name is name="value".
std::string attribute_problem(std::string_view tag) {
  auto at = tag.find_first_of(" \n");
  while (at != std::string_view::npos) {
    const auto first = tag.find_first_not_of(" \n", at);
    if (first == std::string_view::npos || tag.substr(first) == "/") return "";
    const auto equals = tag.find_first_not_of("abcdefghijklmnopqrstuvwxyzB-", first);
    if (equals == std::string_view::npos || tag.substr(equals, 2) != "=\"") break;
    const auto end = tag.find('"', equals + 2);
    if (end == std::string_view::npos) break;
    at = end + 1;
    if (at == tag.size()) return "";
    if (tag[at] != ' ' && tag[at] != '\n' && tag[at] != '/') break;
    if (tag[at] == '/') return at + 1 == tag.size() ? "" : "stray /";
  }
  return at == std::string_view::npos ? "" : "bad attributes: " + std::string(tag.substr(0, 60));
}

/// Empty if every tag is closed in order, every attribute quoted and every & an entity; else what
/// is wrong.
std::string markup_problem(std::string_view html) {
  std::vector<std::string> open;
  for (auto at = html.find('&'); at != std::string_view::npos; at = html.find('&', at + 1)) {
    const auto end = html.find_first_not_of("#abcdefghijklmnopqrstuvwxyz0123456789", at + 1);
    if (end == std::string_view::npos || html[end] != ';') {
      return "stray & in " + std::string(html.substr(at, 20));
    }
  }
  for (auto at = html.find('<'); at != std::string_view::npos; at = html.find('<', at + 1)) {
    const auto end = html.find('>', at);
    if (end == std::string_view::npos) return "unclosed <";
    std::string_view tag = html.substr(at + 1, end - at - 1);
    if (tag.starts_with('!')) continue;
    if (tag.find('<') != std::string_view::npos) return "< in tag " + std::string(tag);
    if (const std::string problem = attribute_problem(tag); !problem.empty()) return problem;
    const bool is_end = tag.starts_with('/');
    if (is_end) tag.remove_prefix(1);
    const std::string name(tag.substr(0, tag.find_first_of(" \n/")));
    if (tag.ends_with('/')) continue;
    if (!is_end) {
      open.push_back(name);
    } else if (open.empty() || open.back() != name) {
      return "</" + name + "> closes " + (open.empty() ? "nothing" : open.back());
    } else {
      open.pop_back();
    }
  }
  return open.empty() ? "" : "never closed: " + open.back();
}

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
  // Which of the three moved cannot be told from one spare equation.
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

/// One place, likely to break its tolerance but less than certain to.
Tolerances warning() {
  Tolerances tolerances;
  tolerances.tools.push_back({.number = 2, .position = um(1)});
  tolerances.hold_above = 1;
  return tolerances;
}

/// The predicted sigmas are a few micrometres.
TEST(ReportHtml, ShowsHowSureTheToleranceIs) {
  Tolerances tolerances;
  tolerances.position = um(1000);
  const auto sure = run(kProgram, {}, false, tolerances);
  const std::string html = report_html(sure->input);
  EXPECT_THAT(html, HasSubstr("<h2 id=\"tolerance\">Tolerance</h2>"));
  EXPECT_LT(html.find("id=\"tolerance\""), html.find("<h2>Panel</h2>"));
  EXPECT_THAT(html, HasSubstr("Drill: no place is more likely than 0.0001"));
  EXPECT_THAT(html, HasSubstr("of 5; <a href=\"#tolerance\">"));
  EXPECT_THAT(html, Not(HasSubstr("WARNING")));
  EXPECT_EQ(markup_problem(html), "");

  const auto unsure = run(kProgram, {}, false, warning());
  EXPECT_EQ(unsure->verdict->decision(), JobDecision::DrillWithWarning);
  const std::string warned = report_html(unsure->input);
  EXPECT_THAT(warned, HasSubstr("DRILL, WITH A WARNING"));
  EXPECT_THAT(warned, HasSubstr("run --explain L"));
  EXPECT_EQ(markup_problem(warned), "");

  EXPECT_THAT(report_html(run(kProgram)->input), Not(HasSubstr("id=\"tolerance\"")));
}

/// One hole without a correction, one with a tool of no tolerance, and no gates at all.
TEST(ReportHtml, ClaimsNoMoreThanWasJudged) {
  Tolerances tolerances;
  tolerances.position = um(1000);
  const auto all = run(kProgram, {}, false, tolerances);
  EXPECT_THAT(report_html(all->input),
              HasSubstr("Every target was found, every fit is inside its limits, and all 5 places "
                        "are as sure to keep the tolerance as the machine&#39;s file asks."));

  Tolerances only_first;
  only_first.tools.push_back({.number = 1, .position = um(1000)});
  const auto part = run(kProgram, {}, false, only_first);
  EXPECT_THAT(report_html(part->input),
              HasSubstr("and 4 of 5 places (not judged: 1 without a tolerance) are as sure"));
  Drill uncorrected;
  uncorrected.tool = 2;
  part->verdict->put({40, {}, uncorrected, {}, nullptr});
  for (SeriesResult& series : part->survey.series) series.gates.clear();
  EXPECT_THAT(report_html(part->input),
              HasSubstr("Every target was found, no fit was held against any limit, since "
                        "machine.toml turns them off, and 4 of 6 places (not judged: 1 without a "
                        "correction and 1 without a tolerance) are as sure"));

  const auto warned = run(kProgram, {}, false, warning());
  for (SeriesResult& series : warned->survey.series) series.gates.clear();
  const std::string html = report_html(warned->input);
  EXPECT_THAT(html, HasSubstr("DRILL, WITH A WARNING"));
  EXPECT_THAT(html,
              HasSubstr("Every target was found, and no fit was held against any limit, since "
                        "machine.toml turns them off; but the tolerance is not as sure"));
  EXPECT_THAT(html, Not(testing::ContainsRegex("fits? (are|is) inside")));
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

/// --explain takes lines of the program alone.
TEST(ReportHtml, NamesThePlaceToExplainSoThatItIsFound) {
  const auto job = run(kProgram, {}, false, warning());
  ASSERT_EQ(job->verdict->decision(), JobDecision::DrillWithWarning);
  const int line = job->verdict->worst_tool()->worst.line;
  EXPECT_THAT(report_html(job->input), HasSubstr("run --explain L" + std::to_string(line) + " ("));
  job->input.worst_number = 500;
  EXPECT_THAT(report_html(job->input), HasSubstr("run --explain 500 ("));
  job->input.worst_number.reset();
  Drill worst;
  worst.cov_mm2 = Eigen::Matrix2d::Identity();
  worst.tool = 2;
  worst.risk = worst.judged_risk = 0.999;
  JobVerdict of_a_pattern(warning());
  of_a_pattern.put({3, {}, worst, "PINS", nullptr});
  job->input.verdict = &of_a_pattern;
  const std::string html = report_html(job->input);
  EXPECT_THAT(html,
              HasSubstr("see what the worst place&#39;s error is made of, below (drill, with"));
  EXPECT_THAT(html, Not(HasSubstr("run --explain")));
}

/// 9.96 is 10.0 in two digits, which is 1.0 of the next power.
TEST(ReportHtml, RoundsARiskBeforeItSplitsIt) {
  const auto job = run(kProgram);
  Tolerances tolerances;
  tolerances.position = um(10);
  for (const auto& [risk, text] : {std::pair(9.96e-5, "1.0 &#215; 10<sup>-4</sup>"),
                                   std::pair(6.34e-5, "6.3 &#215; 10<sup>-5</sup>")}) {
    JobVerdict verdict(tolerances);
    Drill drill;
    drill.tool = 1;
    drill.cov_mm2 = Eigen::Matrix2d::Identity();
    drill.risk = drill.judged_risk = risk;
    verdict.put({3, {}, drill, {}, nullptr});
    job->input.verdict = &verdict;
    EXPECT_THAT(report_html(job->input), HasSubstr(text));
  }
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

TEST(ReportText, KeepsUtf8AndShowsWhatIsNone) {
  EXPECT_EQ(report::escaped("Pr\xc3\xbc"
                            "fung"),
            "Pr\xc3\xbc"
            "fung");
  EXPECT_EQ(report::escaped("\xc3"), "\\xc3");
  EXPECT_EQ(report::escaped("\xc0\xaf"), "\\xc0\\xaf") << "overlong";
  EXPECT_EQ(report::escaped("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "surrogate";
  EXPECT_EQ(report::escaped("\xe2\x80\xae"), "\\xe2\\x80\\xae") << "right-to-left override";
}

TEST(ReportText, EncodesBase64AsInRfc4648) {
  EXPECT_EQ(report::base64(""), "");
  EXPECT_EQ(report::base64("f"), "Zg==");
  EXPECT_EQ(report::base64("fo"), "Zm8=");
  EXPECT_EQ(report::base64("foo"), "Zm9v");
  EXPECT_EQ(report::base64("foobar"), "Zm9vYmFy");
}

TEST(ReportText, WritesNumbersAsPeopleReadThem) {
  EXPECT_EQ(report::grouped(-1234567), "-1,234,567");
  EXPECT_EQ(report::grouped(999), "999");
  EXPECT_EQ(report::shortest(0.5), "0.5");
  EXPECT_EQ(report::shortest(20000), "20,000");
  EXPECT_EQ(report::fixed(-0.0004, 3), "0.000");
  EXPECT_EQ(report::fixed_signed(0.25, 2), "+0.25");
  EXPECT_EQ(report::with_sigma(201.2, 0.92, "ppm"), "+201.20 &#177; 0.92 ppm");
}

TEST(ReportFitNumbers, KnowsChiSquareTables) {
  // Abramowitz and Stegun, table 26.8, to its six figures.
  EXPECT_NEAR(report::chi_square_exceedance(3.84146, 1), 0.05, 1e-6);
  EXPECT_NEAR(report::chi_square_exceedance(5.99146, 2), 0.05, 1e-6);
  EXPECT_NEAR(report::chi_square_exceedance(11.0705, 5), 0.05, 1e-5);
  EXPECT_NEAR(report::chi_square_exceedance(124.342, 100), 0.05, 1e-5);
  EXPECT_EQ(report::chi_square_exceedance(0, 3), 1);
  EXPECT_EQ(report::chi_square_exceedance(1e6, 3), 0);
}

/// Draws many fits of one model and holds the scatter of each number against its sigma.
TEST(ReportFitNumbers, PredictsTheScatterOfEveryNumber) {
  constexpr int kDraws = 1000;
  // Standard deviation of a sample's standard deviation is 1 / sqrt(2 N); four of them.
  const double tolerance = 4 / std::sqrt(2.0 * kDraws);
  Eigen::Matrix2d linear;
  linear << 0.8, -0.5, 0.7, 0.9;  // far from the identity, so that every derivative matters
  const Transform<frame::Base, frame::Nominal> truth(linear, Eigen::Vector2d(10, -20));
  Eigen::Matrix2d cov_mm2;
  cov_mm2 << 4e-6, 1.5e-6, 1.5e-6, 1e-6;
  const Eigen::Matrix2d root =
      (Eigen::Matrix2d() << 2e-3, 0, 0.75e-3, std::sqrt(0.4375e-6)).finished();
  Random random(11);
  std::array<double, 6> sum{}, squares{}, sigma{};
  for (int i = 0; i < kDraws; ++i) {
    std::vector<TargetPair<frame::Base, frame::Nominal>> pairs;
    for (const Eigen::Vector2d& p_mm : {Eigen::Vector2d(5, 5),
                                        Eigen::Vector2d(205, 15),
                                        Eigen::Vector2d(0, 150),
                                        Eigen::Vector2d(180, 190)}) {
      const Eigen::Vector2d noise_mm = root * Eigen::Vector2d(random.normal(), random.normal());
      const auto nominal = position_mm<frame::Nominal>(p_mm);
      pairs.push_back(
          {nominal, {truth(nominal) + displacement_mm<frame::Base>(noise_mm), cov_mm2}});
    }
    auto fit = fit_panel<frame::Base, frame::Nominal>(pairs, PanelModel::Affine).fit;
    ASSERT_TRUE(fit.has_value());
    SeriesResult series;
    series.base = std::make_shared<const BaseFit>(*std::move(fit));
    const report::FitNumbers n = *report::fit_numbers(series);
    const std::array<report::Uncertain, 6> all = {
        n.rotation_rad, n.stretch_x_ppm, n.stretch_y_ppm, n.shear_ppm, n.shift_x_mm, n.shift_y_mm};
    for (std::size_t k = 0; k < all.size(); ++k) {
      sum[k] += all[k].value;
      squares[k] += all[k].value * all[k].value;
      sigma[k] = all[k].sigma;
    }
  }
  for (std::size_t k = 0; k < sum.size(); ++k) {
    const double mean = sum[k] / kDraws;
    const double scatter = std::sqrt(std::max(0.0, squares[k] / kDraws - mean * mean));
    EXPECT_NEAR(scatter / sigma[k], 1, tolerance) << "number " << k;
  }
}

TEST(ReportHtml, ShowsEveryProbedSurface) {
  Survey survey;
  ProbeRequest request;
  request.seq = 3;
  request.line = 12;
  request.command = "G73";
  request.nominal = position_mm<frame::Nominal>(20, 30);
  request.memory = 7;
  request.reference = mm(1.6);
  survey.probes.push_back(
      {request, ProbeStatus::Found, {{mm(1.6125), um(2)}, {mm(1.5), um(2)}}, ""});
  request.seq = 4;
  request.memory.reset();
  survey.probes.push_back({request, ProbeStatus::NotFound, {}, "no <contact>"});
  const std::string html = report::surface_section(survey, "");
  EXPECT_THAT(html,
              HasSubstr("<tr><td>#3</td><td>G73 in line 12</td><td>L7</td><td class=\"num\">"
                        "(20.000, 30.000)</td><td class=\"num\">1.6125</td><td class=\"num\">"
                        "1.5000</td><td class=\"num\">+12.5</td></tr>"));
  EXPECT_THAT(html, HasSubstr("<td colspan=\"3\"><b>not found</b> no &lt;contact&gt;</td></tr>"));
  EXPECT_EQ(report::surface_section(Survey(), ""), "");
  EXPECT_THAT(report::surface_section(Survey(), "2 depths count from the map"),
              HasSubstr("<p>2 depths count from the map.</p>"));
}

}  // namespace
}  // namespace panelcal
