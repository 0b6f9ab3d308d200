// SPDX-License-Identifier: Apache-2.0
#include "program/walk/execution/depth_follower.h"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "program/geometry/arc_path.h"
#include "program/walk/walk.h"
#include "program/writers/excellon/writer.h"
#include "program/writers/sieb_meyer/writer.h"
#include "surface/map/height_map.h"
#include "surface/map/zoned_map.h"
#include <gmock/gmock.h>

#include "tests/program/random/job_events.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using namespace test;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Hills of 0.1 mm, 60 mm from one to the next.
double height_mm(const Eigen::Vector2d& p_mm) {
  return 1.6 + 0.05 * std::sin(p_mm.x() / 10) * std::cos(p_mm.y() / 12);
}

/// Probed every 8 mm from (0, 0) to (96, 96).
std::shared_ptr<const ZonedMap> hills() {
  static const auto map = [] {
    std::vector<ProbePoint> points;
    for (int i = 0; i < 13 * 13; ++i) {
      const Eigen::Vector2d p_mm = 8.0 * Eigen::Vector2d(i % 13, i / 13);
      points.push_back(
          {position_mm<frame::Nominal>(p_mm), {mm(height_mm(p_mm)), um(1)}, "probe", {}});
    }
    HeightMapOptions options;
    options.model = SurfaceModel::MonotoneBicubic;
    return std::make_shared<const ZonedMap>(HeightMap::of_probes(points, options).value());
  }();
  return map;
}

WalkOptions on_hills(std::vector<ToolDepth> tools = {}) {
  WalkOptions options;
  options.board.map = hills();
  options.board.tools = std::move(tools);
  options.board.max_sigma = mm(1);
  return options;
}

ToolDepth depth_of(int tool, double depth_mm) {
  return {.number = tool, .drill = std::nullopt, .depth = mm(depth_mm)};
}

struct Outcome {
  std::vector<Event> events;
  std::string sieb_meyer;  ///< the same, written
  bool is_refused = false;
  std::vector<std::string> errors;
};

Outcome outcome(const std::string& text, const WalkOptions& options) {
  DiagnosticLog log;
  Outcome out;
  NominalSource panel;
  const Program program = load_program({"p", text}, log);
  const Survey found = survey(program, options, panel, log);
  StringSink bytes;
  SiebMeyerWriter writer(bytes, {.allow_losses = true, .resolution = um(0.001)});
  EventRecorder recorder(&writer);
  if (!log.has_errors()) execute(program, options, found, recorder, log);
  out.is_refused = !writer.finish() || writer.losses().has_errors();
  out.sieb_meyer = bytes.text();
  out.events = std::move(recorder.events());
  for (const Diagnostic& diagnostic : log.kept()) {
    if (diagnostic.severity() == Severity::Error) out.errors.push_back(diagnostic.text());
  }
  return out;
}

template <class What>
std::vector<What> all(const Outcome& outcome) {
  std::vector<What> found;
  for (const Event& event : outcome.events) {
    if (const auto* what = std::get_if<What>(&event.what)) found.push_back(*what);
  }
  return found;
}

double map_mm(const Position<frame::Nominal>& place) {
  return hills()->height_at(place).value().height.height.in_mm();
}

std::string excellon(const std::string& body) {
  return "M48\nMETRIC,LZ\nT1C1.\nT2C2.\n%\n" + body + "M30\n";
}

// --- holes -------------------------------------------------------------------------------------

