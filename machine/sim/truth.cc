// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/truth.h"

#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <utility>

#include "calib/base/append_format.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/json/strict_json.h"
#include "calib/base/statistics/random.h"
#include "machine/sim/random_streams.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::StrictObject;
using Map = Transform<frame::Actual, frame::Nominal>;

constexpr Code kTruthCode = Code::TruthInvalid;
constexpr int kVersion = 1;
constexpr std::array<std::string_view, 7> kErringKeys = {
    "kind", "version", "seed", "panel", "instances", "targets", "table"};
constexpr std::size_t kTruthFileKeys = 6;  // of those above
constexpr std::array<std::string_view, 2> kMapKeys = {"linear", "translation_mm"};
constexpr std::array<std::string_view, 3> kInstanceKeys = {"path", "linear", "translation_mm"};
constexpr std::array<std::string_view, 5> kTruthTableKeys = {
    "scale_ppm", "squareness_urad", "bow_um", "bow_radius_mm", "center_mm"};
constexpr std::array<std::string_view, 4> kRingKeys = {"seq", "nominal", "actual", "hole_offset"};
constexpr std::size_t kTargetKeys = 3;  // of those above

Eigen::Matrix2d rotation(double angle_rad) {
  Eigen::Matrix2d r;
  r << std::cos(angle_rad), -std::sin(angle_rad), std::sin(angle_rad), std::cos(angle_rad);
  return r;
}

Map panel_map(const SimConfig& sim) {
  Eigen::Matrix2d stretch = Eigen::Matrix2d::Identity();
  stretch(0, 0) += sim.stretch_x_ppm * 1e-6;
  stretch(1, 1) += sim.stretch_y_ppm * 1e-6;
  const Eigen::Matrix2d linear = rotation(sim.panel_rotation.in_rad()) * stretch;
  return Map(linear, sim.panel_offset.in_mm());
}

/// Pose of a board on the panel: turned about its first target, then shifted.
Transform<frame::Nominal, frame::Nominal> board_map(const SimConfig& sim,
                                                    const MeasurementRequest& first) {
  Random random = internal::random_of(sim.seed, internal::RandomStream::Boards, first.seq);
  const double angle_rad = sim.board_rotation_sigma.in_rad() * random.normal();
  const double dx_mm = sim.board_offset_sigma.in_mm() * random.normal();
  const double dy_mm = sim.board_offset_sigma.in_mm() * random.normal();
  const Eigen::Matrix2d turn = rotation(angle_rad);
  const Eigen::Vector2d& pivot_mm = first.nominal.in_mm();
  const Eigen::Vector2d shift_mm = pivot_mm - turn * pivot_mm + Eigen::Vector2d(dx_mm, dy_mm);
  return {turn, shift_mm};
}

void append_map(std::string& out, const Map& map) {
  const Eigen::Matrix2d& a = map.linear();
  const Eigen::Vector2d& t = map.translation();
  internal::append_format(out,
                          "\"linear\":[[{},{}],[{},{}]],\"translation_mm\":[{},{}]",
                          a(0, 0),
                          a(0, 1),
                          a(1, 0),
                          a(1, 1),
                          t.x(),
                          t.y());
}

Diagnostic invalid_truth(const std::string& file, std::string what, std::string expected) {
  return {kTruthCode, {file, 0, 0}, std::move(what), std::move(expected)};
}

Expected<Map> read_map(const StrictObject& object,
                       const std::string& name,
                       const std::string& file) {
  PANELCAL_TRY(const std::vector<double> a, object.matrix("linear", 2, 2));
  PANELCAL_TRY(const std::vector<double> t, object.numbers("translation_mm", 2));
  Eigen::Matrix2d linear;
  linear << a[0], a[1], a[2], a[3];
  const double determinant = a[0] * a[3] - a[1] * a[2];
  if (!std::isfinite(determinant) || determinant == 0) {
    return failure(
        invalid_truth(file, "\"linear\" of " + name + " is singular", "a map with an inverse"));
  }
  return Map(linear, Eigen::Vector2d(t[0], t[1]));
}

Expected<InstancePath> read_path(const StrictObject& object,
                                 const std::string& name,
                                 const std::string& file) {
  InstancePath path;
  const nlohmann::json& array = object.member("path");
  bool is_path = array.is_array();
  for (const nlohmann::json& index : is_path ? array : nlohmann::json::array()) {
    is_path =
        index.is_number_unsigned() && index.get<std::uint64_t>() <= std::numeric_limits<int>::max();
    if (!is_path) break;
    path.push_back(index.get<int>());
  }
  if (is_path) return path;
  return failure(invalid_truth(
      file, "\"path\" of " + name + " is " + quoted(array.dump()), "whole numbers from 0"));
}

