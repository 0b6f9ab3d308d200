// SPDX-License-Identifier: Apache-2.0
#include "surface/map/file_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using nlohmann::json;

constexpr int kMaxSurfaceInt = std::numeric_limits<int>::max();
/// Probes that scatter more than this multiple of their stated sigma are refused.
constexpr double kMostNoise = 1e6;

std::string_view word(LatticeInterpolation interpolation) {
  return interpolation == LatticeInterpolation::Bilinear ? "bilinear" : "monotone-bicubic";
}

Expected<ProbePoint> read_probe(const StrictObject& object,
                                const std::vector<MapSource>& sources,
                                const std::string& file) {
  ProbePoint point;
  PANELCAL_TRY(point.name, object.text("name"));
  PANELCAL_TRY(const auto xy_mm, object.numbers("place", 2));
  PANELCAL_TRY(const double height_mm, object.number("height"));
  PANELCAL_TRY(const double sigma_mm, object.number("sigma"));
  for (const double value_mm : {xy_mm[0], xy_mm[1], height_mm, sigma_mm}) {
    if (std::abs(value_mm) <= kMostInMap_mm) continue;
    return failure(map_file_problem(file,
                                    fmt::format("{} has {} mm", quoted(name_of(point)), value_mm),
                                    fmt::format("at most {} mm", kMostInMap_mm)));
  }
  // -0.0 would be written as -0, which is read as 0.
  point.place = position_mm<frame::Nominal>(xy_mm[0] + 0.0, xy_mm[1] + 0.0);
  point.measured = {mm(height_mm + 0.0), mm(sigma_mm)};
  PANELCAL_TRY(point.from.line, object.integer("line", 0, kMaxSurfaceInt));
  if (object.member("source").is_null()) return point;
  const int last = static_cast<int>(sources.size()) - 1;
  PANELCAL_TRY(const int i_source, object.integer("source", 0, last));
  point.from.file = sources[static_cast<std::size_t>(i_source)].file;
  return point;
}

Expected<SurfaceModel> read_model(const StrictObject& object, const std::string& file) {
  PANELCAL_TRY(const std::string word, object.text("model"));
  if (const auto model = surface_model(word)) return *model;
  return failure(
      map_file_problem(file,
                       "the model is " + quoted(word),
                       fmt::format("one of {}", fmt::join(surface_model_words(), ", "))));
}

/// In     is_share: one of several, which has a weight as well
Expected<ShapeShare> read_share(const json& value,
                                SurfaceModel model,
                                bool is_share,
                                const std::string& file) {
  std::vector<std::string_view> keys = {"kernel", "length", "strength", "noise_factor", "trend"};
  const bool has_unresolved = value.is_object() && value.contains("unresolved");
  if (has_unresolved) keys.emplace_back("unresolved");
  if (is_share) keys.emplace_back("weight");
  PANELCAL_TRY(const StrictObject object,
               StrictObject::make(value, "the shape", keys, kMapFileCode, file));
  ShapeShare out;
  SurfaceShape& shape = out.shape;
  PANELCAL_TRY(const std::string kernel, object.text("kernel"));
  const auto known = bending_kernel(kernel);
  if (!known) {
    return failure(
        map_file_problem(file,
                         "the kernel is " + quoted(kernel),
                         "none, thin-plate, matern-1/2, matern-3/2, matern-5/2 or gaussian"));
  }
  shape.kernel = *known;
  PANELCAL_TRY(const double length_mm, object.number("length"));
  shape.length = mm(length_mm);
  PANELCAL_TRY(shape.strength_mm2, object.number("strength"));
  PANELCAL_TRY(shape.noise_factor, object.number("noise_factor"));
  PANELCAL_TRY(shape.n_trend, object.integer("trend", 0, kBowTrend));
  if (has_unresolved) {
    PANELCAL_TRY(const double unresolved_mm, object.number("unresolved"));
    shape.unresolved = mm(unresolved_mm);
  }
  if (is_share) {
    PANELCAL_TRY(out.weight, object.number("weight"));
  }
  const bool is_grid = is_of_grid(model);
  if (is_grid ? shape.noise_factor == 1 : shape.noise_factor <= kMostNoise) return out;
  return failure(map_file_problem(file,
                                  fmt::format("the noise factor is {}", shape.noise_factor),
                                  is_grid ? "1: grid models believe their probes"
                                          : fmt::format("above 0, at most {}", kMostNoise)));
}

