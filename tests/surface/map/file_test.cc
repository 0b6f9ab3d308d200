// SPDX-License-Identifier: Apache-2.0
#include "surface/map/file.h"

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "tests/support/matchers.h"
#include "tests/surface/fit/simulated_warp.h"

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

TEST(MapFile, OfFewProbesHasTheBendThatOneLeftOutMayShow) {
  Random random(76);
  const auto flat = [](const Eigen::Vector2d&) { return 1.6; };
  std::vector<ProbePoint> points = probed_lattice(random, flat, 3, 3, 0.003);
  points[4].measured.height = points[4].measured.height + mm(0.3);
  auto map = HeightMap::of_probes(points);
  ASSERT_TRUE(map) << map.error().text();
  ASSERT_EQ(map->outliers().size(), 1U);
  const StoredMap before{points, *std::move(map), {}, "panelcal test"};
  const auto after = again(map_file_text(before));
  ASSERT_TRUE(after) << after.error().text();
  const auto there = after->map.height_at(points[4].place);
  ASSERT_TRUE(there) << there.error().text();
  EXPECT_GT(there->sigma, um(280));
  EXPECT_EQ(there->sigma, before.map.height_at(points[4].place)->sigma);
}

/// What does not state it has no key, as maps of before.
TEST(MapFile, KeepsWhoseHeightsTheyAre) {
  StoredMap before = stored();
  EXPECT_EQ(map_file_text(before).find("zaxis"), std::string::npos);
  EXPECT_FALSE(again(map_file_text(before))->z_axis);
  before.z_axis = 1;
  const std::string text = map_file_text(before);
  const auto after = again(text);
  ASSERT_TRUE(after) << after.error().text();
  EXPECT_EQ(after->z_axis, 1);
  EXPECT_EQ(map_file_text(*after), text);
  for (const char* axis : {"-1", "64", "0.5", "\"1\""}) {
    std::string wrong = text;
    wrong.replace(wrong.find("\"zaxis\": 1"), 10, std::string("\"zaxis\": ") + axis);
    EXPECT_THAT(again(wrong), FailsWith(Code::MeasurementFile, "zaxis")) << axis;
  }
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
  EXPECT_THAT(with("\"version\": 1", "\"version\": 3"), FailsWith(Code::MeasurementFile, "\"3\""));
  EXPECT_THAT(with("\"version\": 1", "\"version\": 2"), FailsWith(Code::MeasurementFile));
  EXPECT_THAT(with("\"noise_factor\": ", "\"noise_factor\": 1e7, \"noise\": "),
              FailsWith(Code::MeasurementFile, "\"noise\""));
  EXPECT_THAT(with("\"reach\": [", "\"reach\": [1e9, 1], \"no\": ["),
              FailsWith(Code::MeasurementFile, "\"no\""));
  EXPECT_THAT(with("\"units\": \"mm\"", "\"units\": \"inch\""),
              FailsWith(Code::MeasurementFile, "inch"));
  EXPECT_THAT(with("\"reason\"", "\"raeson\""), FailsWith(Code::MeasurementFile, "raeson"));
  EXPECT_THAT(with("\"model\": \"gaussian-process\"", "\"model\": \"spline\""),
              FailsWith(Code::MeasurementFile, "spline"));
  EXPECT_THAT(with("\"model\": \"gaussian-process\"", "\"model\": \"plane\""),
              FailsWith(Code::ConfigValue, "plane"));
  EXPECT_THAT(with("\"noise_factor\": ", "\"noise_factor\": -"),
              FailsWith(Code::ConfigValue, "noise factor"));
  EXPECT_THAT(with("\"length\": ", "\"length\": -"), FailsWith(Code::ConfigValue, "length"));
  EXPECT_THAT(with("\"probe\": 12", "\"probe\": 99"), FailsWith(Code::MeasurementFile, "41"));
  EXPECT_THAT(with("\"sigma\": 0.003, \"source\"", "\"sigma\": 0, \"source\""),
              FailsWith(Code::GridInvalid, "map.json: error"));
  EXPECT_THAT(with("\"source\": 0", "\"source\": 1"), FailsWith(Code::MeasurementFile, "source"));
  EXPECT_THAT(with("\"place\": [", "\"place\": [1e300, "),
              FailsWith(Code::MeasurementFile, "place"));
  EXPECT_THAT(with("\"max_extrapolation\": 7", "\"max_extrapolation\": 1e9"),
              FailsWith(Code::ConfigValue, "max_extrapolation"));
  EXPECT_THAT(again(""), FailsWith(Code::JsonSyntax, "map.json"));
  EXPECT_THAT(again("[]"), FailsWith(Code::MeasurementFile));
  EXPECT_THAT(with("\"place\": [-150, ", "\"place\": [1e9, "),
              FailsWith(Code::MeasurementFile, "\"place\" of probe 0"));
}

