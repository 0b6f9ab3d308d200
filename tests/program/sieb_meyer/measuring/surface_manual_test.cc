// SPDX-License-Identifier: Apache-2.0
// SIEB & MEYER manual, chapters 10 (Surface Detection), 11 (Depth Control) and 8.2 (Set Drill
// Stroke).
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "program/walk/probing.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::ended;
using test::expect_places;
using test::IsNearMatrix;
using test::Places;
using test::ProgramRun;
using test::run_program;
using test::steps_of;
using testing::Contains;
using testing::ElementsAre;

using Lines = std::vector<std::string>;

/// Answers with a height that depends on the request, and remembers what was asked.
class HeightSource final : public ProbeSource {
 public:
  using Height = std::function<double(const ProbeRequest&)>;
  explicit HeightSource(Height height_mm) : height_mm_(std::move(height_mm)) {}

  Expected<ProbeReading> probe(const ProbeRequest& request) override {
    requests_.push_back(request);
    ProbeReading reading;
    reading.request = request;
    reading.status = ProbeStatus::Found;
    reading.heights = {{mm(height_mm_(request)), um(1)}};
    return reading;
  }

  const std::vector<ProbeRequest>& requests() const { return requests_; }

 private:
  Height height_mm_;
  std::vector<ProbeRequest> requests_;
};

/// Heights in the order of probing.
HeightSource heights_in_order(std::vector<double> heights_mm) {
  return HeightSource([heights_mm](const ProbeRequest& request) {
    return heights_mm.at(static_cast<std::size_t>(request.seq));
  });
}

ProgramRun run_probing(const std::string& text,
                       ProbeSource& probes,
                       const WalkOptions& options = {}) {
  DiagnosticLog log;
  ProgramRun run;
  run.program = load_program({"p.exc", text}, log);
  NominalSource source;
  run.survey = survey(run.program, options, source, probes, log);
  run.has_errors = log.has_errors();
  if (!run.has_errors) execute(run.program, options, run.survey, run.executed, log);
  run.has_errors = log.has_errors();
  run.diagnostics = test::briefs(log);
  for (const Diagnostic& diagnostic : log.kept()) run.texts.push_back(diagnostic.text());
  return run;
}

void expect_clean(const ProgramRun& run) {
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
}

/// Work of tools, with line numbers: no settings and no functions.
Lines work_of(const ProgramRun& run) {
  Lines work;
  for (const std::string& line : run.executed.lines()) {
    const std::string_view step = std::string_view(line).substr(line.find(' ') + 1);
    if (!step.starts_with("function") && !step.starts_with("setting")) work.push_back(line);
  }
  return work;
}

Places probed_places(const HeightSource& probes) {
  Places places;
  for (const ProbeRequest& request : probes.requests()) {
    places.push_back(request.nominal.in_mm());
  }
  return places;
}

constexpr char kEmptyTools[] = "$\nT1DS\nT2DS\n$\n";

// --- chapter 10.1, SLM ---------------------------------------------------------------------------

/// The example "Measurement" of G70, G71, G73 and L.
std::string measurement_example() {
  return "%%5000\n(MEASURING)\nG71\nX165.Y15.G73L1\nG75\nX110.Y10.G73L2\nG75\n(PRODUCTION)\nG71K."
         "4\n"
         "L1\nX165.Y15.T1\nX170.Y15.\nG71K.5\nL2\nX110.Y10.T0T5\nX110.Y30.G1F1.5\nX110.Y30."
         "T0\nG70\n"
         "XY\n" +
         std::string(kEmptyTools);
}

TEST(ManualSlm, DrillsAndRoutsBelowTheirReferenceSurfaces) {
  HeightSource probes = heights_in_order({1.62, 1.48});
  const ProgramRun run = run_probing(measurement_example(), probes);
  expect_clean(run);
  EXPECT_THAT(work_of(run),
              ElementsAre("11 tool 1",
                          "11 drill 1 (165, 15) depth 0.4 surface 1.62",
                          "12 drill 1 (170, 15) depth 0.4 surface 1.62",
                          "15 tool 5",
                          "15 position (110, 10)",
                          "16 plunge depth 0.5 surface 1.48",
                          "16 rout 5 line (110, 30) depth 0.5 surface 1.48",
                          "17 retract",
                          "19 drill 5 (0, 0)"));
}