/// One shape, or an array of what the surface is the average of.
Expected<std::vector<ShapeShare>> read_shapes(const StrictObject& surface,
                                              SurfaceModel model,
                                              const std::string& file) {
  const json& value = surface.member("shape");
  std::vector<ShapeShare> out;
  if (!value.is_array()) {
    PANELCAL_TRY(const ShapeShare whole, read_share(value, model, false, file));
    out.push_back(whole);
    return out;
  }
  for (const json& element : value) {
    PANELCAL_TRY(const ShapeShare share, read_share(element, model, true, file));
    out.push_back(share);
  }
  return out;
}

std::string shape_text(const ShapeShare& share, bool is_share) {
  const SurfaceShape& shape = share.shape;
  std::string out = fmt::format(
      R"({{"kernel": "{}", "length": {}, "strength": {}, "noise_factor": {}, "trend": {})",
      word(shape.kernel),
      shape.length.in_mm(),
      shape.strength_mm2,
      shape.noise_factor,
      shape.n_trend);
  if (shape.unresolved > mm(0)) {
    out += fmt::format(R"(, "unresolved": {})", shape.unresolved.in_mm());
  }
  if (is_share) out += fmt::format(R"(, "weight": {})", share.weight);
  return out + "}";
}

std::string shapes_text(std::span<const ShapeShare> shapes, std::string_view indent) {
  if (shapes.size() == 1) return shape_text(shapes.front(), false);
  std::string out = "[";
  for (const ShapeShare& share : shapes) {
    out += fmt::format("{}\n{}  {}", out.size() > 1 ? "," : "", indent, shape_text(share, true));
  }
  return out + "]";
}

Expected<HeightMapOptions> read_options(const StrictObject& surface, const std::string& file) {
  constexpr std::array<std::string_view, 6> kKeys = {
      "max_extrapolation", "reach", "interpolation", "false_alarm", "most_left_out", "most_noise"};
  PANELCAL_TRY(
      const StrictObject object,
      StrictObject::make(surface.member("options"), "the options", kKeys, kMapFileCode, file));
  HeightMapOptions options;
  PANELCAL_TRY(const double most_mm, object.number("max_extrapolation"));
  options.max_extrapolation = mm(most_mm);
  PANELCAL_TRY(const auto reach_mm, object.numbers("reach", 2));
  options.reach_mm = Eigen::Vector2d(reach_mm[0], reach_mm[1]);
  if (!(options.reach_mm->maxCoeff() <= kMostInMap_mm)) {
    return failure(map_file_problem(file,
                                    fmt::format("reach is {} mm", options.reach_mm->maxCoeff()),
                                    fmt::format("at most {} mm", kMostInMap_mm)));
  }
  PANELCAL_TRY(const std::string interpolation, object.text("interpolation"));
  for (const auto known : {LatticeInterpolation::Bilinear, LatticeInterpolation::MonotoneBicubic}) {
    if (word(known) == interpolation) options.interpolation = known;
  }
  if (word(options.interpolation) != interpolation) {
    return failure(map_file_problem(
        file, "the interpolation is " + quoted(interpolation), "bilinear or monotone-bicubic"));
  }
  PANELCAL_TRY(options.outliers.false_alarm, object.number("false_alarm"));
  PANELCAL_TRY(options.outliers.most, object.number("most_left_out"));
  PANELCAL_TRY(options.outliers.most_noise, object.number("most_noise"));
  return options;
}