TEST(MapFile, KeepsTheShapesThatASurfaceIsTheAverageOf) {
  Random random(75);
  const std::vector<ProbePoint> points = probed_lattice(random, SimulatedWarp(random, 2), 5, 5);
  auto map = HeightMap::of_probes(points, {.model = SurfaceModel::GaussianProcess});
  ASSERT_TRUE(map) << map.error().text();
  const StoredMap before{points, *std::move(map), {}, "panelcal test"};
  ASSERT_GT(before.map.surface().shapes().size(), 1U);
  const std::string text = map_file_text(before);
  const auto after = again(text);
  ASSERT_TRUE(after) << after.error().text();
  EXPECT_EQ(after->map.surface().summary(), before.map.surface().summary());
  EXPECT_THAT(again(replaced(text, "\"weight\": ", "\"weight\": 1")),
              FailsWith(Code::ConfigValue, "add up"));
  EXPECT_THAT(again(replaced(text, "\"weight\"", "\"wieght\"")),
              FailsWith(Code::MeasurementFile, "wieght"));
}

TEST(MapFile, KeepsUnresolvedBending) {
  Random random(74);
  const auto bowed = [](const Eigen::Vector2d& p_mm) { return 1e-6 * p_mm.squaredNorm(); };
  const std::vector<ProbePoint> points = probed_lattice(random, bowed, 5, 5);
  auto map = HeightMap::of_probes(points, {.model = SurfaceModel::Plane});
  ASSERT_TRUE(map) << map.error().text();
  const StoredMap before{points, *std::move(map), {}, "panelcal test"};
  const auto after = again(map_file_text(before));
  ASSERT_TRUE(after) << after.error().text();
  EXPECT_GT(after->map.surface().shape().unresolved, um(10));
  EXPECT_EQ(after->map.surface().shape().unresolved, before.map.surface().shape().unresolved);
  EXPECT_EQ(after->map.surface().summary(), before.map.surface().summary());
}

TEST(MapFile, HoldsGridModelsToTheirNoise) {
  Random random(73);
  const std::vector<ProbePoint> points = probed_lattice(random, SimulatedWarp(random, 3), 7, 6);
  auto map = HeightMap::of_probes(points, {.model = SurfaceModel::Bilinear});
  ASSERT_TRUE(map) << map.error().text();
  const std::string good = map_file_text(StoredMap{points, *std::move(map), {}, "panelcal test"});
  EXPECT_TRUE(again(good));
  EXPECT_THAT(again(replaced(good, "\"noise_factor\": 1,", "\"noise_factor\": 2,")),
              FailsWith(Code::MeasurementFile, "noise factor"));
}

TEST(MapFile, RefusesMoreProbesThanASurfaceMayHave) {
  const std::string good = map_file_text(stored());
  const std::string_view first = R"({"name": "column 0 row 0",)";
  std::string many;
  for (int i = 0; i < 3000; ++i) {
    many += R"({"name": "", "place": [0, 0], "height": 0, "sigma": 1, "source": null, "line": 0},)";
  }
  EXPECT_THAT(again(replaced(good, first, many + std::string(first))),
              FailsWith(Code::MeasurementFile, "3042 probes"));
}

/// Two zones, a clamp, holes of two sizes, a slot and an edge; 2 probes are in voids, 7 in no zone.
StoredZones zoned() {
  Random random(77);
  std::vector<ProbePoint> points = probed_lattice(random, SimulatedWarp(random, 3), 13, 7);
  points[30].measured.height = points[30].measured.height + mm(0.5);
  const auto at = [](double x_mm, double y_mm) { return position_mm<frame::Nominal>(x_mm, y_mm); };
  std::vector<Void> all = {{rectangle(at(-160, -160), at(-145, -130)), "clamp", {"z.toml", 4, 1}},
                           {Circle{at(10.5, 1.0 / 3), mm(0.4)}, "hole of tool 1", {"p.exc", 7, 1}},
                           {Circle{at(11.5, 3), mm(0.4)}, "hole of tool 1", {"p.exc", 8, 1}},
                           {Circle{at(100, 100), mm(2)}, "hole of tool 2", {"p.exc", 11, 1}},
                           {Track{{at(50, 50), at(60, 55)}, mm(2)}, "slot", {"p.exc", 12, 1}},
                           {Outside{rectangle(at(-155, -155), at(155, 151))}, "edge", {}}};
  auto voids = Voids::make(std::move(all), mm(0.5));
  EXPECT_TRUE(voids) << voids.error().text();
  std::vector<Zone> zones = {{rectangle(at(-160, -160), at(-10, 160)), "left"},
                             {Circle{at(90, 0), mm(170)}, "right"}};
  zones[0].options.max_extrapolation = mm(2);
  zones[1].options.model = SurfaceModel::ThinPlate;
  auto map = ZonedMap::of_probes(points, std::move(zones), *std::move(voids));
  EXPECT_TRUE(map) << map.error().text();
  return {std::move(points), *std::move(map), {{"probes.jsonl", "abc"}}, "panelcal test"};
}