TEST(ManualSlm, ProbesAtTheProgrammedPlaces) {
  HeightSource probes = heights_in_order({1.62, 1.48});
  const ProgramRun run = run_probing(measurement_example(), probes);
  expect_places(probed_places(probes), {{165, 15}, {110, 10}});
  for (std::size_t i = 0; i < 2; ++i) {
    const ProbeRequest& request = probes.requests()[i];
    EXPECT_EQ(request.seq, static_cast<std::int64_t>(i));
    EXPECT_EQ(request.command, "G73");
    EXPECT_EQ(request.line, i == 0 ? 4 : 6);
    EXPECT_EQ(request.memory, i == 0 ? 1 : 2);
  }
  EXPECT_EQ(run.survey.probes.size(), 2U);
}

TEST(ManualSlm, RetractsTheProbeWhereG75Stands) {
  HeightSource probes = heights_in_order({1.62, 1.48});
  EXPECT_EQ(run_probing(measurement_example(), probes).executed.lines().front(),
            "5 function retract_probe G75");
}

/// The example of G75; the coordinates of its second and third depth hole are lost.
TEST(ManualSlm, ThreeScansAndThreeDepthHoles) {
  HeightSource probes = heights_in_order({1.51, 1.52, 1.53});
  const ProgramRun run = run_probing(
      ended("%%5000\n(MEASURING)\nG71\nX10.Y120.G73L1\nX20.Y120.G73L2\nX30.Y120.G73L3\nG75\n"
            "(PRODUCTION)\nG71K.2\nL1\nX12.Y120.T8\nL2\nX22.Y120.\nL3\nX32.Y120.\nG70\n"),
      probes);
  expect_clean(run);
  EXPECT_THAT(work_of(run),
              ElementsAre("11 tool 8",
                          "11 drill 8 (12, 120) depth 0.2 surface 1.51",
                          "13 drill 8 (22, 120) depth 0.2 surface 1.52",
                          "15 drill 8 (32, 120) depth 0.2 surface 1.53"));
}

/// "If the working plane is above the reference surface, the programmed value must be negative."
TEST(ManualSlm, ANegativePlaneLeavesAResidualWeb) {
  HeightSource probes = heights_in_order({1.5});
  const ProgramRun run =
      run_probing(ended("%%5000\nG71\nX1.Y1.G73L1\nG71K-2.0\nL1\nX2.Y2.T1\nG70\n"), probes);
  expect_clean(run);
  EXPECT_THAT(run.executed.lines(), Contains("6 drill 1 (2, 2) depth -2 surface 1.5"));
}

/// G70: "All settings are kept. The G71 command activates the function again. The original settings
/// will be used."
TEST(ManualSlm, G70KeepsItsSettings) {
  HeightSource probes = heights_in_order({1.5});
  const ProgramRun run = run_probing(
      ended("%%5000\nG71K.3\nX1.Y1.G73L1\nL1\nX2.Y2.T1\nG70\nX3.Y3.\nG71\nL1\nX4.Y4.\nG70\n"),
      probes);
  expect_clean(run);
  EXPECT_THAT(work_of(run),
              ElementsAre("5 tool 1",
                          "5 drill 1 (2, 2) depth 0.3 surface 1.5",
                          "7 drill 1 (3, 3)",
                          "10 drill 1 (4, 4) depth 0.3 surface 1.5"));
}