TEST(DepthFollower, CountsAHoleFromTheMap) {
  const Outcome out = outcome(excellon("T1\nX010.Y020.\nX052.3Y033.\nT2\nX010.Y020.\n"),
                              on_hills({depth_of(1, 0.8)}));
  const auto holes = all<Drill>(out);
  ASSERT_EQ(holes.size(), 3U);
  for (const Drill& hole : {holes[0], holes[1]}) {
    EXPECT_EQ(hole.cut.depth, mm(0.8));
    ASSERT_TRUE(hole.cut.surface && hole.cut.predicted);
    EXPECT_EQ(hole.cut.surface->in_mm(), map_mm(hole.nominal));
    EXPECT_EQ(hole.cut.predicted->sigma, hills()->height_at(hole.nominal)->height.sigma);
    EXPECT_EQ(hole.cut.predicted->source, HeightSource::Measured);
  }
  EXPECT_EQ(holes[2].cut, DepthOfCut());
}

TEST(DepthFollower, CountsEveryCopyWhereItIs) {
  const Outcome out =
      outcome(excellon("T1\nM25\nX010.Y020.\nM01\nM02X020.Y010.\nM02X030.M80\nM08\n"),
              on_hills({depth_of(1, 0.8)}));
  const auto holes = all<Drill>(out);
  ASSERT_EQ(holes.size(), 3U);
  for (const Drill& hole : holes) EXPECT_EQ(hole.cut.surface->in_mm(), map_mm(hole.nominal));
  EXPECT_NE(holes[0].cut.surface, holes[2].cut.surface);
}

TEST(DepthFollower, KnowsAToolByItsDiameter) {
  const ToolDepth row{.number = std::nullopt, .drill = mm(2), .depth = mm(0.3)};
  const Outcome out = outcome(excellon("T1\nX010.Y020.\nT2\nX010.Y020.\n"), on_hills({row}));
  const auto holes = all<Drill>(out);
  ASSERT_EQ(holes.size(), 2U);
  EXPECT_FALSE(holes[0].cut.depth);
  EXPECT_EQ(holes[1].cut.depth, mm(0.3));
}

TEST(DepthFollower, DrillsSlotsHoleByHole) {
  WalkOptions options = on_hills({depth_of(1, 0.8)});
  options.slots = Cycles::Kept;
  const Outcome out = outcome(excellon("T1\nX010.Y020.G85X030.Y020.\n"), options);
  EXPECT_THAT(all<Slot>(out), IsEmpty());
  EXPECT_GT(all<Drill>(out).size(), 20U);
  EXPECT_FALSE(out.is_refused);
}

TEST(DepthFollower, WithoutAMapOnlySaysTheDepth) {
  WalkOptions options;
  options.board.tools = {depth_of(1, 0.8)};
  options.slots = Cycles::Kept;
  const Outcome out = outcome(excellon("T1\nX010.Y020.\nX010.Y020.G85X030.Y020.\n"), options);
  ASSERT_EQ(all<Drill>(out).size(), 1U);
  EXPECT_EQ(all<Drill>(out)[0].cut.depth, mm(0.8));
  EXPECT_FALSE(all<Drill>(out)[0].cut.surface);
  EXPECT_THAT(out.sieb_meyer, HasSubstr("G83K0.8"));
  EXPECT_EQ(all<Slot>(out).size(), 1U);
}

TEST(DepthFollower, LeavesHeightsAboveTheTableAndProbedOnesAlone) {
  const Outcome out = outcome(
      "%%5000\nG71K.4\nX10.Y10.T1G73L1\nL1\nX30.Y30.T1\nG70\nX40.Y40.Z1.\nX50.Y50.G83K.5\n$\nT1D1."
      "\n$\n",
      on_hills());
  const auto holes = all<Drill>(out);
  ASSERT_THAT(out.errors, IsEmpty());
  ASSERT_EQ(holes.size(), 3U);
  EXPECT_EQ(holes[0].cut.surface, mm(0));  // where a perfect board is
  EXPECT_FALSE(holes[0].cut.predicted);
  EXPECT_EQ(holes[1].cut.z, mm(1));
  EXPECT_FALSE(holes[1].cut.surface);
  EXPECT_EQ(holes[2].cut.depth, mm(0.5));
  EXPECT_EQ(holes[2].cut.surface->in_mm(), map_mm(holes[2].nominal));
}

