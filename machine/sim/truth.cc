// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/truth.h"

#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "calib/base/fields/json.h"
#include "calib/base/fields/slots.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/json/strict_json.h"
#include "calib/base/statistics/random.h"
#include "machine/config/json_files.h"
#include "machine/sim/random_streams.h"
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// A map as the file has it.
struct TruthMap {
  Eigen::Matrix2d linear = Eigen::Matrix2d::Identity();
  Eigen::Vector2d translation_mm = Eigen::Vector2d::Zero();
};

struct TruthInstance {
  InstancePath path;
  TruthMap map;
};

struct TruthFile {
  Truth truth;  ///< but its maps
  TruthMap panel;
  std::vector<TruthInstance> instances;
};

#include "machine/sim/truth.def"

Diagnostic invalid_truth(const std::string& file, std::string what, std::string expected) {
  return {Code::TruthInvalid, {file, 0, 0}, std::move(what), std::move(expected)};
}

Expected<Transform<frame::Actual, frame::Nominal>> map_of(const TruthMap& read,
                                                          const std::string& name,
                                                          const std::string& file) {
  const double determinant = read.linear.determinant();
  if (!std::isfinite(determinant) || determinant == 0) {
    return failure(
        invalid_truth(file, "\"linear\" of " + name + " is singular", "a map with an inverse"));
  }
  return Transform<frame::Actual, frame::Nominal>(read.linear, read.translation_mm);
}

/// Puts the maps together, and checks what the rows cannot express.
Expected<Truth> truth_of(TruthFile read, const std::string& file) {
  Truth& truth = read.truth;
  PANELCAL_TRY(truth.panel, map_of(read.panel, "panel", file));
  for (std::size_t i = 0; i < read.instances.size(); ++i) {
    const std::string name = fmt::format("instance {}", i);
    PANELCAL_TRY(const auto map, map_of(read.instances[i].map, name, file));
    if (!truth.instances.emplace(std::move(read.instances[i].path), map).second) {
      return failure(invalid_truth(file, name + " has the path of another one", "each path once"));
    }
  }
  std::set<std::int64_t> seen;
  for (std::size_t i = 0; i < truth.targets.size(); ++i) {
    if (seen.insert(truth.targets[i].seq).second) continue;
    return failure(invalid_truth(
        file, fmt::format("target {} has the seq of another one", i), "each seq once"));
  }
  return std::move(truth);
}

}  // namespace

JsonFile truth_file() {
  return {
      "truth.json",
      "The truth of a simulated panel: `panelcal synth` writes it, `run --truth` compares with it.",
      {&kTruthDocument}};
}

}  // namespace panelcal::internal

namespace panelcal {
namespace {

using Map = Transform<frame::Actual, frame::Nominal>;

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
  internal::TruthFile file = {truth, {truth.panel.linear(), truth.panel.translation()}, {}};
  for (const auto& [path, map] : truth.instances) {
    file.instances.push_back({path, {map.linear(), map.translation()}});
  }
  return internal::json_text(internal::kTruthDocument, file, internal::JsonStyle::Compact) + "\n";
}

Expected<void> write_truth_json(const std::filesystem::path& path, const Truth& truth) {
  return write_file(path, truth_text(truth));
}

Expected<Truth> parse_truth(std::string_view text, const std::string& file) {
  PANELCAL_TRY(const nlohmann::json document, internal::parse_strict_json(text, file));
  PANELCAL_TRY(auto read,
               internal::read_json(internal::kTruthDocument, document, Code::TruthInvalid, file));
  return internal::truth_of(std::move(read), file);
}

Expected<Truth> read_truth_json(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxTruthBytes));
  return parse_truth(text, path.string());
}

}  // namespace panelcal