/// "Only the surface value ahead the T0 block is considered for a complete routing contour."
TEST(ManualSlm, AContourHasOneReferenceSurface) {
  HeightSource probes = heights_in_order({1.5, 1.7});
  const ProgramRun run = run_probing(
      ended("%%5000\nG71K.3\nX1.Y1.G73L1\nX9.Y9.G73L2\nL1\nX10.Y10.T5T0\nX20.Y10.G1F1.\nX20.Y20.\n"
            "X20.Y20.T0\nL2\nX30.Y30.T0\nX40.Y30.G1\nX40.Y30.T0\nG70\n"),
      probes);
  expect_clean(run);
  EXPECT_THAT(work_of(run), Contains("8 rout 5 line (20, 20) depth 0.3 surface 1.5"));
  EXPECT_THAT(work_of(run), Contains("12 rout 5 line (40, 30) depth 0.3 surface 1.7"));
}

/// "If surface detection is programmed with Step-and-Repeat, it has to be activated and
/// deactivated."
TEST(ManualSlm, EveryPatternIsProbedByItself) {
  HeightSource probes = heights_in_order({1.5, 1.7});
  const ProgramRun run = run_probing(
      ended("%%5000\nM31\nG71K.3\nX1.Y1.G73L1\nL1\nX2.Y2.T1\nG70\nXYM50\nX100.YM50M30\n"), probes);
  expect_clean(run);
  expect_places(probed_places(probes), {{1, 1}, {101, 1}});
  EXPECT_EQ(probes.requests()[1].path, InstancePath{1});
  EXPECT_THAT(run.executed.lines(), Contains("6 drill 1 (2, 2) depth 0.3 surface 1.5 [0]"));
  EXPECT_THAT(run.executed.lines(), Contains("6 drill 1 (102, 2) depth 0.3 surface 1.7 [1]"));
}

// --- chapter 10.1, G74 ---------------------------------------------------------------------------

// In these listings `G71Z.4` and `G71Z.5` are slips for G71K.4 and G71K.5, which the text beside
// them describes. Their L2 at the end belongs to lines that are left out: nothing was stored there.
TEST(ManualG74, ItsSlipsAreRefused) {
  const auto refuses = [](const std::string& production, int line, const std::string& expected) {
    HeightSource probes = heights_in_order({1.4});
    test::expect_refused(
        run_probing(ended("%%5000\nG71\nX130.Y120.G73\nG74L1\nL1\n" + production), probes),
        line,
        {expected});
  };
  refuses("G71Z.4\nX165.Y15.T1\nG70\n", 6, "G71K#");
  refuses("G71K.4\nX165.Y15.T1\nL2\nG70\n", 8, "L2 takes a value that was never stored");
}

constexpr char kProduction[] =
    "(PRODUCTION)\nL1\nG71K.4\nX165.Y15.T1\nX170.Y15.\nG71K.5\nX125.Y125.T0T5\n"
    "X135.Y135.G1F1.5\nX135.Y135.T0\nG70\nXY\n";

std::string averaging(const std::string& first_log,
                      const std::string& second_log,
                      const std::string& third_log,
                      const std::string& fourth_log) {
  return "%%5000\n(MEASURING)\nG71\nX130.Y120.G73\n" + first_log + "X140.Y130.G73\n" + second_log +
         "X120.Y120.G73\n" + third_log + "X130.Y130.G73\n" + fourth_log + "G74L1\n";
}

std::string averaging_example() {
  return averaging("", "", "", "") + kProduction + kEmptyTools;
}

TEST(ManualG74, CalculatesTheAverageOfFourScans) {
  HeightSource probes = heights_in_order({1.40, 1.54, 1.50, 1.80});
  const ProgramRun run = run_probing(averaging_example(), probes);
  expect_clean(run);
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 1",
                          "drill 1 (165, 15) depth 0.4 surface 1.56",
                          "drill 1 (170, 15) depth 0.4 surface 1.56",
                          "tool 5",
                          "position (125, 125)",
                          "plunge depth 0.5 surface 1.56",
                          "rout 5 line (135, 135) depth 0.5 surface 1.56",
                          "retract",
                          "drill 5 (0, 0)"));
  expect_places(probed_places(probes), {{130, 120}, {140, 130}, {120, 120}, {130, 130}});
  for (const ProbeRequest& request : probes.requests()) EXPECT_FALSE(request.memory);
}