// --- ways --------------------------------------------------------------------------------------

/// The farthest that the tool, going evenly, is from where the map says it should be; `n` pieces.
double worst_mm(const Outcome& out, std::size_t& n) {
  double worst = 0;
  n = 0;
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();
  DepthOfCut from;
  for (const Event& event : out.events) {
    if (const auto* move = std::get_if<RapidMove>(&event.what)) at_mm = move->nominal.in_mm();
    if (const auto* plunge = std::get_if<Plunge>(&event.what)) from = plunge->cut;
    const auto* rout = std::get_if<Rout>(&event.what);
    if (rout == nullptr) continue;
    ++n;
    const bool is_line = rout->kind == RoutKind::Line;
    const ArcPath way({at_mm,
                       rout->nominal.in_mm(),
                       rout->corrected_center.in_mm(),
                       rout->kind == RoutKind::Clockwise,
                       is_line});
    for (int i = 0; i <= 100; ++i) {
      const double share = i / 100.0;
      const double commanded_mm =
          (*from.surface + share * (*rout->cut.surface - *from.surface)).in_mm();
      const double true_mm = map_mm(position_mm<frame::Nominal>(way.at(share)));
      worst = std::max(worst, std::abs(commanded_mm - true_mm));
    }
    at_mm = rout->nominal.in_mm();
    from = rout->cut;
  }
  return worst;
}

TEST(DepthFollower, CutsLinesAndArcsToTheTolerance) {
  const std::string contour = excellon(
      "T1\nG00X005.Y010.\nM15\nG01X090.Y012.\nG03X060.Y060.A060.\nG02X020.Y050.A030.\nG01X020.Y090."
      "\n"
      "M16\nG05\n");
  std::size_t n_coarse = 0, n_fine = 0;
  WalkOptions options = on_hills({depth_of(1, 0.2)});
  options.board.height_tolerance = um(20);
  const Outcome coarse = outcome(contour, options);
  ASSERT_THAT(coarse.errors, IsEmpty());
  EXPECT_LE(worst_mm(coarse, n_coarse), 0.020);
  EXPECT_GT(worst_mm(coarse, n_coarse), 0.010);  // no finer than asked
  options.board.height_tolerance = um(2);
  EXPECT_LE(worst_mm(outcome(contour, options), n_fine), 0.002);
  // Chords that keep to a bend are as many as the root of the tolerance asks.
  EXPECT_LT(n_coarse, 25U);
  EXPECT_GT(n_fine, 2 * n_coarse);
  EXPECT_LT(n_fine, 5 * n_coarse);
}

TEST(DepthFollower, KeepsArcsOnTheirCircle) {
  const Outcome out = outcome(excellon("T1\nG00X020.Y040.\nM15\nG03X060.Y040.A020.\nM16\nG05\n"),
                              on_hills({depth_of(1, 0.2)}));
  const auto routs = all<Rout>(out);
  ASSERT_GT(routs.size(), 2U);
  for (const Rout& rout : routs) {
    EXPECT_EQ(rout.kind, RoutKind::Counterclockwise);
    EXPECT_NEAR((rout.corrected_center.in_mm() - Eigen::Vector2d(40, 40)).norm(), 0, 1e-9);
    EXPECT_NEAR((rout.nominal.in_mm() - Eigen::Vector2d(40, 40)).norm(), 20, 1e-9);
  }
}

// --- what the SIEB & MEYER writer makes of it --------------------------------------------------

