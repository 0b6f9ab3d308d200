// SPDX-License-Identifier: Apache-2.0
#include "program/judge/surface_use.h"

#include <vector>

#include "tests/program/operations.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using namespace test;
using ::testing::HasSubstr;

/// A plane at 1.6 mm, probed with 2 um.
HeightMap level_map() {
  std::vector<ProbePoint> points;
  for (int i = 0; i < 36; ++i) {
    const double wobble_mm = i % 2 == 0 ? 0.001 : -0.001;
    points.push_back({position_mm<frame::Nominal>(20.0 * (i % 6), 20.0 * (i / 6)),
                      {mm(1.6 + wobble_mm), um(2)},
                      "probe",
                      {}});
  }
  HeightMapOptions options;
  options.model = SurfaceModel::Plane;
  return HeightMap::of_probes(points, options).value();
}

ProbeReading probe(double x_mm, double height_mm) {
  ProbeReading reading;
  reading.request.line = 7;
  reading.request.command = "G73";
  reading.request.nominal = position_mm<frame::Nominal>(x_mm, 10);
  reading.status = ProbeStatus::Found;
  reading.heights = {{mm(height_mm), um(2)}};
  return reading;
}

std::string held(std::vector<ProbeReading> probes) {
  Survey survey;
  survey.probes = std::move(probes);
  DiagnosticLog log;
  hold_against_map(survey, level_map(), "p", log);
  return log.kept().empty() ? "" : log.kept().front().text();
}

TEST(HoldAgainstMap, NamesTheProbeThatContradictsMost) {
  const std::string text = held({probe(10, 1.601), probe(20, 1.63), probe(30, 1.7)});
  EXPECT_THAT(text,
              Reports("p:7:1: error[surface-out-of-tolerance]",
                      "2 of 3 probes",
                      "G73 probe 0 (line 7)",
                      "+99.8 um",
                      "10.4 um"));
}

TEST(HoldAgainstMap, BelievesWhatScatterExplains) {
  EXPECT_EQ(held({probe(10, 1.605), probe(30, 1.595)}), "");
  EXPECT_NE(held({probe(10, 1.62)}), "");
}

TEST(HoldAgainstMap, AsksNothingWhereItDoesNotReachOrNothingWasFound) {
  ProbeReading lost = probe(10, 2);
  lost.status = ProbeStatus::NotFound;
  EXPECT_EQ(held({lost, probe(500, 2)}), "");
}

Drill at_height(double height_mm, double sigma_um, HeightSource source) {
  Drill hole = drill(1, 1, 1);
  hole.cut.depth = mm(0.2);
  hole.cut.surface = mm(height_mm);
  hole.cut.predicted = PredictedHeight{um(sigma_um), source};
  return hole;
}

TEST(SurfaceUse, CountsWhatTheMapForetells) {
  SurfaceUse use;
  EXPECT_THAT(use.summary(), HasSubstr("no depth counts from the map"));
  put_all(use,
          {at_height(1.6, 2, HeightSource::Measured),
           at_height(1.55, 7, HeightSource::Filled),
           at_height(1.65, 4, HeightSource::Extrapolated),
           drill(1, 1, 1)});
  EXPECT_EQ(
      use.summary(),
      "3 depths count from the map, 1.5500 to 1.6500 mm high, sigma at most 7.00 um (line 11); "
      "1 where a probe is missing; 1 outside of what was probed");
}

}  // namespace
}  // namespace panelcal