TEST(MapFile, GivesTheSameHeightsOfZonesToTheBit) {
  const StoredZones before = zoned();
  const std::string text = map_file_text(before);
  const auto after = parse_zoned_map_file(text, "map.json");
  ASSERT_TRUE(after) << after.error().text();
  EXPECT_EQ(map_file_text(*after), text);
  ASSERT_EQ(after->map.unused().size(), before.map.unused().size());
  EXPECT_GT(before.map.unused().size(), 0U);
  for (std::size_t i = 0; i < before.map.unused().size(); ++i) {
    EXPECT_EQ(before.map.unused()[i].reason, after->map.unused()[i].reason);
  }
  EXPECT_EQ(before.map.map(0).outliers().size(), 1U);
  Random random(78);
  int n_void = 0, n_refused = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto place =
        position_mm<frame::Nominal>(random.uniform(-170, 170), random.uniform(-170, 170));
    const auto was = before.map.height_at(place), is = after->map.height_at(place);
    ASSERT_EQ(was.has_value(), is.has_value());
    n_refused += was ? 0 : 1;
    if (!was) continue;
    EXPECT_EQ(was->i_zone, is->i_zone);
    EXPECT_EQ(was->in_void, is->in_void);
    EXPECT_EQ(was->height.height, is->height.height);
    EXPECT_EQ(was->height.sigma, is->height.sigma);
    EXPECT_EQ(was->height.source, is->height.source);
    n_void += was->in_void.empty() ? 0 : 1;
  }
  EXPECT_GT(n_void, 4);
  EXPECT_GT(n_refused, 100);
}

TEST(MapFile, WritesHolesOfOneToolTogether) {
  const std::string text = map_file_text(zoned());
  EXPECT_NE(text.find(R"({"name": "hole of tool 1", "file": "p.exc", "diameter": 0.8, "circles": [)"
                      R"([10.5, 0.3333333333333333, 7], [11.5, 3, 8]]})"),
            std::string::npos)
      << text;
}

TEST(MapFile, KnowsVoidsWithoutZones) {
  const StoredMap plain = stored();
  auto voids = Voids::make({{Circle{position_mm<frame::Nominal>(0, 0), mm(2)}, "hole", {}}});
  auto map = ZonedMap::of_probes(plain.points, {}, *voids);
  ASSERT_TRUE(map) << map.error().text();
  const StoredZones before{plain.points, *map, plain.sources, plain.made_by};
  const auto after = parse_zoned_map_file(map_file_text(before), "map.json");
  ASSERT_TRUE(after) << after.error().text();
  EXPECT_TRUE(after->map.zones().empty());
  EXPECT_EQ(after->map.height_at(position_mm<frame::Nominal>(0, 1.9))->in_void, "\"hole\"");
  // A reader of one map alone would overlook the hole.
  EXPECT_THAT(again(map_file_text(before)), FailsWith(Code::NotSupported, "0 zones and 1 voids"));
}

TEST(MapFile, RefusesZonesAndVoidsThatAreNone) {
  const std::string good = map_file_text(zoned());
  const auto with = [&](std::string_view from, std::string_view to) {
    return parse_zoned_map_file(replaced(good, from, to), "map.json");
  };
  const auto code = Code::MeasurementFile;
  EXPECT_THAT(with("\"name\": \"right\"", "\"name\": \"left\""),
              FailsWith(Code::ConfigValue, "map.json: error[config-value]"));
  EXPECT_THAT(with("\"center\": [90, 0]", "\"center\": [90]"), FailsWith(code, "center"));
  EXPECT_THAT(with("\"diameter\": 340", "\"diameter\": -1"),
              FailsWith(Code::ConfigValue, "radius"));
  EXPECT_THAT(with("\"area\": {\"center\": [90, 0], \"diameter\": 340}", "\"area\": null"),
              FailsWith(code, "\"right\""));
  EXPECT_THAT(with("\"polygon\"", "\"polygone\""), FailsWith(code, "area"));
  EXPECT_THAT(with("\"margin\": 0.5", "\"margin\": -1"), FailsWith(Code::ConfigValue, "margin"));
  EXPECT_THAT(with("[11.5, 3, 8]", "[11.5, 3]"), FailsWith(code, "map.json:"));
  EXPECT_THAT(with("[11.5, 3, 8]", "[11.5, 3, -8]"), FailsWith(code, "map.json:"));
  EXPECT_THAT(with("[11.5, 3, 8]", "[1e7, 3, 8]"), FailsWith(Code::ConfigValue, "center"));
  EXPECT_THAT(with("\"track\": [[50, 50]", "\"track\": [[50, \"50\"]"),
              FailsWith(code, "map.json:"));
  EXPECT_THAT(with("\"width\": 2", "\"widht\": 2"), FailsWith(code, "widht"));
  // Half of the panel is away: 6 probes of the left zone are left, of which one was left out.
  EXPECT_THAT(with("\"outside\": [[-155, -155], ", "\"outside\": ["), FailsWith(code, "map.json"));
  // The probe that is left out, of the left zone.
  EXPECT_THAT(with("{\"probe\": 30", "{\"probe\": 38"), FailsWith(code, "map.json"));
  for (std::size_t n = 0; n + 1 < good.size(); n += 397) {
    EXPECT_THAT(parse_zoned_map_file(good.substr(0, n), "map.json"),
                FailsWith(Code::JsonSyntax, "map.json"))
        << n;
  }
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
