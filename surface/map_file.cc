// SPDX-License-Identifier: Apache-2.0
#include "panelcal/surface/map_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "panelcal/calib/base/atomic_file.h"
#include "panelcal/calib/strict_json.h"

namespace panelcal {
namespace {

using internal::StrictObject;
using nlohmann::json;

constexpr std::string_view kKind = "surface-map";
constexpr int kVersion = 1;
constexpr Code kCode = Code::MeasurementFile;
/// Farther away or higher nothing is probed: a wrong unit.
constexpr double kMost_mm = 3e7;
constexpr int kMaxInt = std::numeric_limits<int>::max();

Diagnostic invalid(const std::string& file, std::string what, std::string expected) {
  return {kCode, {file, 0, 0}, std::move(what), std::move(expected)};
}

std::string json_text(const std::string& text) {
  return json(text).dump(-1, ' ', true, json::error_handler_t::replace);
}

std::string_view word(LatticeInterpolation interpolation) {
  return interpolation == LatticeInterpolation::Bilinear ? "bilinear" : "monotone-bicubic";
}

/// The elements of an array of objects.
Expected<std::vector<StrictObject>> read_objects(const StrictObject& top,
                                                 std::string_view key,
                                                 std::string_view what,
                                                 std::span<const std::string_view> keys,
                                                 const std::string& file) {
  const json& list = top.member(key);
  if (!list.is_array()) {
    return failure(invalid(file, fmt::format("{} is no array", quoted(key)), "[{...}, ...]"));
  }
  std::vector<StrictObject> out;
  for (const json& element : list) {
    PANELCAL_TRY(
        StrictObject object,
        StrictObject::make(element, fmt::format("{} {}", what, out.size()), keys, kCode, file));
    out.push_back(std::move(object));
  }
  return out;
}

Expected<std::vector<MapSource>> read_sources(const StrictObject& top, const std::string& file) {
  constexpr std::array<std::string_view, 2> kKeys = {"file", "sha256"};
  PANELCAL_TRY(const auto objects, read_objects(top, "sources", "source", kKeys, file));
  std::vector<MapSource> out;
  for (const StrictObject& object : objects) {
    MapSource source;
    PANELCAL_TRY(source.file, object.text("file"));
    PANELCAL_TRY(source.sha256, object.text("sha256"));
    out.push_back(std::move(source));
  }
  return out;
}

Expected<ProbePoint> read_probe(const StrictObject& object,
                                const std::vector<MapSource>& sources,
                                const std::string& file) {
  ProbePoint point;
  PANELCAL_TRY(point.name, object.text("name"));
  PANELCAL_TRY(const auto xy_mm, object.numbers("place", 2));
  PANELCAL_TRY(const double height_mm, object.number("height"));
  PANELCAL_TRY(const double sigma_mm, object.number("sigma"));
  for (const double value_mm : {xy_mm[0], xy_mm[1], height_mm}) {
    if (std::abs(value_mm) <= kMost_mm) continue;
    return failure(invalid(file,
                           fmt::format("{} has {} mm", quoted(name_of(point)), value_mm),
                           fmt::format("at most {} mm", kMost_mm)));
  }
  point.place = position_mm<frame::Nominal>(xy_mm[0], xy_mm[1]);
  point.measured = {mm(height_mm), mm(sigma_mm)};
  PANELCAL_TRY(point.from.line, object.integer("line", 0, kMaxInt));
  if (object.member("source").is_null()) return point;
  const int last = static_cast<int>(sources.size()) - 1;
  PANELCAL_TRY(const int i_source, object.integer("source", 0, last));
  point.from.file = sources[static_cast<std::size_t>(i_source)].file;
  return point;
}

Expected<SurfaceShape> read_shape(const StrictObject& top, const std::string& file) {
  constexpr std::array<std::string_view, 5> kKeys = {
      "kernel", "length", "strength", "noise_factor", "trend"};
  PANELCAL_TRY(const StrictObject object,
               StrictObject::make(top.member("shape"), "the shape", kKeys, kCode, file));
  SurfaceShape shape;
  PANELCAL_TRY(const std::string kernel, object.text("kernel"));
  const auto known = bending_kernel(kernel);
  if (!known) {
    return failure(invalid(file,
                           "the kernel is " + quoted(kernel),
                           "none, thin-plate, matern-3/2, matern-5/2 or gaussian"));
  }
  shape.kernel = *known;
  PANELCAL_TRY(const double length_mm, object.number("length"));
  shape.length = mm(length_mm);
  PANELCAL_TRY(shape.strength_mm2, object.number("strength"));
  PANELCAL_TRY(shape.noise_factor, object.number("noise_factor"));
  PANELCAL_TRY(shape.n_trend, object.integer("trend", 0, kBowTrend));
  return shape;
}

Expected<HeightMapOptions> read_options(const StrictObject& top, const std::string& file) {
  constexpr std::array<std::string_view, 6> kKeys = {
      "max_extrapolation", "reach", "interpolation", "false_alarm", "most_left_out", "most_noise"};
  PANELCAL_TRY(const StrictObject object,
               StrictObject::make(top.member("options"), "the options", kKeys, kCode, file));
  HeightMapOptions options;
  PANELCAL_TRY(const double most_mm, object.number("max_extrapolation"));
  options.max_extrapolation = mm(most_mm);
  PANELCAL_TRY(const auto reach_mm, object.numbers("reach", 2));
  options.reach_mm = Eigen::Vector2d(reach_mm[0], reach_mm[1]);
  PANELCAL_TRY(const std::string interpolation, object.text("interpolation"));
  for (const auto known : {LatticeInterpolation::Bilinear, LatticeInterpolation::MonotoneBicubic}) {
    if (word(known) == interpolation) options.interpolation = known;
  }
  if (word(options.interpolation) != interpolation) {
    return failure(invalid(
        file, "the interpolation is " + quoted(interpolation), "bilinear or monotone-bicubic"));
  }
  PANELCAL_TRY(options.outliers.false_alarm, object.number("false_alarm"));
  PANELCAL_TRY(options.outliers.most, object.number("most_left_out"));
  PANELCAL_TRY(options.outliers.most_noise, object.number("most_noise"));
  return options;
}

Expected<std::vector<SurfaceOutlier>> read_outliers(const StrictObject& top,
                                                    const std::vector<ProbePoint>& points,
                                                    const std::string& file) {
  constexpr std::array<std::string_view, 4> kKeys = {"probe", "deviation", "sigma", "chance"};
  PANELCAL_TRY(const auto objects, read_objects(top, "left_out", "left out", kKeys, file));
  std::vector<SurfaceOutlier> out;
  for (const StrictObject& object : objects) {
    SurfaceOutlier outlier;
    const int next = out.empty() ? 0 : static_cast<int>(out.back().i_point) + 1;
    const int last = static_cast<int>(points.size()) - 1;
    PANELCAL_TRY(const int i_point, object.integer("probe", next, last));
    outlier.i_point = static_cast<std::size_t>(i_point);
    outlier.name = name_of(points[outlier.i_point]);
    PANELCAL_TRY(const double deviation_mm, object.number("deviation"));
    PANELCAL_TRY(const double sigma_mm, object.number("sigma"));
    PANELCAL_TRY(outlier.chance, object.number("chance"));
    if (!(sigma_mm > 0 && outlier.chance >= 0 && outlier.chance <= 1)) {
      return failure(invalid(
          file,
          fmt::format("{} has no sigma or no chance", quoted(name_of(points[outlier.i_point]))),
          "a sigma above 0, a chance of 0 to 1"));
    }
    outlier.deviation = mm(deviation_mm);
    outlier.sigma = mm(sigma_mm);
    out.push_back(std::move(outlier));
  }
  return out;
}

std::string point_line(const ProbePoint& point, const std::vector<MapSource>& sources) {
  const auto source = std::ranges::find(sources, point.from.file, &MapSource::file);
  const bool is_known = source != sources.end();
  return fmt::format(
      R"({{"name": {}, "place": [{}, {}], "height": {}, "sigma": {}, "source": {}, "line": {}}})",
      json_text(point.name),
      point.place.in_mm().x(),
      point.place.in_mm().y(),
      point.measured.height.in_mm(),
      point.measured.sigma.in_mm(),
      is_known ? std::to_string(source - sources.begin()) : "null",
      point.from.line);
}

/// Elements on lines of their own.
std::string list_text(std::string_view key, const std::vector<std::string>& elements) {
  if (elements.empty()) return fmt::format("  \"{}\": []", key);
  return fmt::format("  \"{}\": [\n    {}\n  ]", key, fmt::join(elements, ",\n    "));
}

}  // namespace

Expected<StoredMap> parse_map_file(std::string_view text, const std::string& file) {
  constexpr std::array<std::string_view, 11> kKeys = {"kind",
                                                      "version",
                                                      "made_by",
                                                      "units",
                                                      "model",
                                                      "reason",
                                                      "shape",
                                                      "options",
                                                      "sources",
                                                      "left_out",
                                                      "probes"};
  constexpr std::array<std::string_view, 6> kProbeKeys = {
      "name", "place", "height", "sigma", "source", "line"};
  PANELCAL_TRY(const json document, internal::parse_strict_json(text, file));
  PANELCAL_TRY(const StrictObject top, StrictObject::make(document, "the map", kKeys, kCode, file));
  PANELCAL_CHECK(top.constant("kind", kKind));
  PANELCAL_CHECK(top.integer("version", kVersion, kVersion));
  PANELCAL_CHECK(top.constant("units", "mm"));
  PANELCAL_TRY(const std::string made_by, top.text("made_by"));
  PANELCAL_TRY(const std::string model_word, top.text("model"));
  const auto model = surface_model(model_word);
  if (!model) {
    return failure(invalid(file,
                           "the model is " + quoted(model_word),
                           fmt::format("one of {}", fmt::join(surface_model_words(), ", "))));
  }
  PANELCAL_TRY(std::string reason, top.text("reason"));
  PANELCAL_TRY(const SurfaceShape shape, read_shape(top, file));
  PANELCAL_TRY(const HeightMapOptions options, read_options(top, file));
  PANELCAL_TRY(auto sources, read_sources(top, file));
  PANELCAL_TRY(const auto objects, read_objects(top, "probes", "probe", kProbeKeys, file));
  std::vector<ProbePoint> points;
  for (const StrictObject& object : objects) {
    PANELCAL_TRY(ProbePoint point, read_probe(object, sources, file));
    points.push_back(std::move(point));
  }
  PANELCAL_TRY(auto outliers, read_outliers(top, points, file));
  std::vector<ProbePoint> fitted;
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::ranges::find(outliers, i, &SurfaceOutlier::i_point) != outliers.end()) continue;
    kept.push_back(i);
    fitted.push_back(points[i]);
  }
  auto made = [&]() -> Expected<HeightMap> {
    PANELCAL_TRY(SurfaceFit fit, fit_surface(fitted, *model, shape));
    SoundSurface surface{std::move(fit), std::move(kept), std::move(outliers)};
    return HeightMap::of_surface(points, {std::move(surface), std::move(reason)}, options);
  }();
  if (!made) {
    // Whatever it is, the map's file is what must be mended.
    Diagnostic problem = std::move(made).error();
    problem.place = {file, 0, 0};
    return failure(std::move(problem));
  }
  return StoredMap{std::move(points), *std::move(made), std::move(sources), made_by};
}