std::string first_hole(AverageKind kind) {
  WalkOptions options;
  options.sieb_meyer.average = kind;
  HeightSource probes = heights_in_order({1.40, 1.54, 1.50, 1.80});
  const ProgramRun run = run_probing(averaging_example(), probes, options);
  expect_clean(run);
  return run.executed.lines().size() < 2 ? "" : run.executed.lines()[1];
}

/// SPAV,A; SPAV,M: "for an even number of measured values the two values in the middle are added
/// and divided by 2"; SPAV,O: "average value of the smallest and greatest measured value"; SPAV,T:
/// "all measured values, except from the smallest and largest value".
TEST(ManualG74, CalculationMethodsOfSpav) {
  const std::string hole = "12 drill 1 (165, 15) depth 0.4 surface ";
  EXPECT_EQ(first_hole(AverageKind::Mean), hole + "1.56");
  EXPECT_EQ(first_hole(AverageKind::Median), hole + "1.52");
  EXPECT_EQ(first_hole(AverageKind::MidRange), hole + "1.6");
  EXPECT_EQ(first_hole(AverageKind::TrimmedMean), hole + "1.52");
}

/// "Then, all entries are cleared from the averaging area."
TEST(ManualG74, TheNextAverageStartsAnew) {
  HeightSource probes = heights_in_order({1.0, 2.0, 3.0, 5.0});
  const ProgramRun run =
      run_probing(ended("%%5000\nG71K.1\nX1.Y1.G73\nX2.Y1.G73\nG74L1\nX3.Y1.G73\nX4.Y1.G73\nG74L2\n"
                        "L1\nX5.Y5.T1\nL2\nX6.Y5.\nG70\n"),
                  probes);
  expect_clean(run);
  EXPECT_THAT(
      steps_of(run),
      ElementsAre(
          "tool 1", "drill 1 (5, 5) depth 0.1 surface 1.5", "drill 1 (6, 5) depth 0.1 surface 4"));
}

/// "The G73 command (with L, without coordinates) is used to additionally save the current value in
/// the surface memory"; "only the calculated average value will be used for the execution".
TEST(ManualG74, ProtocolKeepsEveryScan) {
  HeightSource probes = heights_in_order({1.40, 1.54, 1.50, 1.80});
  const ProgramRun run = run_probing(
      ended(averaging("G73L101\n", "G73L102\n", "G73L103\n", "G73L104\n") +
            "(PRODUCTION)\nL1\nG71K.4\nX165.Y15.T1\nX170.Y15.\nG71K.5\nX125.Y125.T0T5\n"
            "X135.Y135.G1F1.5\nX135.Y135.T0\nL101\nX1.Y1.\nL102\nX2.Y1.\nL103\nX3.Y1.\nL104\n"
            "X4.Y1.\nG70\n"),
      probes);
  expect_clean(run);
  EXPECT_EQ(probes.requests().size(), 4U) << "no second scan";
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 1",
                          "drill 1 (165, 15) depth 0.4 surface 1.56",
                          "drill 1 (170, 15) depth 0.4 surface 1.56",
                          "tool 5",
                          "position (125, 125)",
                          "plunge depth 0.5 surface 1.56",
                          "rout 5 line (135, 135) depth 0.5 surface 1.56",
                          "retract",
                          "drill 5 (1, 1) depth 0.5 surface 1.4",
                          "drill 5 (2, 1) depth 0.5 surface 1.54",
                          "drill 5 (3, 1) depth 0.5 surface 1.5",
                          "drill 5 (4, 1) depth 0.5 surface 1.8"));
}

// --- chapter 10.2, the grid ----------------------------------------------------------------------

/// "10 positions into X-direction and 12 positions into Y-direction. The XY-distance is 10.0 mm.
/// The reference position is at the position X10.Y5." XY is program zero.
constexpr char kGrid[] =
    "%%5000\nM49,MAPT1.0\nX10.Y5.T1G78\nXYG79M31M31\nXYM50V2\nX90.YM50W10M30\nXYM50V2\n"
    "XY110.M50W12M30\n";