Expected<std::uint64_t> read_whole(const StrictObject& object,
                                   std::string_view key,
                                   std::uint64_t high,
                                   const std::string& name,
                                   const std::string& file) {
  const nlohmann::json& value = object.member(key);
  if (value.is_number_unsigned() && value.get<std::uint64_t>() <= high) {
    return value.get<std::uint64_t>();
  }
  return failure(invalid_truth(file,
                               quoted(key) + " of " + name + " is " + quoted(value.dump()),
                               fmt::format("a whole number from 0 to {}", high)));
}

Expected<void> read_instances(const nlohmann::json& array, const std::string& file, Truth& truth) {
  if (!array.is_array()) return failure(invalid_truth(file, "\"instances\" is no array", "[...]"));
  for (std::size_t i = 0; i < array.size(); ++i) {
    const std::string name = fmt::format("instance {}", i);
    PANELCAL_TRY(const StrictObject object,
                 StrictObject::make(array[i], name, kInstanceKeys, kTruthCode, file));
    PANELCAL_TRY(const InstancePath path, read_path(object, name, file));
    PANELCAL_TRY(const Map map, read_map(object, name, file));
    if (!truth.instances.emplace(path, map).second) {
      return failure(invalid_truth(file, name + " has the path of another one", "each path once"));
    }
  }
  return {};
}

Expected<void> read_targets(const nlohmann::json& array, const std::string& file, Truth& truth) {
  if (!array.is_array()) return failure(invalid_truth(file, "\"targets\" is no array", "[...]"));
  std::set<std::uint64_t> seen;
  for (std::size_t i = 0; i < array.size(); ++i) {
    const std::string name = fmt::format("target {}", i);
    const bool is_ring = array[i].is_object() && array[i].contains("hole_offset");
    const auto keys = std::span(kRingKeys.data(), is_ring ? kRingKeys.size() : kTargetKeys);
    PANELCAL_TRY(const StrictObject object,
                 StrictObject::make(array[i], name, keys, kTruthCode, file));
    PANELCAL_TRY(const std::uint64_t seq,
                 read_whole(object, "seq", std::numeric_limits<std::int64_t>::max(), name, file));
    if (!seen.insert(seq).second) {
      return failure(invalid_truth(file, name + " has the seq of another one", "each seq once"));
    }
    PANELCAL_TRY(const std::vector<double> nominal_mm, object.numbers("nominal", 2));
    PANELCAL_TRY(const std::vector<double> actual_mm, object.numbers("actual", 2));
    truth.targets.push_back({static_cast<std::int64_t>(seq),
                             position_mm<frame::Nominal>(nominal_mm[0], nominal_mm[1]),
                             position_mm<frame::Actual>(actual_mm[0], actual_mm[1])});
    if (!is_ring) continue;
    PANELCAL_TRY(const std::vector<double> hole_mm, object.numbers("hole_offset", 2));
    truth.targets.back().hole_offset = displacement_mm<frame::Actual>(hole_mm[0], hole_mm[1]);
  }
  return {};
}

Expected<SimTable> read_truth_table(const nlohmann::json& json, const std::string& file) {
  PANELCAL_TRY(const StrictObject object,
               StrictObject::make(json, "table", kTruthTableKeys, kTruthCode, file));
  SimTable table;
  PANELCAL_TRY(const std::vector<double> scale_ppm, object.numbers("scale_ppm", 2));
  table.scale_x_ppm = scale_ppm[0];
  table.scale_y_ppm = scale_ppm[1];
  PANELCAL_TRY(const double urad, object.number("squareness_urad"));
  table.squareness = rad(urad * 1e-6);
  PANELCAL_TRY(const std::vector<double> bow_um, object.numbers("bow_um", 2));
  table.bow_x = um(bow_um[0]);
  table.bow_y = um(bow_um[1]);
  PANELCAL_TRY(const double radius_mm, object.number("bow_radius_mm"));
  table.bow_radius = mm(radius_mm);
  if (!(radius_mm > 0)) {
    return failure(invalid_truth(
        file, fmt::format("\"bow_radius_mm\" of table is {}", radius_mm), "a number above 0"));
  }
  PANELCAL_TRY(const std::vector<double> center_mm, object.numbers("center_mm", 2));
  table.center = position_mm<frame::Machine>(center_mm[0], center_mm[1]);
  return table;
}