std::vector<ProbePoint> StoredMap::kept_points() const {
  std::vector<ProbePoint> out;
  for (const std::size_t i : map.kept()) out.push_back(points[i]);
  return out;
}

Expected<StoredMap> read_map_file(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxMapBytes));
  return parse_map_file(text, path.string());
}

std::string map_file_text(const StoredMap& stored) {
  const HeightMap& map = stored.map;
  const SurfaceShape& shape = map.surface().shape();
  const HeightMapOptions options = map.options();
  std::vector<std::string> sources, left_out, probes;
  for (const MapSource& source : stored.sources) {
    sources.push_back(fmt::format(
        R"({{"file": {}, "sha256": {}}})", json_text(source.file), json_text(source.sha256)));
  }
  for (const SurfaceOutlier& outlier : map.outliers()) {
    left_out.push_back(fmt::format(R"({{"probe": {}, "deviation": {}, "sigma": {}, "chance": {}}})",
                                   outlier.i_point,
                                   outlier.deviation.in_mm(),
                                   outlier.sigma.in_mm(),
                                   outlier.chance));
  }
  for (const ProbePoint& point : stored.points) {
    probes.push_back(point_line(point, stored.sources));
  }
  return fmt::format(
      R"({{
  "kind": "{}",
  "version": {},
  "made_by": {},
  "units": "mm",
  "model": "{}",
  "reason": {},
  "shape": {{"kernel": "{}", "length": {}, "strength": {}, "noise_factor": {}, "trend": {}}},
  "options": {{"max_extrapolation": {}, "reach": [{}, {}], "interpolation": "{}", "false_alarm": {}, "most_left_out": {}, "most_noise": {}}},
{},
{},
{}
}}
)",
      kKind,
      kVersion,
      json_text(stored.made_by),
      word(map.surface().model()),
      json_text(map.reason()),
      word(shape.kernel),
      shape.length.in_mm(),
      shape.strength_mm2,
      shape.noise_factor,
      shape.n_trend,
      options.max_extrapolation.in_mm(),
      options.reach_mm->x(),
      options.reach_mm->y(),
      word(options.interpolation),
      options.outliers.false_alarm,
      options.outliers.most,
      options.outliers.most_noise,
      list_text("sources", sources),
      list_text("left_out", left_out),
      list_text("probes", probes));
}

}  // namespace panelcal