/// Depth is a height that the program states, in the same places.
void expect_same_heights(const std::string& text, const WalkOptions& options) {
  const Outcome first = outcome(text, options);
  ASSERT_THAT(first.errors, IsEmpty());
  ASSERT_FALSE(first.is_refused);
  const Outcome second = outcome(first.sieb_meyer, {});
  ASSERT_THAT(second.errors, IsEmpty()) << first.sieb_meyer;
  const auto expect_same = [](const auto& asked, const auto& read) {
    ASSERT_EQ(asked.size(), read.size());
    for (std::size_t i = 0; i < asked.size(); ++i) {
      EXPECT_NEAR((asked[i].nominal - read[i].nominal).in_mm().norm(), 0, kLastDigit_mm);
      ASSERT_TRUE(asked[i].cut.depth && asked[i].cut.surface && read[i].cut.z);
      const Length wanted = *asked[i].cut.surface - *asked[i].cut.depth;
      EXPECT_NEAR(read[i].cut.z->in_mm(), wanted.in_mm(), 1e-6);
    }
  };
  expect_same(all<Drill>(first), all<Drill>(second));
  expect_same(all<Rout>(first), all<Rout>(second));
  // Depths to which the cutter goes down.
  const auto asked = all<Plunge>(first), read = all<Plunge>(second);
  ASSERT_EQ(asked.size(), read.size());
  for (std::size_t i = 0; i < asked.size(); ++i) {
    EXPECT_NEAR(
        read[i].cut.z->in_mm(), (*asked[i].cut.surface - *asked[i].cut.depth).in_mm(), 1e-6);
  }
}

TEST(DepthFollower, IsReadAgainAsWritten) {
  expect_same_heights(
      "%%5000\nX10.Y10.T1G83K.4\nX30.Y30.\nX50.Y50.K.6\nX10.Y20.T0\nX80.Y25.G1F1.\nX60.Y60.G3R40.\n"
      "X60.Y60.T0\nX20.Y20.T0\nX20.Y80.G1K.5\nX20.Y80.T0\n$\nT1D1.\n$\n",
      on_hills());
  expect_same_heights(excellon("T1\nX010.Y020.\nX050.Y030.\nG00X005.Y010.\nM15\nG01X090.Y012.\n"
                               "G03X060.Y060.A060.\nM16\nG05\nX070.Y070.\n"),
                      on_hills({depth_of(1, 0.8)}));
  // M14 follows the material by itself; here the program does.
  expect_same_heights(excellon("T1\nG00X005.Y010.\nM14\nG01X090.Y012.\nM16\nG05\n"),
                      on_hills({depth_of(1, 0.2)}));
}

TEST(DepthFollower, IsRefusedByAWriterBelowTheTable) {
  const Outcome out = outcome("%%5000\nX10.Y10.T1G83K1.7\n$\nT1D1.\n$\n", on_hills());
  EXPECT_THAT(out.errors, IsEmpty());
  EXPECT_TRUE(out.is_refused);
}

TEST(DepthFollower, IsRefusedByAWriterWherePeckingCountsFromTheBoard) {
  const std::string pecks = "%%5000\nG81I.5P80J1.W900\nX10.Y10.T1G83K.4\n$\nT1D1.\n$\n";
  EXPECT_TRUE(outcome(pecks, on_hills()).is_refused);
  EXPECT_FALSE(outcome(pecks, {}).is_refused);
}

// --- refusals ----------------------------------------------------------------------------------

TEST(DepthFollower, RefusesAPlaceThatTheMapDoesNotReach) {
  const std::string holes = "T1\nX010.Y020.\nX010.Y103.\nX010.Y104.\n";
  const Outcome out = outcome(excellon(holes), on_hills({depth_of(1, 0.8)}));
  EXPECT_THAT(out.errors,
              ElementsAre(Reports(
                  "p:8: error[grid-invalid]", "(10.000, 103.000)", "7.000 mm", "5.000 mm")));
  EXPECT_THAT(outcome(excellon(holes), on_hills({depth_of(2, 0.8)})).errors, IsEmpty());
}

TEST(DepthFollower, RefusesAWayThatLeavesTheMapBetweenItsEnds) {
  const Outcome out = outcome(excellon("T1\nG00X020.Y090.\nM15\nG02X080.Y090.A030.\nM16\nG05\n"),
                              on_hills({depth_of(1, 0.2)}));
  ASSERT_EQ(out.errors.size(), 1U);
  EXPECT_THAT(out.errors[0], HasSubstr("p:9: error[grid-invalid]"));
}