/// Their i_point counts in `own`.
Expected<std::vector<SurfaceOutlier>> read_left_out(const StrictObject& surface,
                                                    std::span<const ProbePoint> points,
                                                    std::span<const std::size_t> own,
                                                    const std::string& file) {
  constexpr std::array<std::string_view, 4> kKeys = {"probe", "deviation", "sigma", "chance"};
  PANELCAL_TRY(const auto objects, read_objects(surface, "left_out", "left out", kKeys, file));
  std::vector<SurfaceOutlier> out;
  int next = 0;
  for (const StrictObject& object : objects) {
    SurfaceOutlier outlier;
    const int last = static_cast<int>(points.size()) - 1;
    PANELCAL_TRY(const int i_point, object.integer("probe", next, last));
    next = i_point + 1;
    const ProbePoint& point = points[static_cast<std::size_t>(i_point)];
    const auto found = std::ranges::lower_bound(own, static_cast<std::size_t>(i_point));
    if (found == own.end() || *found != static_cast<std::size_t>(i_point)) {
      return failure(map_file_problem(
          file,
          fmt::format("{} is left out of a zone that it is not in", quoted(name_of(point))),
          "a probe of the zone"));
    }
    outlier.i_point = static_cast<std::size_t>(found - own.begin());
    outlier.name = name_of(point);
    PANELCAL_TRY(const double deviation_mm, object.number("deviation"));
    PANELCAL_TRY(const double sigma_mm, object.number("sigma"));
    PANELCAL_TRY(outlier.chance, object.number("chance"));
    if (!(sigma_mm > 0 && outlier.chance >= 0 && outlier.chance <= 1)) {
      return failure(
          map_file_problem(file,
                           fmt::format("{} has no sigma or no chance", quoted(name_of(point))),
                           "a sigma above 0, a chance of 0 to 1"));
    }
    outlier.deviation = mm(deviation_mm);
    outlier.sigma = mm(sigma_mm);
    out.push_back(std::move(outlier));
  }
  return out;
}

std::string probe_text(const ProbePoint& point, const std::vector<MapSource>& sources) {
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

}  // namespace

Diagnostic map_file_problem(const std::string& file, std::string what, std::string expected) {
  return {kMapFileCode, {file, 0, 0}, std::move(what), std::move(expected)};
}

std::string json_text(const std::string& text) {
  return json(text).dump(-1, ' ', true, json::error_handler_t::replace);
}

std::string list_text(std::string_view key,
                      const std::vector<std::string>& elements,
                      std::string_view indent) {
  if (elements.empty()) return fmt::format("{}\"{}\": []", indent, key);
  const std::string between = fmt::format(",\n{}  ", indent);
  return fmt::format("{0}\"{1}\": [\n{0}  {2}\n{0}]", indent, key, fmt::join(elements, between));
}