TEST(ManualG79, ProbesTheReferenceAndOneHundredTwentyPlaces) {
  HeightSource probes([](const ProbeRequest&) { return 1.5; });
  const ProgramRun run = run_probing(ended(kGrid), probes);
  expect_clean(run);
  Places expected = {{10, 5}};
  for (int row = 0; row < 12; ++row) {
    for (int column = 0; column < 10; ++column) expected.emplace_back(10 * column, 10 * row);
  }
  expect_places(probed_places(probes), expected);
  ASSERT_EQ(probes.requests().size(), 121U);
  EXPECT_EQ(probes.requests()[0].command, "G78");
  EXPECT_EQ(probes.requests()[0].path, InstancePath{});
  EXPECT_EQ(probes.requests()[1].command, "G79");
  EXPECT_EQ(probes.requests()[1 + 4 * 10 + 7].path, (InstancePath{4, 7}));
  EXPECT_EQ(probes.requests()[1].line, 4);
  EXPECT_EQ(probes.requests()[1].tool, 1);
  EXPECT_EQ(run.survey.probes.size(), 121U);
  EXPECT_TRUE(run.holes().empty()) << "a scan drills nothing";
}

/// "The difference between the reference value and the current measurement result must not exceed
/// the admissible tolerance. Otherwise, an error message appears."
TEST(ManualG79, DeviationsAboveTheToleranceAreErrors) {
  const auto run_with = [](double deviation_mm) {
    HeightSource probes([deviation_mm](const ProbeRequest& request) {
      return request.nominal.in_mm() == Vector2d(40, 70) ? 1.5 + deviation_mm : 1.5;
    });
    return run_probing(ended(kGrid), probes);
  };
  for (const double deviation_mm : {0.99, -0.99}) expect_clean(run_with(deviation_mm));
  for (const double deviation_mm : {1.01, -1.01}) {
    test::expect_refused(run_with(deviation_mm), 4, {"MAPT", "tolerance"});
  }
}

/// Expects that the tool works this much higher at one place than at another: by its z, or by the
/// surface that it refers to while its z stays.
void expect_rise(const DepthOfCut& from, const DepthOfCut& to, double rise_mm) {
  const auto rise = [](const std::optional<Length>& low, const std::optional<Length>& high) {
    return low && high ? high->in_mm() - low->in_mm() : 0.0;
  };
  const double by_z_mm = rise(from.z, to.z);
  const bool z_stays = std::abs(by_z_mm) < 1e-9;
  EXPECT_NEAR(z_stays ? rise(from.surface, to.surface) : by_z_mm, rise_mm, 1e-6);
}

/// "The interpolated values are used automatically for the execution ... in combination with the
/// standard lowering method of the Z-axis."
TEST(ManualG79, HolesFollowTheInterpolatedSurface) {
  HeightSource probes([](const ProbeRequest& request) {
    const Vector2d& p_mm = request.nominal.in_mm();
    return 1.5 + 0.001 * p_mm.x() + 0.0005 * p_mm.y();
  });
  const ProgramRun run =
      run_probing(ended(std::string(kGrid) + "X25.Y36.T1Z1.\nX55.Y36.\nX55.Y96.\n"), probes);
  expect_clean(run);
  ASSERT_EQ(run.holes().size(), 3U);
  expect_rise(run.holes()[0].drill.cut, run.holes()[1].drill.cut, 0.03);
  expect_rise(run.holes()[1].drill.cut, run.holes()[2].drill.cut, 0.03);
}