TEST(DepthFollower, RefusesAHeightThatIsNotSure) {
  WalkOptions options = on_hills({depth_of(1, 0.8)});
  options.board.max_sigma = um(0.5);
  const Outcome out = outcome(excellon("T1\nX010.Y020.\nX020.Y020.\n"), options);
  EXPECT_THAT(out.errors,
              ElementsAre(Reports("p:7: error[tolerance-hold]", "0.5 um", "max_sigma_um")));
}

TEST(DepthFollower, RefusesWhatContradictsTheProgram) {
  const auto error = [](const std::string& text) {
    const Outcome out = outcome(text, on_hills({depth_of(1, 0.8)}));
    EXPECT_EQ(out.errors.size(), 1U);
    return out.errors.empty() ? "" : out.errors[0];
  };
  EXPECT_THAT(error("%%5000\nX10.Y10.T1G83K.4\nX20.Y10.\n$\nT1D1.\n$\n"),
              Reports("p:2: error[argument-invalid]", "0.4 mm", "0.8 mm"));
  EXPECT_THAT(error("%%5000\nX10.Y10.T1Z3.\n$\nT1D1.\n$\n"), HasSubstr("Z3"));
  EXPECT_THAT(error(excellon("T1Z-0.1\nX010.Y020.\n")), HasSubstr("-0.1 mm"));
  // I is 3 mm above the table; below a surface it would be 3 mm above the board.
  for (const char* const pecks : {"G81I3.J.5W1000", "G89I3.J.5E30"}) {
    EXPECT_THAT(error("%%5000\nX10.Y10.T1" + std::string(pecks) + "\nX20.Y10.\n$\nT1D1.\n$\n"),
                Reports("p:2: error[argument-invalid]", "above the table", "0.8 mm"));
  }
  EXPECT_THAT(error(excellon("T1\nX010.Y010.G87X020.Y010.Z-0.1U0.3\n")),
              HasSubstr("p:7: error[not-supported]"));
  // Contours are not pecked, and I under G83 is above the board anyway.
  EXPECT_THAT(outcome("%%5000\nX10.Y10.T1T0G81I3.J.5W1000\nX20.Y10.G1\nX20.Y10.T0\nX30.Y10.G80\n"
                      "X40.Y10.G83G81\n$\nT1D1.\n$\n",
                      on_hills({depth_of(1, 0.8)}))
                  .errors,
              IsEmpty());
  EXPECT_THAT(
      outcome("%%5000\nX10.Y10.T1G83K.8\n$\nT1D1.\n$\n", on_hills({depth_of(1, 0.8)})).errors,
      IsEmpty());
}

TEST(DepthFollower, RefusesAStrokeBelowItsLimit) {
  const Outcome out =
      outcome("%%5000\nX10.Y10.Z1.3T1\nX20.Y10.G83K.2\nX30.Y10.K.5\n$\nT1D1.\n$\n", on_hills());
  ASSERT_EQ(out.errors.size(), 1U);
  EXPECT_THAT(out.errors[0], Reports("p:4: error[argument-invalid]", "0.500 mm", "Z1.3"));
}

TEST(DepthFollower, HasNoFormInExcellon) {
  DiagnosticLog log;
  NominalSource panel;
  const WalkOptions options = on_hills({depth_of(1, 0.8)});
  const Program program = load_program({"p", excellon("T1\nX010.Y020.\n")}, log);
  StringSink bytes;
  ExcellonWriter writer(bytes, {.allow_losses = true});
  execute(program, options, survey(program, options, panel, log), writer, log);
  EXPECT_TRUE(writer.losses().has_errors());
}

}  // namespace
}  // namespace panelcal