Expected<std::vector<StrictObject>> read_objects(const StrictObject& top,
                                                 std::string_view key,
                                                 std::string_view what,
                                                 std::span<const std::string_view> keys,
                                                 const std::string& file) {
  const json& list = top.member(key);
  if (!list.is_array()) {
    return failure(
        map_file_problem(file, fmt::format("{} is no array", quoted(key)), "[{...}, ...]"));
  }
  std::vector<StrictObject> out;
  for (const json& element : list) {
    PANELCAL_TRY(StrictObject object,
                 StrictObject::make(
                     element, fmt::format("{} {}", what, out.size()), keys, kMapFileCode, file));
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

std::vector<std::string> source_texts(const std::vector<MapSource>& sources) {
  std::vector<std::string> out;
  for (const MapSource& source : sources) {
    out.push_back(fmt::format(
        R"({{"file": {}, "sha256": {}}})", json_text(source.file), json_text(source.sha256)));
  }
  return out;
}

Expected<std::vector<ProbePoint>> read_probes(const StrictObject& top,
                                              const std::vector<MapSource>& sources,
                                              const std::string& file) {
  constexpr std::array<std::string_view, 6> kKeys = {
      "name", "place", "height", "sigma", "source", "line"};
  PANELCAL_TRY(const auto objects, read_objects(top, "probes", "probe", kKeys, file));
  std::vector<ProbePoint> out;
  for (const StrictObject& object : objects) {
    PANELCAL_TRY(ProbePoint point, read_probe(object, sources, file));
    out.push_back(std::move(point));
  }
  return out;
}

std::vector<std::string> probe_texts(const std::vector<ProbePoint>& points,
                                     const std::vector<MapSource>& sources) {
  std::vector<std::string> out;
  for (const ProbePoint& point : points) out.push_back(probe_text(point, sources));
  return out;
}

Expected<HeightMap> read_surface(const StrictObject& object,
                                 std::span<const ProbePoint> points,
                                 std::span<const std::size_t> own,
                                 const std::string& file) {
  PANELCAL_TRY(const SurfaceModel model, read_model(object, file));
  PANELCAL_TRY(std::string reason, object.text("reason"));
  PANELCAL_TRY(const auto shapes, read_shapes(object, model, file));
  PANELCAL_TRY(const HeightMapOptions options, read_options(object, file));
  PANELCAL_TRY(auto outliers, read_left_out(object, points, own, file));
  // Before anything is solved: of more no surface was made.
  const std::size_t most = is_of_grid(model) ? kMostGridProbes : kMostBentProbes;
  if (own.size() > most) {
    return failure(map_file_problem(file,
                                    fmt::format("{} probes of one surface", own.size()),
                                    fmt::format("at most {} for {}", most, word(model))));
  }
  std::vector<ProbePoint> all, fitted;
  std::vector<std::size_t> kept;
  auto next = outliers.begin();
  for (std::size_t k = 0; k < own.size(); ++k) {
    all.push_back(points[own[k]]);
    if (next != outliers.end() && next->i_point == k) {
      ++next;
      continue;
    }
    kept.push_back(k);
    fitted.push_back(points[own[k]]);
  }
  auto made = [&]() -> Expected<HeightMap> {
    PANELCAL_TRY(SurfaceFit fit, fit_surface(fitted, model, shapes));
    if (!outliers.empty()) fit = fit.with(possible_bends(all, kept, outliers));
    SoundSurface surface{std::move(fit), std::move(kept), std::move(outliers)};
    return HeightMap::of_surface(all, {std::move(surface), std::move(reason)}, options);
  }();
  if (made) return made;
  // Whatever it is, the map's file is what must be mended.
  Diagnostic problem = std::move(made).error();
  problem.place = {file, 0, 0};
  return failure(std::move(problem));
}

std::string surface_text(const HeightMap& map, std::string_view indent) {
  const HeightMapOptions options = map.options();
  return fmt::format(
      R"({0}"model": "{1}",
{0}"reason": {2},
{0}"shape": {3},
{0}"options": {{"max_extrapolation": {4}, "reach": [{5}, {6}], "interpolation": "{7}", "false_alarm": {8}, "most_left_out": {9}, "most_noise": {10}}})",
      indent,
      word(map.surface().model()),
      json_text(map.reason()),
      shapes_text(map.surface().shapes(), indent),
      options.max_extrapolation.in_mm(),
      options.reach_mm->x(),
      options.reach_mm->y(),
      word(options.interpolation),
      options.outliers.false_alarm,
      options.outliers.most,
      options.outliers.most_noise);
}

std::vector<std::string> left_out_texts(const HeightMap& map, std::span<const std::size_t> own) {
  std::vector<std::string> out;
  for (const SurfaceOutlier& outlier : map.outliers()) {
    out.push_back(fmt::format(R"({{"probe": {}, "deviation": {}, "sigma": {}, "chance": {}}})",
                              own[outlier.i_point],
                              outlier.deviation.in_mm(),
                              outlier.sigma.in_mm(),
                              outlier.chance));
  }
  return out;
}

}  // namespace panelcal::internal