/// "This method also allows considering modified surface values step-by-step within routing
/// contours." On this surface the height along the diagonal is a parabola of 0.64 mm.
TEST(ManualG79, ContoursFollowItInSteps) {
  HeightSource probes([](const ProbeRequest& request) {
    const Vector2d& p_mm = request.nominal.in_mm();
    return 1.5 + 1e-4 * p_mm.x() * p_mm.y();
  });
  std::string grid = kGrid;
  grid.replace(grid.find("MAPT1.0"), 7, "MAPT2.0");
  const ProgramRun run =
      run_probing(ended(grid + "X0Y0T0T5Z1.\nX80.Y80.G1F1.\nX80.Y80.T0\n"), probes);
  expect_clean(run);
  const std::vector<Rout>& routs = run.executed.routs();
  // Chords of a parabola y = 0.64 t^2 stay within 0.01 mm only if none is longer than 0.25.
  ASSERT_GE(routs.size(), 4U);
  for (const Rout& rout : routs) {
    const Vector2d& end_mm = rout.nominal.in_mm();
    EXPECT_NEAR(end_mm.x(), end_mm.y(), 1e-6);
  }
  EXPECT_THAT(routs.back().nominal.in_mm(), IsNearMatrix(Vector2d(80, 80), 1e-6));
  expect_rise(routs.front().cut,
              routs.back().cut,
              1e-4 * (80 * 80 - std::pow(routs.front().nominal.in_mm().x(), 2)));
}

// --- chapters 11 and 8.2 -------------------------------------------------------------------------

/// The example, with two holes behind it. Its line of G83 repeats X40.Y30.: the cutter only goes to
/// another depth there. Nothing moves in its first rout line either.
TEST(ManualG83, RoutsAtZThenAtADepthThenAtZAgain) {
  const ProgramRun run = run_program(
      ended("%%5000\nX20.Y30.T5T0 Z3.\nX20.Y30.G1 F1.2\nX40.Y30.\nX40.Y30.G83K2.\nX60.Y50.\n"
            "X90.Y80.T0 G82\nX95.Y80.\nX96.Y80.G83\n"));
  expect_clean(run);
  Lines steps = steps_of(run);
  std::erase(steps, "rout 5 line (20, 30) z 3");
  EXPECT_THAT(steps,
              ElementsAre("tool 5",
                          "position (20, 30)",
                          "plunge z 3",
                          "rout 5 line (40, 30) z 3",
                          "plunge depth 2",
                          "rout 5 line (60, 50) depth 2",
                          "retract",
                          "position (90, 80)",
                          "drill 5 (95, 80) z 3",
                          "drill 5 (96, 80) depth 2"));
}

/// K, H and Z: "unit in Format 3000: 0.01 mm (millimeter point allowed); unit in Format 5000: 0.001
/// mm". The traveling plane H changes no working plane.
TEST(ManualPlanes, UnitDependsOnTheFormat) {
  EXPECT_THAT(steps_of(run_program(ended("%%3000\nX1.Y1.T1Z300H2000\nX2.Y1.Z2.5\nX3.Y1.G83K40\n"))),
              ElementsAre("tool 1",
                          "setting H20.000",
                          "drill 1 (1, 1) z 3",
                          "drill 1 (2, 1) z 2.5",
                          "drill 1 (3, 1) depth 0.4"));
  EXPECT_THAT(
      steps_of(run_program(ended("%%5000\nX1.Y1.T1Z3000H20.\nX2.Y1.Z2.5\nX3.Y1.G83K400\n"))),
      ElementsAre("tool 1",
                  "setting H20.000",
                  "drill 1 (1, 1) z 3",
                  "drill 1 (2, 1) z 2.5",
                  "drill 1 (3, 1) depth 0.4"));
}

/// "Coordinate, from which the new plane is effective": a K waits for G83.
TEST(ManualPlanes, KWaitsForDepthControl) {
  EXPECT_THAT(
      steps_of(run_program(ended("%%5000\nX1.Y1.T1Z3.K.4\nX2.Y1.G83\nX3.Y1.G82Z2.\n"))),
      ElementsAre(
          "tool 1", "drill 1 (1, 1) z 3", "drill 1 (2, 1) depth 0.4", "drill 1 (3, 1) z 2"));
}

}  // namespace
}  // namespace panelcal
