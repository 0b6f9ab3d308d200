// SPDX-License-Identifier: Apache-2.0
#include "panelcal/surface/map_file.h"

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "tests/support/matchers.h"
#include "tests/surface/simulated_warp.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::probed_lattice;
using test::SimulatedWarp;

/// 7 x 6 probes of a warped panel, the 12th of which is 0.5 mm too high.
StoredMap stored(std::optional<SurfaceModel> model = std::nullopt) {
  Random random(71);
  std::vector<ProbePoint> points = probed_lattice(random, SimulatedWarp(random, 3), 7, 6);
  points[12].measured.height = points[12].measured.height + mm(0.5);
  points[13].name = "a \"name\" \\ of its own";
  auto map = HeightMap::of_probes(points, {.model = model, .max_extrapolation = mm(7)});
  EXPECT_TRUE(map) << map.error().text();
  return {std::move(points), *std::move(map), {{"probes.jsonl", "abc"}}, "panelcal test"};
}

Expected<StoredMap> again(const std::string& text) {
  return parse_map_file(text, "map.json");
}

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(MapFile, GivesTheSameHeightsAndSigmasToTheBit) {
  for (const auto model : {SurfaceModel::Plane,
                           SurfaceModel::ThinPlate,
                           SurfaceModel::GaussianProcess,
                           SurfaceModel::Bilinear,
                           SurfaceModel::MonotoneBicubic}) {
    // A plane does not go through a warped panel unless all of it is called noise.
    Random random(73);
    const double warp = model == SurfaceModel::Plane ? 0 : 1;
    const SimulatedWarp bent(random, 3);
    const auto surface = [&](const Eigen::Vector2d& p_mm) { return warp * bent(p_mm); };
    const std::vector<ProbePoint> points = probed_lattice(random, surface, 7, 6);
    auto map = HeightMap::of_probes(points, {.model = model});
    ASSERT_TRUE(map) << map.error().text();
    const StoredMap before{points, *std::move(map), {{"probes.jsonl", "abc"}}, "panelcal test"};
    const auto after = again(map_file_text(before));
    ASSERT_TRUE(after) << after.error().text();
    for (int i = 0; i < 300; ++i) {
      const auto place =
          position_mm<frame::Nominal>(random.uniform(-154, 154), random.uniform(-154, 154));
      const auto was = before.map.height_at(place), is = after->map.height_at(place);
      ASSERT_EQ(was.has_value(), is.has_value());
      if (!was) continue;
      EXPECT_EQ(was->height, is->height);
      EXPECT_EQ(was->sigma, is->sigma);
      EXPECT_EQ(was->source, is->source);
      EXPECT_EQ(was->outside, is->outside);
    }
    EXPECT_EQ(before.map.lattice_error(), after->map.lattice_error());
  }
}

TEST(MapFile, KeepsWhatTheMapWasMadeOf) {
  const StoredMap before = stored();
  const std::string text = map_file_text(before);
  const auto after = again(text);
  ASSERT_TRUE(after) << after.error().text();
  EXPECT_EQ(map_file_text(*after), text);
  ASSERT_EQ(after->map.outliers().size(), 1U);
  EXPECT_EQ(after->map.outliers()[0].text(), before.map.outliers()[0].text());
  EXPECT_EQ(after->points[13].name, before.points[13].name);
  EXPECT_EQ(after->points[13].from.file, "probes.jsonl");
  EXPECT_EQ(after->points[13].from.line, before.points[13].from.line);
  EXPECT_EQ(after->map.reason(), before.map.reason());
  EXPECT_EQ(after->map.options().max_extrapolation, mm(7));
  EXPECT_EQ(after->sources[0].sha256, "abc");
}

TEST(MapFile, KnowsProbesThatCameFromNoFile) {
  StoredMap before = stored();
  before.points[3].from = {};
  const auto after = again(map_file_text(before));
  ASSERT_TRUE(after) << after.error().text();
  EXPECT_EQ(after->points[3].from.file, "");
  EXPECT_EQ(after->points[4].from.file, "probes.jsonl");
}

TEST(MapFile, RefusesWhatIsNoMap) {
  const std::string good = map_file_text(stored(SurfaceModel::GaussianProcess));
  const auto with = [&](std::string_view from, std::string_view to) {
    return again(replaced(good, from, to));
  };
  EXPECT_THAT(with("\"version\": 1", "\"version\": 2"),
              FailsWith(Code::MeasurementFile, "version"));
  EXPECT_THAT(with("\"units\": \"mm\"", "\"units\": \"inch\""),
              FailsWith(Code::MeasurementFile, "inch"));
  EXPECT_THAT(with("\"reason\"", "\"raeson\""), FailsWith(Code::MeasurementFile, "raeson"));
  EXPECT_THAT(with("\"model\": \"gaussian-process\"", "\"model\": \"spline\""),
              FailsWith(Code::MeasurementFile, "spline"));
  EXPECT_THAT(with("\"model\": \"gaussian-process\"", "\"model\": \"plane\""),
              FailsWith(Code::ConfigValue, "is not one of a plane"));
  EXPECT_THAT(with("\"noise_factor\": ", "\"noise_factor\": -"),
              FailsWith(Code::ConfigValue, "noise factor"));
  EXPECT_THAT(with("\"length\": ", "\"length\": -"), FailsWith(Code::ConfigValue, "length"));
  EXPECT_THAT(with("\"probe\": 12", "\"probe\": 99"),
              FailsWith(Code::MeasurementFile, "a whole number from 0 to 41"));
  EXPECT_THAT(with("\"sigma\": 0.003, \"source\"", "\"sigma\": 0, \"source\""),
              FailsWith(Code::GridInvalid, "map.json: error"));
  EXPECT_THAT(with("\"source\": 0", "\"source\": 1"),
              FailsWith(Code::MeasurementFile, "a whole number from 0 to 0"));
  EXPECT_THAT(with("\"place\": [", "\"place\": [1e300, "),
              FailsWith(Code::MeasurementFile, "place"));
  EXPECT_THAT(with("\"max_extrapolation\": 7", "\"max_extrapolation\": 1e9"),
              FailsWith(Code::ConfigValue, "max_extrapolation"));
  EXPECT_THAT(again(""), FailsWith(Code::JsonSyntax, "map.json"));
  EXPECT_THAT(again("[]"), FailsWith(Code::MeasurementFile, "no JSON object"));
  EXPECT_THAT(with("\"place\": [-150, ", "\"place\": [1e9, "),
              FailsWith(Code::MeasurementFile, "1000000000 mm"));
}

TEST(MapFile, RefusesAnyCutOffFile) {
  const std::string good = map_file_text(stored(SurfaceModel::ThinPlate));
  // The last byte is a line's end.
  for (std::size_t n = 0; n + 1 < good.size(); n += 97) {
    EXPECT_THAT(again(good.substr(0, n)), FailsWith(Code::JsonSyntax, "map.json")) << n;
  }
}

}  // namespace
}  // namespace panelcal