std::string table_text(const SimTable& table) {
  return fmt::format(
      "\"table\":{{\"scale_ppm\":[{},{}],\"squareness_urad\":{},\"bow_um\":[{},{}],"
      "\"bow_radius_mm\":{},\"center_mm\":[{},{}]}}",
      table.scale_x_ppm,
      table.scale_y_ppm,
      table.squareness.in_rad() * 1e6,
      table.bow_x.in_um(),
      table.bow_y.in_um(),
      table.bow_radius.in_mm(),
      table.center.in_mm().x(),
      table.center.in_mm().y());
}

}  // namespace

const Map& Truth::actual_from_nominal(std::span<const int> path) const {
  const auto found = instances.find(InstancePath(path.begin(), path.end()));
  return found == instances.end() ? panel : found->second;
}

Truth make_truth(const SimConfig& sim, std::span<const MeasurementRequest> requests) {
  Truth truth;
  truth.seed = sim.seed;
  truth.panel = panel_map(sim);
  truth.table = sim.table;
  for (const MeasurementRequest& request : requests) {
    if (!request.path.empty() && !truth.instances.contains(request.path)) {
      truth.instances.emplace(request.path, truth.panel * board_map(sim, request));
    }
    const Map& map = truth.actual_from_nominal(request.path);
    truth.targets.push_back({request.seq, request.nominal, map(request.nominal)});
  }
  return truth;
}

std::string truth_text(const Truth& truth) {
  std::string out;
  internal::append_format(
      out, "{{\"kind\":\"truth\",\"version\":{},\"seed\":{},\n\"panel\":{{", kVersion, truth.seed);
  append_map(out, truth.panel);
  out += "},\n\"instances\":[";
  std::string_view separator = "\n";
  for (const auto& [path, map] : truth.instances) {
    internal::append_format(out, "{}{{\"path\":[{}],", separator, fmt::join(path, ","));
    append_map(out, map);
    out += '}';
    separator = ",\n";
  }
  out += "],\n\"targets\":[";
  separator = "\n";
  for (const Truth::Target& target : truth.targets) {
    const Eigen::Vector2d& nominal_mm = target.nominal.in_mm();
    const Eigen::Vector2d& actual_mm = target.actual.in_mm();
    internal::append_format(out,
                            "{}{{\"seq\":{},\"nominal\":[{},{}],\"actual\":[{},{}]",
                            separator,
                            target.seq,
                            nominal_mm.x(),
                            nominal_mm.y(),
                            actual_mm.x(),
                            actual_mm.y());
    if (target.hole_offset) {
      const Eigen::Vector2d& hole_mm = target.hole_offset->in_mm();
      internal::append_format(out, ",\"hole_offset\":[{},{}]", hole_mm.x(), hole_mm.y());
    }
    out += '}';
    separator = ",\n";
  }
  out += ']';
  if (truth.table) out += ",\n" + table_text(*truth.table);
  return out + "}\n";
}

Expected<void> write_truth_json(const std::filesystem::path& path, const Truth& truth) {
  return write_file(path, truth_text(truth));
}

Expected<Truth> parse_truth(std::string_view text, const std::string& file) {
  PANELCAL_TRY(const nlohmann::json document, internal::parse_strict_json(text, file));
  const bool errs = document.is_object() && document.contains("table");
  const auto keys = std::span(kErringKeys.data(), errs ? kErringKeys.size() : kTruthFileKeys);
  PANELCAL_TRY(const StrictObject top,
               StrictObject::make(document, "the truth", keys, kTruthCode, file));
  PANELCAL_CHECK(top.constant("kind", "truth"));
  PANELCAL_CHECK(top.integer("version", kVersion, kVersion));
  Truth truth;
  PANELCAL_TRY(
      truth.seed,
      read_whole(top, "seed", std::numeric_limits<std::uint64_t>::max(), "the truth", file));
  PANELCAL_TRY(const StrictObject panel,
               StrictObject::make(top.member("panel"), "panel", kMapKeys, kTruthCode, file));
  PANELCAL_TRY(truth.panel, read_map(panel, "panel", file));
  PANELCAL_CHECK(read_instances(top.member("instances"), file, truth));
  PANELCAL_CHECK(read_targets(top.member("targets"), file, truth));
  if (errs) {
    PANELCAL_TRY(truth.table, read_truth_table(top.member("table"), file));
  }
  return truth;
}

Expected<Truth> read_truth_json(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxTruthBytes));
  return parse_truth(text, path.string());
}

}  // namespace panelcal
